"""The driven curve: close to the polyline, smooth, exact at the stops, and as fast as the limits allow."""

import math

import numpy as np
import pytest
from fleets import random_path

from social_fleet.coordination.driven_path import CUT, driven_legs, sampled
from social_fleet.coordination.robot import MotionLimits
from social_fleet.coordination.timing import turning_points
from social_fleet.geometry import Polyline

LIMITS = MotionLimits()
BEND = Polyline([(0, 0), (3, 0), (6, 3 * math.tan(math.radians(15)))])


def test_a_gentle_bend_is_rounded_by_little() -> None:
    leg, = driven_legs(BEND, [])
    gaps = np.hypot(*(leg.points - BEND.position(leg.arc_lengths)).T)
    assert 0.5 * CUT < gaps.max() <= CUT
    assert (np.diff(leg.headings) >= -1e-9).all()
    assert leg.headings[0] == pytest.approx(0.0) and leg.headings[-1] == pytest.approx(math.radians(15))


def test_the_average_is_that_of_many_points() -> None:
    leg, = driven_legs(BEND, [])
    middle = int(np.argmin(np.abs(leg.arc_lengths - 3.0)))
    around = leg.arc_lengths[middle] + np.linspace(-0.24, 0.24, 4001)
    for half_width in (0.3, 0.24, 0.18, 0.12):
        weights = np.maximum(half_width - np.abs(around - leg.arc_lengths[middle]), 0.0)
        average = np.average(BEND.position(around), axis=0, weights=weights)
        if np.allclose(average, leg.points[middle], atol=1e-5):
            return
    pytest.fail("no half width explains the curve")


@pytest.mark.parametrize("seed", range(6))
def test_speeds_keep_to_every_limit(seed: int) -> None:
    path = Polyline(random_path(np.random.RandomState(seed), 6, 5.0))
    for leg in driven_legs(path, turning_points(path)[0].tolist()):
        speeds = leg.permitted_speeds(LIMITS)
        assert speeds[0] == speeds[-1] == 0.0 and speeds[1:-1].min() > 0.0
        assert speeds.max() <= LIMITS.max_speed + 1e-12
        assert (np.abs(np.diff(speeds ** 2)) <= 2.0 * LIMITS.max_acceleration * leg.step + 1e-9).all()
        rates = np.gradient(leg.headings, leg.step) * speeds
        assert np.abs(rates).max() <= LIMITS.max_turn_rate + 1e-9


def test_every_leg_begins_and_ends_on_the_path() -> None:
    path = Polyline([(0, 0), (2, 0), (2, 2), (0, 2.2)])
    legs = driven_legs(path, turning_points(path)[0].tolist())
    assert [leg.points[0].tolist() for leg in legs] == path.points[:-1].tolist()
    assert [leg.points[-1].tolist() for leg in legs] == path.points[1:].tolist()
    assert [leg.headings[0] for leg in legs] == pytest.approx([0.0, math.pi / 2, path.segment_headings[2]])


def test_a_point_and_a_millimetre_are_paths_too() -> None:
    point, = driven_legs(Polyline([(1, 2)]), [])
    assert point.points.tolist() == [[1, 2]] * len(point.points)
    short, = driven_legs(Polyline([(0, 0), (0.001, 0)]), [])
    assert short.permitted_speeds(LIMITS)[1:-1].min() > 0.0


def test_thinned_samples_keep_the_stops() -> None:
    path = Polyline([(0, 0), (2, 0), (2, 0.01), (4, 0.01)])
    legs = driven_legs(path, turning_points(path)[0].tolist())
    arcs, speeds = sampled(legs, [leg.permitted_speeds(LIMITS) for leg in legs], 0.1)
    assert (np.diff(arcs) > 0.0).all()
    assert arcs[speeds == 0.0].tolist() == pytest.approx([0.0, 2.0, 2.01, 4.01])
