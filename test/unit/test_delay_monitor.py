"""How late a robot is, with hysteresis."""

import numpy as np
import pytest
from driving import schedule_of

from social_fleet.coordination.schedule import Schedule
from social_fleet.execution.delay_monitor import DelayMonitor

# 1 m/s to 4 m, waiting there from 4 s to 10 s, 1 m/s to 8 m
WAITING = Schedule(schedule_of([(0, 0), (8, 0)]).robot,
                   np.array([0.0, 4.0, 4.0, 8.0]), np.array([0.0, 4.0, 10.0, 14.0]))


@pytest.mark.parametrize("now, progress, delay", [
    (3.0, 3.0, 0.0), (3.0, 1.0, 2.0), (3.0, 3.5, -0.5), (7.0, 4.0, 0.0), (7.0, 3.99, 0.0), (12.0, 4.0, 2.0),
    (12.0, 6.0, 0.0), (14.0, 8.0, 0.0), (20.0, 7.0, 7.0)])
def test_delay_is_measured_in_time(now: float, progress: float, delay: float) -> None:
    assert DelayMonitor(WAITING).update(now, progress) == pytest.approx(delay, abs=0.06)


def test_late_and_recovered_are_two_thresholds() -> None:
    monitor, told = DelayMonitor(WAITING, late=3.0, recovered=1.0), []
    for delay in (2.0, 3.5, 2.0, 0.5, 2.0):
        monitor.update(1.0 + delay, 1.0)
        told.append(monitor.is_late)
    assert told == [False, True, True, False, False]
