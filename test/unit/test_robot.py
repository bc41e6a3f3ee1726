"""Robots: what is given, what comes from the plan, and what is refused."""

import math
from typing import Any

import numpy as np
import pytest
from fleets import robot

from social_fleet.coordination.robot import MotionLimits, Robot
from social_fleet.errors import InvalidScenario
from social_fleet.planning.plan import Plan

PLAN = Plan(points=np.array([[0.0, 0.0], [0.0, 5.0]]), length=5.0, social_cost=0.0, cost=5.0, expanded=1,
            search_time=0.0, planner="social", robot_radius=0.35, start_yaw=0.5, goal_yaw=None)


def test_a_plan_brings_radius_and_headings() -> None:
    planned = Robot("amr_1", PLAN)
    assert planned.body_radius == 0.35
    assert planned.start == pytest.approx((0.0, 0.0, 0.5))
    assert planned.goal == pytest.approx((0.0, 5.0, math.pi / 2.0)), "without a heading, the path's"
    assert planned.path.length == 5.0


def test_what_is_given_goes_before_the_plan() -> None:
    planned = Robot("amr_1", PLAN, radius=0.2, start_yaw=-1.0, goal_yaw=2.0)
    assert (planned.body_radius, planned.start.yaw, planned.goal.yaw) == (0.2, -1.0, 2.0)


def test_bare_points_get_defaults() -> None:
    bare = robot("amr_1", (1.0, 1.0), (4.0, 1.0), (4.0, 1.0))
    assert bare.body_radius == 0.25
    assert bare.start == pytest.approx((1.0, 1.0, 0.0))
    assert bare.limits == MotionLimits()
    assert robot("amr_1", (1.0, 1.0)).goal == (1.0, 1.0, 0.0), "a path of one point"


def test_numpy_numbers_are_numbers() -> None:
    assert robot("amr_1", (0, 0), max_speed=np.float32(0.5), depart=np.int64(3)).depart == 3


@pytest.mark.parametrize("field, value", [
    ("max_speed", 0.0), ("max_speed", -0.7), ("max_speed", math.nan), ("max_speed", math.inf), ("max_speed", "fast"),
    ("max_speed", None), ("max_acceleration", 0.0), ("max_turn_rate", -1.0), ("max_turn_acceleration", math.nan),
    ("radius", 0.0), ("radius", -0.2), ("radius", math.nan), ("radius", "big"), ("depart", -1.0),
    ("depart", math.nan), ("depart", math.inf), ("depart", None), ("start_yaw", math.nan), ("goal_yaw", "north"),
    ("max_speed", True)])
def test_wrong_values_are_refused_by_name(field: str, value: Any) -> None:
    with pytest.raises(InvalidScenario, match="amr_7") as caught:
        robot("amr_7", (0, 0), (1, 0), **{field: value})
    assert caught.value.field == field


@pytest.mark.parametrize("points", [[], [[0.0, math.nan]], [[1.0, 2.0, 3.0]], None, [["a", "b"]]])
def test_a_path_that_is_none_names_the_robot(points: Any) -> None:
    with pytest.raises(InvalidScenario, match="amr_7") as caught:
        Robot("amr_7", points)
    assert caught.value.field == "path"


@pytest.mark.parametrize("name", ["", None, 7])
def test_a_robot_needs_a_name(name: Any) -> None:
    with pytest.raises(InvalidScenario):
        Robot(name, PLAN)
