"""Schedules: motion between knots, standing before and after, and arrays that do not fit together."""

import math
from typing import Any

import numpy as np
import pytest
from fleets import robot

from social_fleet.coordination.schedule import FleetSchedule, Schedule
from social_fleet.errors import InvalidSchedule

ROBOT = robot("amr_1", (0, 0), (3, 0), (3, 4))
SCHEDULE = Schedule(ROBOT, np.array([0.0, 3.0, 3.0, 7.0]), np.array([2.0, 5.0, 9.0, 13.0]))


def test_standing_before_waiting_within_and_standing_after() -> None:
    arcs = SCHEDULE.arc_length(np.array([-5.0, 2.0, 3.5, 5.0, 7.0, 9.0, 11.0, 99.0]))
    assert np.array_equal(arcs, [0.0, 0.0, 1.5, 3.0, 3.0, 3.0, 5.0, 7.0])
    assert SCHEDULE.position(11.0).tolist() == [3.0, 2.0]
    assert SCHEDULE.arrival_time == 13.0
    assert SCHEDULE.name == "amr_1"


def test_shifted_is_the_same_motion_later() -> None:
    later = SCHEDULE.shifted(10.0)
    assert later.arc_length(21.0) == SCHEDULE.arc_length(11.0)
    assert SCHEDULE.arrival_time == 13.0, "the first one stays as it was"


def test_a_fleet_sums_up() -> None:
    other = Schedule(robot("amr_2", (9, 9)), np.array([0.0]), np.array([4.0]))
    fleet = FleetSchedule((SCHEDULE, other))
    assert fleet["amr_2"] is other
    assert (fleet.makespan, fleet.sum_of_completion) == (13.0, 17.0)
    assert FleetSchedule(()).makespan == 0.0


@pytest.mark.parametrize("arcs, times", [
    ([0.0, 7.0], [0.0]), ([], []), ([[0.0]], [[0.0]]), ([0.0, math.nan], [0.0, 1.0]), ([0.0, 7.0], [0.0, math.inf]),
    ([0.0, 7.0], [1.0, 1.0]), ([0.0, 7.0], [1.0, 0.5]), ([7.0, 0.0], [0.0, 1.0])])
def test_arrays_that_do_not_fit_are_refused(arcs: Any, times: Any) -> None:
    with pytest.raises(InvalidSchedule, match="amr_1"):
        Schedule(ROBOT, np.array(arcs), np.array(times))
