"""The fastest motion along a path: within every limit, from standstill to standstill, turns included."""

import math

import numpy as np
import pytest
from fleets import random_path

from social_fleet.coordination.robot import MotionLimits
from social_fleet.coordination.timing import (ACCELERATION_SHARE, SPEED_SHARE, TURN_SHARE, Timing, nominal_timing,
                                              speed_profile, turn_duration, turning_points)
from social_fleet.geometry import Polyline

LIMITS = MotionLimits()
SPEED = SPEED_SHARE * LIMITS.max_speed
ACCELERATION = ACCELERATION_SHARE * LIMITS.max_acceleration
RATE = TURN_SHARE * LIMITS.max_turn_rate


def arc_of(radius: float, degrees: float, step: float = 0.05) -> Polyline:
    """A bend in a circle, as a chain of short chords [m]."""
    angles = np.arange(0.0, math.radians(degrees), step / radius)
    return Polyline(radius * np.stack((np.cos(angles), np.sin(angles)), axis=1))


def test_a_straight_line_is_a_trapezoid() -> None:
    timing = nominal_timing(Polyline([(0, 0), (10, 0)]), LIMITS)
    assert timing.duration == pytest.approx(10.0 / SPEED + SPEED / ACCELERATION, rel=2e-3)
    assert timing.duration >= 10.0 / SPEED + SPEED / ACCELERATION - 1e-9, "sampling may only slow it down"


def test_too_short_for_full_speed_is_a_triangle() -> None:
    timing = nominal_timing(Polyline([(0, 0), (0.2, 0)]), LIMITS)
    assert timing.duration == pytest.approx(2.0 * math.sqrt(0.2 / ACCELERATION), rel=1e-6)


@pytest.mark.parametrize("seed", range(12))
def test_every_limit_holds_along_random_paths(seed: int) -> None:
    path = Polyline(random_path(np.random.RandomState(seed), 8, 5.0))
    arcs, speeds = speed_profile(path, LIMITS)
    assert (np.diff(arcs) > 0.0).all() and arcs[0] == 0.0 and arcs[-1] == path.length
    assert speeds.max() <= SPEED + 1e-12 and (speeds[1:-1] + 1e-12 >= 0.0).all()
    assert speeds[0] == speeds[-1] == 0.0
    assert (np.abs(np.diff(speeds ** 2)) <= 2.0 * ACCELERATION * np.diff(arcs) + 1e-9).all()
    sharp, _ = turning_points(path)
    assert np.interp(sharp, arcs, speeds) == pytest.approx(0.0)
    timing = nominal_timing(path, LIMITS, start_yaw=0.0, goal_yaw=1.0)
    assert (np.diff(timing.times) > 0.0).all() and (np.diff(timing.arc_lengths) >= 0.0).all()
    driven = np.diff(timing.arc_lengths) / np.diff(timing.times)
    assert driven.max() <= SPEED + 1e-9, "no knot asks for more than the profile"


@pytest.mark.parametrize("radius", [0.3, 0.5, 1.0, 5.0])
def test_bends_are_driven_within_the_turn_rate(radius: float) -> None:
    path = arc_of(radius, 180.0)
    assert len(turning_points(path)[0]) == 0
    timing = nominal_timing(path, LIMITS)
    steady = np.arange(1.0, path.length - 1.0, 0.01) if path.length > 2.5 else np.array([path.length / 2.0])
    speed = 0.01 / (timing.first_time(steady + 0.005) - timing.first_time(steady - 0.005))
    assert (speed / radius <= RATE * 1.02).all()
    assert speed.max() == pytest.approx(min(SPEED, RATE * radius), rel=0.12), "and not slower than that asks for"


def test_sharp_corners_are_turned_standing() -> None:
    path = Polyline([(0, 0), (2, 0), (2, 2), (1, 2.1), (0, 2.2)])
    arcs, angles = turning_points(path)
    assert arcs == pytest.approx([2.0, 4.0])
    assert angles == pytest.approx([math.pi / 2.0, math.pi / 2.0 - math.atan(0.1)])
    timing = nominal_timing(path, LIMITS)
    pause = timing.last_time(2.0) - timing.first_time(2.0)
    assert pause == pytest.approx(turn_duration(math.pi / 2.0, LIMITS))
    assert timing.last_time(2.5) == timing.first_time(2.5)


@pytest.mark.parametrize("angle", [0.05, 0.2, 0.5, 1.0, math.pi / 2.0, math.pi])
def test_turns_against_an_integration(angle: float) -> None:
    step, turned, speed, clock = 1e-4, 0.0, 0.0, 0.0
    while turned < angle / 2.0:
        speed = min(speed + TURN_SHARE * LIMITS.max_turn_acceleration * step, RATE)
        turned, clock = turned + speed * step, clock + step
    assert turn_duration(angle, LIMITS) == pytest.approx(2.0 * clock, rel=0.01), "braking mirrors speeding up"
    assert turn_duration(-angle, LIMITS) == turn_duration(angle, LIMITS)


def test_turns_at_start_and_goal_take_time() -> None:
    path = Polyline([(0, 0), (3, 0)])
    free = nominal_timing(path, LIMITS).duration
    turned = nominal_timing(path, LIMITS, start_yaw=math.pi / 2.0, goal_yaw=-3.0)
    assert turned.duration == pytest.approx(
        free + turn_duration(math.pi / 2.0, LIMITS) + turn_duration(3.0, LIMITS))
    assert turned.last_time(0.0) == pytest.approx(turn_duration(math.pi / 2.0, LIMITS))
    assert turned.first_time(3.0) == pytest.approx(turned.duration - turn_duration(3.0, LIMITS))
    assert nominal_timing(path, LIMITS, start_yaw=0.0, goal_yaw=0.001).duration == pytest.approx(free)


def test_a_path_of_one_point() -> None:
    assert nominal_timing(Polyline([(1, 1)]), LIMITS).duration == 0.0
    assert nominal_timing(Polyline([(1, 1)]), LIMITS, goal_yaw=2.0).duration == 0.0, "nothing says where it looks now"
    turned = nominal_timing(Polyline([(1, 1)]), LIMITS, start_yaw=3.0, goal_yaw=-3.0)
    assert turned.duration == pytest.approx(turn_duration(2.0 * math.pi - 6.0, LIMITS)), "the short way round"


@pytest.mark.parametrize("step", [1e-3, 1e-6])
def test_tiny_segments_neither_stop_nor_speed_the_robot(step: float) -> None:
    fine = Polyline(np.stack((np.append(step * np.arange(1000), 4.0), np.zeros(1001)), axis=1))
    coarse = Polyline([(0, 0), (4, 0)])
    assert nominal_timing(fine, LIMITS).duration == pytest.approx(nominal_timing(coarse, LIMITS).duration, rel=0.01)
    hairpins = nominal_timing(Polyline([(0, 0), (step, 0), (0, step), (step, step)]), LIMITS)
    assert 4.0 < hairpins.duration < 8.0 and (np.diff(hairpins.times) > 0.0).all(), "two turns of 135 degrees"


def test_times_round_a_wait_belong_to_the_right_side_of_it() -> None:
    timing = Timing(np.array([0.0, 2.0, 2.0, 6.0]), np.array([1.0, 3.0, 13.0, 15.0]))
    arcs = np.array([-1.0, 0.0, 1.0, 2.0, 4.0, 6.0, 9.0])
    assert timing.first_time(arcs).tolist() == [1.0, 1.0, 2.0, 3.0, 14.0, 15.0, 15.0]
    assert timing.last_time(arcs).tolist() == [1.0, 1.0, 2.0, 13.0, 14.0, 15.0, 15.0]
