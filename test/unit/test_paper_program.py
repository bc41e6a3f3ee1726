"""Eq. 5-8 as printed: what the equations ask for is kept, and what they do not ask for can go wrong."""

import math
import time
from typing import Sequence

import numpy as np
import pytest
from fleets import robot, street_fleet

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.coordination.verification import verify
from social_fleet.errors import Infeasible, TimedOut


def reached(fleet: FleetSchedule, name: str, arc: float) -> float:
    return float(np.interp(arc, fleet[name].arc_lengths, fleet[name].times))


def check_printed(fleet: FleetSchedule, margin: float) -> None:
    """Eq. 5 for every stretch, Eq. 6 and 7 for the order chosen in every window."""
    for schedule in fleet.schedules:
        speeds = np.diff(schedule.arc_lengths) / np.diff(schedule.times)
        assert schedule.arc_length(schedule.robot.depart) == 0.0 and speeds.max() <= schedule.robot.max_speed + 1e-5
    for window in fleet.windows:
        r = window.robot_r, window.r_enter, window.r_exit
        s = window.robot_s, window.s_enter, window.s_exit
        first, second = (r, s) if window.first == window.robot_r else (s, r)
        if window.kind == "same_direction":
            for share in np.linspace(0.0, 1.0, 2):
                ahead = reached(fleet, first[0], first[1] + share * (first[2] - first[1]))
                assert reached(fleet, second[0], second[1] + share * (second[2] - second[1])) >= ahead + margin - 1e-3
        else:
            assert reached(fleet, second[0], second[1]) >= reached(fleet, first[0], first[2]) + margin - 1e-3


@pytest.mark.parametrize("seed", range(6))
def test_street_fleets_keep_the_printed_equations(seed: int) -> None:
    try:
        fleet = coordinate(street_fleet(5, seed), formulation="paper")
    except Infeasible as error:
        assert "paper's constraints" in str(error)
        return
    assert fleet.formulation == "paper" and fleet.objective == pytest.approx(fleet.sum_of_completion, abs=1e-3)
    check_printed(fleet, 1.0)


def test_the_faster_robot_goes_first_whatever_its_number() -> None:
    for fast, slow in (("robot_1", "robot_2"), ("robot_2", "robot_1")):
        fleet = coordinate([robot(fast, (0, -4), (0, 4), max_speed=1.0), robot(slow, (-4, 0), (4, 0), max_speed=0.3)],
                           formulation="paper")
        assert [window.first for window in fleet.windows] == [fast]


def test_a_robot_that_only_stands_there_is_one_contradiction_more() -> None:
    """Large robots, so that the passing one is near for longer than an intersection lasts."""
    with pytest.raises(Infeasible, match="paper's constraints"):
        coordinate([robot("parked", (0, 0.5), radius=0.6), robot("passing", (-6, 0), (6, 0), radius=0.6)],
                   formulation="paper")


def test_turning_and_speeding_up_take_no_time() -> None:
    fleet = coordinate([robot("a", (0, 0), (7, 0), (7, 7), start_yaw=2.0)], formulation="paper")
    assert fleet.objective == pytest.approx(14.0 / 0.7)


def slow_pair() -> Sequence:
    """Two at 0.2 m/s, one in a lane, one that turns into it 2 m ahead: a second is a fifth of a metre to them."""
    return [robot("ahead", (0, 2), (0, 0), (12, 0), (12, 2), max_speed=0.2),
            robot("behind", (-2, 0), (10, 0), (10, -2), max_speed=0.2)]


def test_slow_robots_in_one_lane_touch_as_printed_and_not_as_exact() -> None:
    printed = coordinate(slow_pair(), formulation="paper")
    check_printed(printed, 1.0)
    assert verify(printed).min_clearance < -0.1
    assert verify(coordinate(slow_pair())).min_clearance >= 0.2 - 1e-6


def test_fixed_schedules_are_constants() -> None:
    under_way = coordinate([robot("a", (-4, 0), (4, 0))]).schedules
    joined = coordinate([robot("b", (0, -4), (0, 4))], formulation="paper", mode="unified", fixed=under_way)
    window, = joined.windows
    assert window.first == "a"
    cleared = np.interp(window.s_exit, under_way[0].arc_lengths, under_way[0].times)
    assert reached(joined, "b", window.r_enter) >= cleared + 1.0 - 1e-3


def test_contradictory_ends_have_no_solution() -> None:
    with pytest.raises(Infeasible, match="paper's constraints"):
        coordinate([robot("a", (0, 0), (9, 0)), robot("b", (4, 0), (-5, 0))], formulation="paper")


def test_its_limit_is_kept() -> None:
    begun = time.monotonic()
    try:
        fleet = coordinate(street_fleet(40, 1), formulation="paper", time_limit=1.0)
        assert math.isfinite(fleet.gap)
    except (TimedOut, Infeasible):
        pass
    assert time.monotonic() - begun < 60.0
