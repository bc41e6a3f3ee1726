"""Requests that no schedule could come of, and options out of range: refused by name."""

import math
from dataclasses import replace
from typing import Any, Dict, List

import numpy as np
import pytest
from fleets import robot

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import Schedule
from social_fleet.errors import InvalidParameter, InvalidScenario, TimedOut

CROSSING = [robot("a", (-4, 0), (4, 0)), robot("b", (0, -4), (0, 4))]


@pytest.mark.parametrize("fleet, sentence", [
    ([], "no robot"), ([CROSSING[0], CROSSING[0]], "named a"),
    ([CROSSING[0], robot("c", (-4, 0.6), (0, 9))], "a and c have starts 0.60 m apart"),
    ([CROSSING[0], robot("c", (0, 9), (4, 0.6))], "a and c have goals 0.60 m apart"),
    ([CROSSING[0], replace(CROSSING[0], name="c")], "a and c have starts 0.00 m apart")])
def test_fleets_that_cannot_be_are_refused(fleet: List[Robot], sentence: str) -> None:
    with pytest.raises(InvalidScenario, match=sentence):
        coordinate(fleet)


def test_the_goal_of_a_robot_under_way_is_taken() -> None:
    under_way = coordinate([CROSSING[0]]).schedules
    with pytest.raises(InvalidScenario, match="c and a have goals"):
        coordinate([robot("c", (4, 6), (4, 0.5))], mode="unified", fixed=under_way)
    with pytest.raises(InvalidScenario, match="named a"):
        coordinate([robot("a", (4, 6), (8, 6))], mode="unified", fixed=under_way)


@pytest.mark.parametrize("options", [
    {"mode": "all"}, {"formulation": "best"}, {"time_margin": -1.0}, {"time_margin": math.nan}, {"time_limit": 0.0},
    {"time_limit": math.inf}, {"tracking_tolerance": -0.1}])
def test_wrong_options_are_refused_by_name(options: Dict[str, Any]) -> None:
    with pytest.raises(InvalidScenario) as caught:
        coordinate(CROSSING, **options)
    assert caught.value.field == next(iter(options))


def test_an_unknown_solver_is_refused() -> None:
    with pytest.raises(InvalidParameter, match="magic"):
        coordinate(CROSSING, solver="magic")


def test_schedules_under_way_that_touch_are_named() -> None:
    east, north = ([(0.0, 0.0), (10.0, 0.0)], [(5.0, -5.0), (5.0, 5.0)])
    fixed = [Schedule(robot(name, *points), np.array([0.0, 10.0]), np.array([0.0, 20.0]))
             for name, points in (("x", east), ("y", north))]
    for way in ({}, {"mode": "sequential"}, {"formulation": "paper"}):
        with pytest.raises(InvalidScenario, match="fixed: .*x and y overlap by 0.50 m at 10.0 s"):
            coordinate([robot("z", (0, 20), (10, 20))], fixed=fixed, **way)  # type: ignore[arg-type]


@pytest.mark.parametrize("options", [
    {"time_margin": "soon"}, {"tracking_tolerance": None}, {"time_limit": True}, {"gap": -0.1}, {"effort": 1.5},
    {"repairs": -1}, {"objective": "speed"}])
def test_options_out_of_range_are_refused_by_name(options: dict) -> None:
    with pytest.raises(InvalidScenario) as caught:
        coordinate([robot("a", (0, 0), (9, 0))], **options)
    assert [caught.value.field] == list(options)


def test_what_is_no_robot_is_refused() -> None:
    with pytest.raises(InvalidScenario, match="robots"):
        coordinate(["a"])  # type: ignore[list-item]
    with pytest.raises(InvalidScenario, match="fixed"):
        coordinate([robot("a", (0, 0), (9, 0))], fixed=None)  # type: ignore[arg-type]
    with pytest.raises(TimedOut):
        coordinate([robot("a", (0, 0), (9, 0))], time_limit=1e-9, formulation="paper")
