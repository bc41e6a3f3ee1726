"""Stopping in whole steps: never past the mark, and not short of it."""

import pytest

from social_fleet.execution.braking import approach, stopping_speed


@pytest.mark.parametrize("distance", [0.001, 0.01, 0.1, 0.5, 1.7])
@pytest.mark.parametrize("period", [0.02, 0.05, 0.1])
def test_obeying_it_stops_exactly_at_the_mark(distance: float, period: float) -> None:
    position, speed, deceleration = 0.0, 5.0, 0.8
    speed = stopping_speed(distance, deceleration, period)
    for _ in range(1000):
        position += speed * period
        wanted = stopping_speed(distance - position, deceleration, period)
        assert speed - wanted <= 1.13 * deceleration * period
        speed = wanted
    assert position == pytest.approx(distance, abs=1e-9)


def test_no_room_is_a_standstill() -> None:
    assert stopping_speed(0.0, 1.0, 0.05) == stopping_speed(-1.0, 1.0, 0.05) == 0.0


def test_approach_goes_as_far_as_it_may() -> None:
    assert [approach(1.0, target, 0.5) for target in (0.0, 0.8, 1.2, 3.0)] == [0.5, 0.8, 1.2, 1.5]
