"""Whom to plan anew, and with whom."""

import pytest
from driving import schedule_of

from social_fleet.coordination.schedule import Precedence
from social_fleet.execution.recovery.decision import affected_by, replan_for_delays, replan_for_paths

# green waits for gold, blue for green, red for nobody
SCHEDULES = {
    "gold": schedule_of([(0, 0), (9, 0)], name="gold"),
    "green": schedule_of([(0, 1), (9, 1)], name="green", precedences=[Precedence(3.0, "gold", 5.0)]),
    "blue": schedule_of([(0, 2), (9, 2)], name="blue", precedences=[Precedence(4.0, "green", 6.0)]),
    "red": schedule_of([(0, 3), (9, 3)], name="red"), "grey": schedule_of([(0, 4), (9, 4)], name="grey"),
    "pink": schedule_of([(0, 5), (9, 5)], name="pink")}
NOWHERE = {name: 0.0 for name in SCHEDULES}


def test_those_who_wait_directly_and_not() -> None:
    assert affected_by(["gold"], SCHEDULES, NOWHERE) == {"green", "blue"}
    assert affected_by(["red"], SCHEDULES, NOWHERE) == set()


@pytest.mark.parametrize("passed", [{"gold": 5.0}, {"green": 3.5}])
def test_what_is_passed_makes_nobody_wait(passed: dict) -> None:
    assert affected_by(["gold"], SCHEDULES, {**NOWHERE, **passed}) == set()


def delays(**late: float) -> dict:
    return {**NOWHERE, **late}


def test_one_that_is_late_alone_is_fitted_in_anew() -> None:
    need = replan_for_delays(delays(gold=6.0), ["gold"], SCHEDULES, NOWHERE)
    assert need is not None and need.mode == "sequential" and need.robots == {"gold"}
    assert need.reason == "gold is 6 s late, blue, green would wait"


def test_with_those_who_are_late_for_it() -> None:
    need = replan_for_delays(delays(gold=6.0, green=5.0), ["gold"], SCHEDULES, NOWHERE)
    assert need is not None and need.mode == "unified" and need.robots == {"gold", "green", "blue"}


def test_and_all_when_most_are_late() -> None:
    need = replan_for_delays(delays(gold=6.0, green=5.0, blue=5.0, red=6.0), ["gold", "red"], SCHEDULES, NOWHERE)
    assert need is not None and need.mode == "simultaneous" and need.robots == set(SCHEDULES)


def test_nobody_is_planned_anew_for_one_that_nobody_waits_for() -> None:
    assert replan_for_delays(delays(red=60.0), ["red"], SCHEDULES, NOWHERE) is None
    assert replan_for_delays(delays(), [], SCHEDULES, NOWHERE) is None


def test_new_paths_are_for_those_who_need_them() -> None:
    need = replan_for_paths({"gold": "has a new goal"}, list(SCHEDULES))
    assert need is not None and need.mode == "sequential" and need.new_paths == {"gold"}
    need = replan_for_paths({"gold": "has a new goal", "red": "stands off its path"}, list(SCHEDULES))
    assert need is not None and need.mode == "unified" and need.reason == "gold has a new goal; red stands off its path"
    assert replan_for_paths({}, list(SCHEDULES)) is None
