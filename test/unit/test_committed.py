"""Robots under way: nobody waits within what it is committed to, and what both reach within that is settled."""

import numpy as np
import pytest

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.robot import Robot
from social_fleet.errors import Infeasible, InvalidScenario


def robot(name: str, *points: tuple, **options: float) -> Robot:
    return Robot(name, np.array(points, dtype=float), **options)  # type: ignore[arg-type]


def test_who_is_committed_into_a_crossing_goes_first() -> None:
    gold, green = robot("gold", (4.0, 5.0), (10.0, 5.0)), robot("green", (5.0, 1.0), (5.0, 10.0), committed=4.0)
    fleet = coordinate([gold, green])
    assert fleet.windows[0].first == "green"
    assert all(rule.at >= 4.0 for rule in fleet["green"].precedences)


def test_both_committed_into_a_crossing_have_no_schedule() -> None:
    gold = robot("gold", (1.0, 5.0), (10.0, 5.0), committed=3.9)
    with pytest.raises(Infeasible):
        coordinate([gold, robot("green", (5.0, 1.0), (5.0, 10.0), committed=3.9)])


def test_a_follower_that_waits_a_little_too_close_is_led_on_behind() -> None:
    """By the release tolerance robots stand 0.03 m closer than windows have it; that must not shut them in."""
    leader = robot("gold", (2.0, 0.0), (10.0, 0.0), (10.0, 5.0), committed=0.2)
    follower = robot("green", (2.0 - 0.67, 0.0), (10.0, 0.0), (10.0, -5.0), committed=0.0)
    fleet = coordinate([leader, follower])
    assert {window.first for window in fleet.windows} == {"gold"}
    assert fleet["green"].precedences[0].at <= 0.1


@pytest.mark.parametrize("gap", [0.68, 0.6, 0.56])
def test_two_that_stand_too_close_may_get_away_from_each_other(gap: float) -> None:
    fleet = coordinate([robot("gold", (0.0, 0.0), (-5.0, 0.0), committed=0.0),
                        robot("green", (gap, 0.0), (5.0, 0.0), committed=0.0)])
    assert fleet.makespan < 12.0


def test_two_that_stand_too_close_are_not_led_through_each_other() -> None:
    with pytest.raises(Infeasible):
        coordinate([robot("gold", (0.0, 0.0), (5.0, 0.0), committed=0.0),
                    robot("green", (0.6, 0.0), (-5.0, 0.0), committed=0.0)])


@pytest.mark.parametrize("value", [-0.1, np.nan, np.inf, True])
def test_a_commitment_is_a_length(value: float) -> None:
    with pytest.raises(InvalidScenario, match="committed"):
        robot("gold", (0.0, 0.0), (1.0, 0.0), committed=value)
