"""Goals that are blocked or cut off, and the nearest place instead."""

import math

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.errors import InvalidGoal, InvalidParameter, InvalidStart, NoPath
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.overlays.discs import Disc
from social_fleet.planning.overlays.shapes import Rectangle
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.reach import reached_from

GRID = grid_from_text("""
    ########################
    #..........##......##..#
    #..........##......##..#
    #..........##......##..#
    #..........##......#####
    #..................#####
    #..................#####
    #..................#####
    #..........##......#####
    ########################
""", 0.5)
PLANNER = SocialPlanner(GRID, PlannerConfig(robot_radius=0.3, wall_margin=0.05))
START = 1.5, 1.0


def best_by_trying(goal, tolerance, judge, reachable):
    """The least distance from the goal over a fine raster of places where the disc fits."""
    x, y = np.meshgrid(np.arange(0.0, 9.6, 0.02), np.arange(0.0, 5.0, 0.02))
    places = np.column_stack([x.ravel(), y.ravel()])
    gaps = np.hypot(*(places - goal).T)
    for index in np.argsort(gaps):
        if gaps[index] > tolerance:
            return math.inf
        if reachable(places[index]) and judge.is_free_path(places[index:index + 1]):
            return gaps[index]
    return math.inf


@pytest.mark.parametrize("goal", [(5.8, 3.6), (5.75, 0.2), (9.8, 1.2), (3.0, 4.8), (-0.4, 2.0), (3.0, 4.6)])
def test_the_nearest_place_where_the_robot_fits(goal):
    with pytest.raises(InvalidGoal):
        PLANNER.plan(START, goal)
    plan = PLANNER.plan(START, (*goal, 1.0), tolerance=2.0)
    assert PLANNER.space.is_free_path(plan.points)
    end = plan.points[-1]
    assert plan.goal_shift == pytest.approx(np.hypot(*(end - goal))) and plan.goal_yaw == 1.0
    assert plan.goal_shift <= best_by_trying(goal, 2.0, PLANNER.space, lambda place: place[0] < 9.5) + 0.06
    assert f"the path ends {plan.goal_shift:.2f} m from it at ({end[0]:.2f}, {end[1]:.2f})" in plan.message
    assert plan.message.startswith("the goal is blocked: (")


def test_a_goal_that_is_free_stays():
    plan = PLANNER.plan(START, (8.0, 1.0), tolerance=1.0)
    assert (plan.goal_shift, plan.message) == (0.0, "")
    np.testing.assert_array_equal(plan.points[-1], (8.0, 1.0))


def test_a_place_that_cannot_be_reached_does_not_count():
    closed_room = 10.9, 3.8
    with pytest.raises(NoPath):
        PLANNER.plan(START, closed_room)
    with pytest.raises(NoPath, match="too narrow; nor can any place within 1 m of the goal be reached"):
        PLANNER.plan(START, closed_room, tolerance=1.0)
    with pytest.raises(InvalidGoal, match="wall; the nearest .*; nor can any place within 0.1 m of the goal"):
        PLANNER.plan(START, (5.75, 0.2), tolerance=0.1)
    plan = PLANNER.plan(START, closed_room, tolerance=2.0)
    assert plan.points[-1][0] < 9.5 and plan.message.startswith("the goal is cut off; the path ends")
    # in the wall of that room, a little nearer to it than to where the robot can get
    assert PLANNER.plan(START, (10.2, 3.8), tolerance=2.0).points[-1][0] < 9.5


def test_obstacles_count():
    door = {"pallet": Rectangle(6.0, 1.75, 0.6, 1.5)}
    goal = 6.0, 1.75
    judge = ConfigurationSpace(GRID, 0.3)
    plan = PLANNER.plan(START, goal, overlays=door, tolerance=2.0)
    assert "obstacle 'pallet'" in plan.message and plan.points[-1][0] < 6.0 - 0.6 + 1e-6
    assert judge.is_free_path(plan.points) and plan.goal_shift == pytest.approx(0.6, abs=0.5)
    with pytest.raises(NoPath):
        PLANNER.plan(START, (8.0, 1.0), overlays=door)
    with pytest.raises(NoPath):
        PLANNER.plan(START, (8.0, 1.0), overlays=door, tolerance=1.0)
    assert PLANNER.plan(START, (8.0, 1.0), overlays=door, tolerance=4.0).points[-1][0] < 6.0


def test_discs_to_avoid_count():
    plan = PLANNER.plan(START, (4.0, 1.0), avoid=[Disc(4.0, 1.0, 0.5)], tolerance=1.0)
    assert plan.goal_shift == pytest.approx(0.5, abs=0.01)


def test_a_blocked_start_is_no_matter_of_tolerance():
    with pytest.raises(InvalidStart):
        PLANNER.plan((0.1, 1.0), (8.0, 1.0), tolerance=5.0)


@pytest.mark.parametrize("tolerance", [-0.1, math.nan, math.inf])
def test_a_tolerance_that_is_none_is_refused(tolerance):
    with pytest.raises(InvalidParameter) as caught:
        PLANNER.plan(START, (8.0, 1.0), tolerance=tolerance)
    assert caught.value.field == "tolerance"


def test_a_goal_that_is_no_pose_is_refused_whatever_the_tolerance():
    for goal in ((math.nan, 1.0), (1.0,)):
        with pytest.raises(InvalidGoal):
            PLANNER.plan(START, goal, tolerance=5.0)


def test_what_is_reached():
    lattice = PLANNER.lattice
    seed = int(lattice.node[3, 2])
    everywhere = reached_from(lattice.links, np.array([seed]), np.zeros(0, dtype=np.int64))
    np.testing.assert_array_equal(everywhere, lattice.component == lattice.component[seed])
    door = lattice.node[2:5, 11].astype(np.int64)
    west = reached_from(lattice.links, np.array([seed]), door[door >= 0])
    assert west[lattice.node[3, 9]] and lattice.node[3, 15] >= 0 and not west[lattice.node[3, 15]]
    assert not reached_from(lattice.links, door[:1], door).any()


@pytest.mark.parametrize("start, tolerance, wanted", [
    ((5.4, 3.75), 0.7, True), ((5.4, 3.75), 0.6, False), ((5.7, 3.75), 2.0, False), ((-3.0, 1.0), 9.0, False),
])
def test_a_robot_that_was_pushed_to_a_wall_departs_from_beside_it(start, tolerance, wanted):
    place = PLANNER.departure(start, tolerance)
    assert (place is not None) == wanted
    if place is not None:
        assert math.dist(place, start) <= tolerance
        assert PLANNER.plan(place, START).length > 0.0


def test_a_departure_is_not_beyond_a_wall():
    # With the place beside the start taken, those beyond the wall are the nearest.
    beside = Rectangle(4.7, 3.0, 0.6, 4.0)
    assert PLANNER.departure((5.4, 3.75), 2.0, overlays=[beside]) is None
    assert PLANNER.departure((6.6, 3.75), 2.0, overlays=[beside]) == (7.25, 3.75)
