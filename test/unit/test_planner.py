"""The planner as its users see it."""

import math
import threading

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.errors import InvalidGoal, InvalidParameter, InvalidStart, NoPath
from social_fleet.geometry import Polyline, Pose
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.overlays.discs import Disc
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import random_pose_pairs


def corridor(width, length=100, resolution=0.1, origin=(0.0, 0.0, 0.0)):
    """A corridor along the columns, `width` cells wide, between two walls of 3 cells."""
    values = np.zeros((width + 6, length), dtype=np.int8)
    values[:3] = values[-3:] = 100
    return OccupancyGrid(values, resolution, Pose(*origin))


def rooms(seed=11):
    """Twelve rooms with doors of a metre and clutter on the floor, at 0.1 m."""
    random = np.random.RandomState(seed)
    values = np.zeros((120, 160), dtype=np.int8)
    values[[0, 1, 39, 40, 79, 80, -2, -1]] = 100
    values[:, [0, 1, 39, 40, 79, 80, 119, 120, -2, -1]] = 100
    for row in (39, 79):
        for column in (15, 55, 95, 135):
            values[row:row + 2, column:column + 10] = 0
    for column in (39, 79, 119):
        for row in (15, 55, 95):
            values[row:row + 10, column:column + 2] = 0
    values[random.rand(120, 160) < 0.003] = 100
    return OccupancyGrid(values, 0.1)


ROOMS = SocialPlanner(rooms())


def turns(points):
    return np.abs(np.angle(np.exp(1j * np.diff(Polyline(points).segment_headings))))


def heights(plan, low, high):
    """y of the path where its x lies within [low, high]."""
    path = plan.path.position(np.linspace(0.0, plan.length, 500))
    return path[(path[:, 0] >= low) & (path[:, 0] <= high), 1]


@pytest.mark.parametrize("planner", ["social", "shortest"])
def test_paths_are_drivable(planner):
    for start, goal in random_pose_pairs(ROOMS, 40, seed=5):
        plan = ROOMS.plan(start, goal, planner=planner)
        np.testing.assert_array_equal(plan.points[[0, -1]], [start, goal])
        assert ROOMS.space.is_free_path(plan.points)
        assert plan.length == pytest.approx(plan.path.length)
        assert plan.length <= ROOMS.lattice.resolution + plan.cost
        assert (np.abs(np.diff(plan.cells, axis=0)).max(axis=1) == 1).all()
        assert np.hypot(*np.diff(plan.points, axis=0).T).min() > 1e-6


def test_hardly_any_vertex_needs_a_turn_in_place():
    sharp = [np.count_nonzero(turns(ROOMS.plan(*pair).points) > math.radians(20.0))
             for pair in random_pose_pairs(ROOMS, 40, seed=6)]
    assert np.mean(sharp) < 0.3


def test_social_is_cheapest_and_shortest_is_shortest():
    for start, goal in random_pose_pairs(ROOMS, 20, seed=7):
        social, shortest = (ROOMS.plan(start, goal, planner=planner) for planner in ("social", "shortest"))
        assert social.cost <= shortest.cost + 1e-9
        assert shortest.cost - shortest.social_cost <= social.cost - social.social_cost + 1e-9


@pytest.mark.parametrize("side, sense", [("right", 1.0), ("left", -1.0)])
def test_lanes_of_a_corridor(side, sense):
    planner = SocialPlanner(corridor(20), PlannerConfig(side=side))  # free from y = 0.3 to 2.3 m
    there, back = planner.plan((0.5, 1.3), (9.5, 1.3)), planner.plan((9.5, 1.3), (0.5, 1.3))
    lane = 1.3 - sense * (1.0 - 0.35)
    np.testing.assert_allclose(heights(there, 4.0, 6.0), lane, atol=0.1)
    np.testing.assert_allclose(heights(back, 4.0, 6.0), 2.6 - lane, atol=0.1)


def test_two_robots_pass_in_a_corridor_of_one_and_a_half_metres():
    planner = SocialPlanner(corridor(30, 300, 0.05))
    there, back = planner.plan((0.5, 0.9), (14.5, 0.9)), planner.plan((14.5, 0.9), (0.5, 0.9))
    assert heights(back, 4.0, 11.0).min() - heights(there, 4.0, 11.0).max() >= 0.70


def test_a_single_lane_is_driven_in_the_middle():
    planner = SocialPlanner(corridor(10))
    np.testing.assert_allclose(heights(planner.plan((0.5, 0.7), (9.5, 0.9)), 4.0, 6.0), 0.8, atol=0.06)


def test_none_keeps_no_side():
    planner = SocialPlanner(corridor(20), PlannerConfig(side="none"))
    plan = planner.plan((0.5, 1.3), (9.5, 1.3))
    assert plan.social_cost == 0.0
    assert plan.length == pytest.approx(9.0)


def test_a_turned_and_shifted_map_gives_the_same_path_turned_and_shifted():
    plain = SocialPlanner(corridor(20)).plan((0.5, 1.3), (9.5, 1.3))
    turned = OccupancyGrid(corridor(20).values, 0.1, Pose(5.0, -2.0, 0.7))
    ends = turned.from_local([(0.5, 1.3), (9.5, 1.3)])
    plan = SocialPlanner(turned).plan(ends[0], ends[1])
    np.testing.assert_allclose(turned.to_local(plan.points), plain.points, atol=1e-6)


def test_the_same_question_gets_the_same_answer():
    pairs = random_pose_pairs(ROOMS, 5, seed=8)
    first = [ROOMS.plan(*pair).points for pair in pairs]
    for pair, points in reversed(list(zip(pairs, first))):
        np.testing.assert_array_equal(ROOMS.plan(*pair).points, points)


def test_headings_of_the_ends_are_kept():
    (x, y), goal = random_pose_pairs(ROOMS, 1, seed=2)[0]
    plan = ROOMS.plan((x, y, 0.5), goal)
    assert (plan.start_yaw, plan.goal_yaw) == (0.5, None)


def test_staying_where_one_is():
    here = 1.23, 1.31
    plan = SocialPlanner(corridor(20)).plan(here, here)
    assert plan.length == 0.0
    np.testing.assert_array_equal(plan.points, [here] * len(plan.points))


def test_paths_go_round_discs():
    disc = Disc(5.0, 0.8, 0.6)
    planner = SocialPlanner(corridor(20))
    before = planner.plan((0.5, 1.3), (9.5, 1.3))
    plan = planner.plan((0.5, 1.3), (9.5, 1.3), avoid=[disc])
    assert np.hypot(*(plan.path.position(np.linspace(0, plan.length, 2000)) - [5.0, 0.8]).T).min() >= 0.6 - 1e-9
    assert planner.space.is_free_path(plan.points)
    np.testing.assert_array_equal(planner.plan((0.5, 1.3), (9.5, 1.3)).points, before.points)
    with pytest.raises(NoPath, match="round 1 obstacle"):
        planner.plan((0.5, 1.3), (9.5, 1.3), avoid=[Disc(5.0, 1.3, 0.9)])
    with pytest.raises(InvalidStart):
        planner.plan((5.0, 1.0), (9.5, 1.3), avoid=[disc])
    with pytest.raises(InvalidGoal):
        planner.plan((0.5, 1.3), (5.0, 1.0), avoid=[disc])


def test_no_path_says_between_what():
    planner = SocialPlanner(grid_from_text("""
        ....#....
        ....#....
        ....#....
    """, 0.5))
    with pytest.raises(NoPath, match=r"\(0.75, 0.75\) to \(3.75, 0.75\)"):
        planner.plan((0.75, 0.75), (3.75, 0.75))


def test_unknown_planners_are_refused():
    with pytest.raises(InvalidParameter, match="rrt_star"):
        ROOMS.plan((2.0, 2.0), (3.0, 3.0), planner="dijkstra")


def test_poses_off_the_cell_centres_along_a_narrow_way():
    planner = SocialPlanner(corridor(6, 60), PlannerConfig(wall_margin=0.0))  # 0.6 m wide, the robot 0.5 m
    for y in (0.55, 0.6, 0.65):
        plan = planner.plan((0.53, y), (5.47, y))
        assert planner.space.is_free_path(plan.points)
        np.testing.assert_array_equal(plan.points[[0, -1]], [(0.53, y), (5.47, y)])


def test_a_margin_is_kept_on_the_way_but_not_at_the_ends():
    planner = SocialPlanner(corridor(20), PlannerConfig(wall_margin=0.1, side="none"))
    start, goal = (0.5, 0.56), (9.5, 0.56)  # 0.26 m from the wall
    plan = planner.plan(start, goal)
    np.testing.assert_array_equal(plan.points[[0, -1]], [start, goal])
    assert planner.space.is_free_path(plan.points)
    assert heights(plan, 1.6, 8.4).min() >= 0.65 - 1e-6


def test_plans_from_several_threads():
    pairs = random_pose_pairs(ROOMS, 12, seed=9)
    expected = [ROOMS.plan(*pair).cost for pair in pairs]
    found = [0.0] * len(pairs)

    def work(first):
        for index in range(first, len(pairs), 3):
            found[index] = ROOMS.plan(*pairs[index]).cost

    threads = [threading.Thread(target=work, args=(first,)) for first in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=60.0)
    assert found == expected
