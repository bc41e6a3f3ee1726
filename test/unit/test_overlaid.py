"""Maps with obstacles drawn in, judged by the configuration space of a map that holds them."""

import math

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.errors import InvalidGoal, InvalidOverlay, InvalidStart, NoPath
from social_fleet.geometry import Pose
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.mapping.walls import HEADINGS
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.overlays.overlay_set import OverlaySet
from social_fleet.planning.overlays.overlaid import OverlaidMaps
from social_fleet.planning.overlays.raster import drawn_on
from social_fleet.planning.overlays.shapes import Cells, DiscObstacle, Polygon, Rectangle
from social_fleet.planning.lattice import Lattice
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import random_pose_pairs

HALL = OccupancyGrid(np.pad(np.zeros((44, 94), dtype=np.int8), 3, constant_values=100), 0.1, Pose(2.0, -1.0, 0.4))
OBSTACLES = {"cart": Rectangle(4.6, 2.9, 0.7, 0.4, 0.9), "pillar": DiscObstacle(6.5, 4.0, 0.3),
             "tarpaulin": Polygon(((2.2, 0.2), (3.1, 0.4), (2.6, 0.9), (2.5, 0.5))),
             "boxes": Cells.of(HALL, [(20, 60), (20, 61), (40, 90), (2, 50)])}


def maps_of(grid, radius, margin):
    space, way = ConfigurationSpace(grid, radius), ConfigurationSpace(grid, radius + margin)
    lattice = Lattice(way)
    return OverlaidMaps(space, way, lattice), lattice


@pytest.mark.parametrize("radius, margin", [(0.25, 0.03), (0.3, 0.0), (0.11, 0.02), (2.2, 0.0)])
def test_the_arrays_are_those_of_a_map_with_the_obstacles(radius, margin):
    maps, lattice = maps_of(HALL, radius, margin)
    overlaid = maps.of(OBSTACLES)
    judge = ConfigurationSpace(drawn_on(HALL, OBSTACLES.values()), radius)
    np.testing.assert_array_equal(overlaid.blocked, judge.grid.blocked)
    np.testing.assert_allclose(overlaid.clearance, judge.clearance, atol=1e-6)


@pytest.mark.parametrize("radius, margin", [(0.25, 0.03), (0.3, 0.0), (0.11, 0.02)])
def test_every_edge_that_is_left_can_be_driven_and_no_node_is_closed_for_nothing(radius, margin):
    maps, lattice = maps_of(HALL, radius, margin)
    judge = ConfigurationSpace(drawn_on(HALL, OBSTACLES.values()), radius + margin)
    closed = np.zeros(len(lattice), dtype=bool)
    closed[maps.of(OBSTACLES).closed] = True
    assert judge.free[lattice.row[~closed], lattice.col[~closed]].all()
    for node in range(len(lattice)):
        cell = np.array([lattice.row[node], lattice.col[node]])
        free = []
        for heading, (across, along) in enumerate(HEADINGS):
            if lattice.edges[node] >> heading & 1:
                free.append(judge.is_free_path(HALL.centres([cell, cell + (along, across)])))
                other = lattice.node[cell[0] + along, cell[1] + across]
                assert free[-1] or closed[node] or closed[other]
        if closed[node] and judge.free[tuple(cell)]:
            assert not all(free)


def test_the_map_far_from_the_obstacles_stays_as_it_is():
    maps, lattice = maps_of(HALL, 0.25, 0.03)
    plain, overlaid = maps.of(()), maps.of([Cells.of(HALL, [(10, 10)])])
    changed = np.argwhere(plain.clearance != overlaid.clearance)
    assert np.abs(changed - (10, 10)).max() <= 21  # the 2 m that clearances are told up to
    assert not len(plain.closed) and plain.blocked is HALL.blocked


def test_arrays_are_remembered_per_set_of_obstacles():
    maps, _ = maps_of(HALL, 0.25, 0.03)
    overlays = OverlaySet(HALL)
    overlays.add("cart", OBSTACLES["cart"])
    first = maps.of(overlays)
    assert maps.of(overlays) is first
    overlays.add("pillar", OBSTACLES["pillar"])
    assert maps.of(overlays) is not first
    overlays.remove("pillar")
    assert maps.of(overlays) is first


def test_an_obstacle_off_the_map_is_refused_by_its_name():
    maps, _ = maps_of(HALL, 0.25, 0.03)
    with pytest.raises(InvalidOverlay, match="off the map") as caught:
        maps.of({"moon": DiscObstacle(500.0, 0.0, 1.0)})
    assert caught.value.field == "moon"


@pytest.mark.parametrize("kind", ["social", "shortest", "rrt_star"])
def test_plans_keep_clear_of_obstacles(kind):
    planner = SocialPlanner(HALL)
    judge = ConfigurationSpace(drawn_on(HALL, OBSTACLES.values()), 0.25)
    planned = 0
    for start, goal in random_pose_pairs(planner, 40, seed=4):
        try:
            plan = planner.plan(start, goal, planner=kind, overlays=OBSTACLES)
        except (InvalidStart, InvalidGoal, NoPath):
            continue
        planned += 1
        assert judge.is_free_path(plan.points)
        np.testing.assert_array_equal(plan.points[[0, -1]], [start, goal])
    assert planned > 20


def test_random_obstacles_in_random_places():
    planner = SocialPlanner(HALL)
    random = np.random.RandomState(8)
    planned = 0
    for start, goal in random_pose_pairs(planner, 60, seed=9):
        x, y = planner.grid.from_local([random.uniform((1.0, 0.5), (9.0, 4.5))])[0]
        shape = Rectangle(x, y, *random.uniform(0.2, 1.5, 2), random.uniform(0.0, 7.0))
        try:
            plan = planner.plan(start, goal, overlays=[shape])
        except (InvalidStart, InvalidGoal, NoPath):
            continue
        planned += 1
        places = plan.path.position(np.linspace(0.0, plan.length, 500))
        assert shape.distances(places).min() >= 0.25 - 1e-6
    assert planned > 40


def test_a_start_or_goal_by_an_obstacle_says_which():
    planner = SocialPlanner(HALL)
    pillar, beside = (6.5, 4.0), (6.5 + 0.5, 4.0)
    with pytest.raises(InvalidGoal, match="lies in the obstacle 'pillar'"):
        planner.plan((3.0, 2.0), pillar, overlays=OBSTACLES)
    with pytest.raises(InvalidStart, match=r"0\.\d\d m from the obstacle 'pillar', closer than .* 0.25 m"):
        planner.plan(beside, (3.0, 2.0), overlays=OBSTACLES)
    planner.plan(beside, (3.0, 2.0))


def test_only_plans_near_an_obstacle_are_temporary():
    planner = SocialPlanner(HALL, PlannerConfig(temporary_distance=1.0))
    for start, goal in random_pose_pairs(planner, 15, seed=3):
        try:
            plan = planner.plan(start, goal, overlays=OBSTACLES)
        except (InvalidStart, InvalidGoal, NoPath):
            continue
        places = plan.path.position(np.linspace(0.0, plan.length, 2000))
        near = [name for name, shape in OBSTACLES.items() if shape.distances(places).min() <= 1.0]
        assert plan.obstacles == tuple(near) and plan.temporary is bool(near)
        assert not planner.plan(start, goal).temporary
    for distance, expected in ((0.9, False), (1.1, True)):
        straight = SocialPlanner(HALL, PlannerConfig(side="none", temporary_distance=distance))
        ends = HALL.from_local([(1.0, 1.0), (9.0, 1.0)])
        there = HALL.from_local([(5.0, 2.5)])[0]
        plan = straight.plan(*ends, overlays=[DiscObstacle(there[0], there[1], 0.5)])
        assert plan.temporary is expected


def test_plans_near_a_permanent_obstacle_are_not_temporary():
    planner = SocialPlanner(HALL)
    overlays = OverlaySet(HALL)
    overlays.add("cart", OBSTACLES["cart"])
    assert planner.plan((3.0, 2.0), (9.0, 5.0), overlays=overlays).obstacles == ("cart",)
    overlays.make_permanent("cart")
    assert not planner.plan((3.0, 2.0), (9.0, 5.0), overlays=overlays).temporary


def test_an_obstacle_that_fills_the_way_leaves_no_path():
    planner = SocialPlanner(grid_from_text("""
        ##########
        #........#
        #........#
        #........#
        ##########
    """, 0.5))
    planner.plan((1.0, 1.0), (4.0, 1.0))
    with pytest.raises(NoPath, match="round 1 obstacle"):
        planner.plan((1.0, 1.0), (4.0, 1.0), overlays=[Rectangle(2.5, 1.25, 0.5, 1.0)])


def test_the_old_path_is_back_when_the_obstacle_is_gone():
    planner = SocialPlanner(HALL)
    before = planner.plan((3.0, 2.0), (9.0, 5.0))
    x, y = before.path.position(0.5 * before.length)
    detour = planner.plan((3.0, 2.0), (9.0, 5.0), overlays=[DiscObstacle(x, y, 0.3)])
    assert detour.temporary and detour.cost > before.cost
    np.testing.assert_array_equal(planner.plan((3.0, 2.0), (9.0, 5.0)).points, before.points)


def test_a_start_in_a_corner_that_an_obstacle_cuts_off_takes_the_way_that_is_left():
    """The start's nearest node is walled in by the obstacle, another that it reaches is not."""
    grid = OccupancyGrid(np.pad(np.zeros((30, 60), dtype=np.int8), 2, constant_values=100), 0.1)
    planner = SocialPlanner(grid, PlannerConfig(wall_margin=0.1))
    judge_of = drawn_on(grid, [Rectangle(2.0, 2.1, 0.2, 2.2)])
    judge = ConfigurationSpace(judge_of, 0.25)
    for y in np.arange(0.46, 2.9, 0.11):
        for start in ((1.64, y), (2.36, y)):
            plan = planner.plan(start, (5.0, 1.7), overlays=[Rectangle(2.0, 2.1, 0.2, 2.2)])
            assert judge.is_free_path(plan.points)
    assert math.isclose(plan.points[-1][0], 5.0)
