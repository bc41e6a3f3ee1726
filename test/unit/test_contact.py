"""Contacts of discs in straight motion, against motions sampled densely."""

import math
from typing import Tuple

import numpy as np
import pytest

from social_fleet.coordination.baselines.contact import contact, unsafe_departures


def smallest_gap(move: Tuple[float, ...], leave: float, other: Tuple[float, ...]) -> float:
    """Least distance [m] while both motions last, sampled; infinite where they do not overlap."""
    x, y, wx, wy, duration = move
    begin, end, px, py, ux, uy = other
    low, high = max(leave, begin), min(leave + duration, end)
    if low > high:
        return math.inf
    times = np.linspace(low, high, 4001)
    return float(np.hypot(x + wx * (times - leave) - px - ux * (times - begin),
                          y + wy * (times - leave) - py - uy * (times - begin)).min())


def test_head_on_the_contact_lasts_while_they_pass_through_each_other() -> None:
    assert contact(-3.0, 0.0, 2.0, 0.0, 10.0, 1.0) == pytest.approx((1.0, 2.0))


def test_passing_at_just_the_reach_is_no_contact() -> None:
    first, last = contact(-3.0, 1.0, 2.0, 0.0, 10.0, 1.0)
    assert first >= last


@pytest.mark.parametrize("offset, touches", [(0.5, True), (1.5, False)])
def test_two_that_stand_touch_always_or_never(offset: float, touches: bool) -> None:
    first, last = contact(offset, 0.0, 0.0, 0.0, math.inf, 1.0)
    assert (first, last) == (0.0, math.inf) if touches else first >= last


def test_it_is_cut_to_the_duration() -> None:
    assert contact(0.0, 0.0, 1.0, 0.0, 0.25, 1.0) == (0.0, 0.25)


def test_one_that_parks_for_ever_ends_all_departures() -> None:
    low, high = unsafe_departures(0.0, 0.0, 1.0, 0.0, 4.0, 10.0, math.inf, 2.0, 0.0, 0.0, 0.0, 0.5)
    assert (low, high) == pytest.approx((7.5, math.inf))


def test_one_that_has_always_stood_there_ends_all_departures_until_it_leaves() -> None:
    low, high = unsafe_departures(0.0, 0.0, 1.0, 0.0, 4.0, -math.inf, 3.0, 2.0, 0.0, 0.0, 0.0, 0.5)
    assert (low, high) == pytest.approx((-math.inf, 1.5))


@pytest.mark.parametrize("seed", range(60))
def test_departures_are_unsafe_exactly_between_the_two(seed: int) -> None:
    rng = np.random.RandomState(seed)
    angle, other_angle = rng.uniform(0.0, 2.0 * math.pi, 2) if seed % 3 else (0.0, math.pi * (seed % 2))
    speed, other_speed = rng.uniform(0.2, 1.5, 2) if seed % 4 else (0.7, 0.7)
    move = (*rng.uniform(-1.0, 1.0, 2), speed * math.cos(angle), speed * math.sin(angle), rng.uniform(0.5, 4.0))
    begin = rng.uniform(0.0, 5.0)
    other = (begin, begin + rng.uniform(0.5, 6.0), *rng.uniform(-1.0, 1.0, 2), other_speed * math.cos(other_angle),
             other_speed * math.sin(other_angle))
    reach = rng.uniform(0.2, 1.2)
    low, high = unsafe_departures(*move, *other, reach)
    for leave in np.linspace(begin - 6.0, other[1] + 2.0, 80):
        gap = smallest_gap(move, leave, other)
        if low < leave < high:
            assert gap < reach + 1e-5
        elif low >= high or leave < low - 0.01 or leave > high + 0.01:
            assert gap >= reach - 1e-6
    if low < high:
        inside = np.linspace(low, high, 13)[1:-1]
        assert all(smallest_gap(move, leave, other) < reach + 1e-5 for leave in inside)
