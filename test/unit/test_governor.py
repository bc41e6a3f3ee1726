"""The reference: on time, never ahead by much, and always able to stop."""

import math

import numpy as np
import pytest
from driving import PERIOD, schedule_of

from social_fleet.coordination.schedule import Schedule
from social_fleet.execution.governor import Governor
from social_fleet.execution.reference_path import ReferencePath

STRAIGHT = schedule_of([(0, 0), (10, 0)])


def governor(schedule: Schedule) -> Governor:
    return Governor(schedule, ReferencePath(schedule.robot))


def run(reference: Governor, begin: float, end: float, *, bound: float = math.inf, patience: float = 1.0) -> list:
    """Speeds and arc lengths at every step between two times."""
    states = []
    for tick in range(int(round(begin / PERIOD)), int(round(end / PERIOD))):
        reference.advance(tick * PERIOD, PERIOD, 0, stop=10.0, bound=bound, patience=patience)
        states.append((reference.speed, reference.arc_length))
    return states


def test_it_keeps_to_the_schedule() -> None:
    reference = governor(STRAIGHT)
    for tick, (_, arc_length) in enumerate(run(reference, 0.0, 20.0)):
        assert arc_length == pytest.approx(STRAIGHT.arc_length((tick + 1) * PERIOD), abs=0.06)
    assert reference.arc_length == 10.0 and reference.speed == 0.0


def test_it_waits_where_the_schedule_waits() -> None:
    waiting = Schedule(STRAIGHT.robot, np.array([0.0, 4.0, 4.0, 10.0]), np.array([0.0, 8.0, 20.0, 32.0]))
    reference = governor(waiting)
    run(reference, 0.0, 12.0)
    assert reference.arc_length == pytest.approx(4.0, abs=0.01)
    run(reference, 12.0, 40.0)
    assert reference.arc_length == 10.0


def test_accelerations_stay_within_the_limit() -> None:
    speeds = [speed for speed, _ in run(governor(STRAIGHT), 0.0, 20.0, bound=7.0)]
    steps = [abs(after - before) for before, after in zip([0.0] + speeds, speeds)]
    assert max(steps) <= 0.9 * PERIOD * 1.0 + 1e-12


def test_it_stands_at_a_bound_and_catches_up_after() -> None:
    reference = governor(STRAIGHT)
    run(reference, 0.0, 20.0, bound=3.0)
    assert reference.arc_length == pytest.approx(3.0, abs=1e-4) and reference.speed == pytest.approx(0.0, abs=1e-3)
    fastest = max(speed for speed, _ in run(reference, 20.0, 40.0))
    assert reference.arc_length == 10.0 and 0.665 < fastest <= 0.7


def test_it_waits_for_a_robot_that_stays_behind() -> None:
    assert run(governor(STRAIGHT), 0.0, 5.0, patience=0.0)[-1] == (0.0, 0.0)


def test_it_brakes_with_the_robot() -> None:
    reference = governor(STRAIGHT)
    run(reference, 0.0, 5.0)
    speed, before = reference.speed, reference.arc_length
    for _ in range(40):
        reference.brake(PERIOD, 10.0)
    assert reference.speed == 0.0 and reference.arc_length - before <= speed ** 2 / 2.0
