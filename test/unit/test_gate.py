"""The precedence gate: who has reported what decides, and nothing else."""

import math

from driving import schedule_of

from social_fleet.coordination.schedule import Precedence
from social_fleet.execution.gate import PrecedenceGate, ReportedProgress


def gate(*precedences: Precedence) -> PrecedenceGate:
    guard = PrecedenceGate(standoff=0.02, release_tolerance=0.03)
    guard.follow(schedule_of([(0, 0), (10, 0)], precedences=precedences))
    return guard


def news(arc_length: float, version: int = 0) -> ReportedProgress:
    return ReportedProgress(version, arc_length, 1.0)


def test_without_precedences_nothing_is_held() -> None:
    assert gate().bound == math.inf and gate().waiting_for(0.0) is None


def test_no_news_no_passing() -> None:
    guard = gate(Precedence(4.0, "green", 6.0))
    guard.hear({})
    guard.hear({"blue": news(99.0)})
    assert guard.bound == 3.98


def test_released_by_what_the_other_reported_and_for_good() -> None:
    guard = gate(Precedence(4.0, "green", 6.0))
    guard.hear({"green": news(5.9)})
    assert guard.bound == 3.98
    guard.hear({"green": news(6.0)})
    guard.hear({"green": news(0.0)})
    guard.hear({})
    assert guard.bound == math.inf


def test_the_nearest_that_is_not_released_binds() -> None:
    guard = gate(Precedence(8.0, "blue", 1.0), Precedence(4.0, "green", 6.0), Precedence(5.0, "green", 7.0))
    assert guard.bound == 3.98
    guard.hear({"green": news(6.5)})
    assert guard.bound == 4.98
    guard.hear({"green": news(7.0)})
    assert guard.bound == 7.98


def test_a_report_on_another_schedule_says_nothing() -> None:
    guard = gate(Precedence(4.0, "green", 6.0, other_version=2))
    for version in (1, 3):
        guard.hear({"green": news(50.0, version)})
        assert guard.bound == 3.98
    guard.hear({"green": news(6.1, 2)})
    guard.hear({"green": news(0.0, 3)})
    assert guard.bound == math.inf


def test_at_the_start_it_stands_on_the_spot() -> None:
    assert gate(Precedence(0.0, "green", 6.0)).bound == 0.0


def test_it_tells_whom_where_and_since_when() -> None:
    guard = gate(Precedence(4.0, "green", 6.0), Precedence(5.0, "blue", 1.0))
    assert guard.waiting_for(3.0) == guard.waiting_for(9.0) == ("green", 4.0, 6.0, 3.0)
    guard.hear({"green": news(6.0)})
    assert guard.waiting_for(10.0) == ("blue", 5.0, 1.0, 10.0)
    guard.moving()
    assert guard.waiting_for(12.0) == ("blue", 5.0, 1.0, 12.0)
