"""RRT* as a fair baseline."""

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.baselines.rrt_star import grown, neighbourhood, rrt_star
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.driven_path.chords import Ground
from social_fleet.planning.lattice import Lattice, fitting_radius
from social_fleet.planning.planner import SocialPlanner

GRID = grid_from_text("\n".join(["." * 40] * 15 + ["." * 18 + "####" + "." * 18] * 10 + ["." * 40] * 15), 0.2)
SPACE = ConfigurationSpace(GRID, 0.25)
GROUND = Ground(GRID.blocked, SPACE.clearance, GRID.resolution, fitting_radius(SPACE), np.zeros((0, 3)))
LATTICE = Lattice(SPACE)
FREE = LATTICE.centres(np.arange(len(LATTICE)))
START, GOAL = (5.5, 20.5), (34.5, 20.5)


def solve(samples, seed=1, ground=GROUND):
    return rrt_star(ground, FREE, START, GOAL, samples=samples, step=10.0, seed=seed)


def length(points):
    return np.hypot(*np.diff(points, axis=0).T).sum()


def test_a_path_is_free_and_joins_its_ends():
    points = solve(1000)
    assert tuple(points[0]) == START and tuple(points[-1]) == GOAL
    assert SPACE.is_free_path(points * 0.2)


def test_it_improves_with_its_budget_towards_the_optimum():
    lengths = [np.mean([length(solve(samples, seed)) for seed in range(5)]) for samples in (100, 1000, 5000)]
    assert lengths[0] > lengths[1] > lengths[2]
    best = 2.0 * np.hypot(12.5, 6.2) + 4.0  # over the two corners of the block, kept a radius away
    assert lengths[2] < 1.03 * best


@pytest.mark.parametrize("seed", range(4))
def test_a_larger_budget_never_costs_more(seed):
    lengths = [length(solve(samples, seed)) for samples in (50, 100, 200, 400, 800, 1600, 3200)]
    assert all(later <= earlier + 1e-9 for earlier, later in zip(lengths, lengths[1:]))


def test_in_an_open_world_the_path_becomes_straight():
    open_world = GROUND._replace(blocked=np.zeros_like(GRID.blocked), clearance=np.full(GRID.shape, 2.0, np.float32))
    straight = GOAL[0] - START[0]
    assert np.mean([length(solve(4000, seed, open_world)) for seed in range(3)]) < 1.01 * straight


def test_a_late_path_is_rewired_as_long_as_it_was_searched_for():
    def tree(samples):
        return grown(GROUND, FREE, START, GOAL, samples=samples, step=10.0, seed=5)

    (_, few, end), (_, more, _) = tree(2), tree(8)
    assert few == more > 8 and end > 0  # the budget was too small for any path, so the search decides when to end
    assert tree(200)[1] > few


def test_the_neighbourhood_shrinks_and_never_exceeds_the_step():
    radii = [neighbourhood(count, 1000.0, 8.0) for count in (2, 100, 1000, 10000, 100000)]
    assert radii[0] == 8.0 and all(later <= earlier for earlier, later in zip(radii, radii[1:]))
    assert radii[-1] == pytest.approx(1.1 * np.sqrt(6.0 * 1000.0 / np.pi) * np.sqrt(np.log(1e5) / 1e5))


def test_costs_in_the_tree_are_the_ways_from_its_root():
    """What rewiring saved has reached every descendant."""
    tree, count = grown(GROUND, FREE, START, GOAL, samples=2000, step=10.0, seed=3)[:2]
    way = np.zeros(count)
    for v in np.argsort(tree.cost[:count], kind="stable")[1:]:
        parent = tree.parent[v]
        way[v] = way[parent] + np.hypot(tree.x[v] - tree.x[parent], tree.y[v] - tree.y[parent])
        assert SPACE.is_free_path(0.2 * np.array([(tree.x[parent], tree.y[parent]), (tree.x[v], tree.y[v])]))
    np.testing.assert_allclose(tree.cost[:count], way, atol=1e-6)


def test_the_seed_decides():
    np.testing.assert_array_equal(solve(500), solve(500))
    assert length(solve(500, seed=2)) != length(solve(500, seed=3))


def test_there_is_no_path_through_a_wall():
    blocked = GRID.blocked.copy()
    blocked[:, 20] = True
    assert solve(100, ground=GROUND._replace(blocked=blocked, clearance=np.zeros_like(SPACE.clearance))) is None


def test_as_a_planner():
    planner = SocialPlanner(GRID, PlannerConfig())
    plan = planner.plan((1.1, 4.1), (6.9, 4.1), planner="rrt_star")
    assert planner.space.is_free_path(plan.points)
    assert plan.cost >= planner.plan((1.1, 4.1), (6.9, 4.1)).cost - 1e-9
    assert plan.length == pytest.approx(planner.plan((1.1, 4.1), (6.9, 4.1), planner="shortest").length, rel=0.1)
