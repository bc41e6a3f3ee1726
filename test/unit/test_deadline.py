"""A time limit as compiled searches see it."""

import time

import pytest

from social_fleet.coordination.baselines.deadline import Deadline
from social_fleet.errors import InvalidParameter, TimedOut


def test_it_rings_when_the_time_has_passed() -> None:
    with Deadline(0.05) as deadline:
        assert deadline.stop[0] == 0
        deadline.check("the search")
        end = time.monotonic() + 20.0
        while not deadline.stop[0] and time.monotonic() < end:
            time.sleep(0.01)
        with pytest.raises(TimedOut, match="the search found no schedule within 0.05 s"):
            deadline.check("the search")


def test_it_does_not_ring_after_it_was_left() -> None:
    with Deadline(0.2) as deadline:
        pass
    time.sleep(0.3)
    assert deadline.stop[0] == 0


@pytest.mark.parametrize("limit", [0.0, -1.0, float("nan")])
def test_a_limit_that_is_none_is_refused(limit: float) -> None:
    with pytest.raises(InvalidParameter, match="time_limit: must be a positive number"):
        Deadline(limit)
