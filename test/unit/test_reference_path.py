"""The tracker's look-ups on a path."""

import math
from typing import Tuple

import numpy as np
import pytest

from social_fleet.coordination.robot import Robot
from social_fleet.execution.reference_path import ReferencePath

CORNER = ReferencePath(Robot("gold", np.array([(0, 0), (2, 0), (2, 2)])))


def test_a_sharp_vertex_has_a_heading_to_arrive_and_one_to_leave() -> None:
    assert CORNER.pose(0, 2.0) == pytest.approx((2.0, 0.0, 0.0))
    assert CORNER.pose(1, 2.0) == pytest.approx((2.0, 0.0, math.pi / 2))


def test_straight_pieces_are_exact() -> None:
    assert CORNER.pose(0, 1.234) == pytest.approx((1.234, 0.0, 0.0))
    assert CORNER.pose(1, 3.5) == pytest.approx((2.0, 1.5, math.pi / 2))


def test_speed_is_zero_at_the_stops_and_high_between() -> None:
    assert [CORNER.speed(0, 0.0), CORNER.speed(0, 2.0), CORNER.speed(1, 4.0)] == pytest.approx(
        [0.0, 0.0, 0.0], abs=1e-6)
    assert CORNER.speed(0, 1.0) == pytest.approx(0.693)


@pytest.mark.parametrize("point, low, high, arc_length", [
    ((1.0, 0.3), 0.0, 2.0, 1.0), ((1.0, 0.3), 1.2, 4.0, 1.2), ((2.4, 1.0), 0.0, 4.0, 3.0), ((2.5, -0.5), 0.0, 4.0, 2.0),
    ((9.0, 9.0), 0.0, 4.0, 4.0), ((0.0, 0.0), 2.0, 2.0, 2.0)])
def test_projection(point: Tuple[float, float], low: float, high: float, arc_length: float) -> None:
    assert CORNER.project(*point, low, high) == pytest.approx(arc_length)
    polyline = Robot("gold", np.array([(0, 0), (2, 0), (2, 2)])).path
    assert polyline.project(point, low, high) == pytest.approx(arc_length)
