"""Poses, angles and polylines."""

import math

import numpy as np
import pytest

from social_fleet.errors import InvalidInput
from social_fleet.geometry import Polyline, Pose, compose, inverse, wrap_angle

CORNER = Polyline([(0.0, 0.0), (3.0, 0.0), (3.0, 4.0)])


@pytest.mark.parametrize("angle, wrapped", [
    (0.0, 0.0), (math.pi, math.pi), (-math.pi, math.pi), (3.5 * math.pi, -0.5 * math.pi), (-7.0, 2.0 * math.pi - 7.0)])
def test_angles_are_wrapped_into_one_turn(angle: float, wrapped: float) -> None:
    assert wrap_angle(angle) == pytest.approx(wrapped, abs=1e-12)


def test_a_pose_in_a_frame_and_back() -> None:
    frame, local = Pose(2.0, 1.0, math.pi / 2.0), Pose(3.0, -1.0, 0.3)
    assert compose(frame, local) == pytest.approx((3.0, 4.0, math.pi / 2.0 + 0.3))
    assert compose(inverse(frame), compose(frame, local)) == pytest.approx(local)
    assert compose(frame, inverse(frame)) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


def test_arc_length_and_position() -> None:
    assert CORNER.length == 7.0
    assert CORNER.arc_lengths.tolist() == [0.0, 3.0, 7.0]
    assert CORNER.position(4.0).tolist() == [3.0, 1.0]
    assert CORNER.position(np.array([-1.0, 1.0, 99.0])).tolist() == [[0.0, 0.0], [1.0, 0.0], [3.0, 4.0]]


def test_at_a_vertex_the_segment_after_it_counts() -> None:
    assert CORNER.heading(2.9) == 0.0
    assert CORNER.heading(3.0) == pytest.approx(math.pi / 2.0)
    assert CORNER.heading(7.0) == pytest.approx(math.pi / 2.0), "there is none after the last"
    assert [CORNER.segment_index(arc) for arc in (-1.0, 0.0, 3.0, 7.0, 9.0)] == [0, 0, 1, 1, 1]
    assert CORNER.segment_headings == pytest.approx([0.0, math.pi / 2.0])


def test_repeated_points_are_dropped() -> None:
    path = Polyline([(0, 0), (0, 0), (1, 0), (1, 0), (1, 0), (2, 0)])
    assert path.points.tolist() == [[0, 0], [1, 0], [2, 0]]
    assert (np.diff(path.arc_lengths) > 0.0).all()
    assert Polyline([(5, 5), (5, 5)]).points.tolist() == [[5, 5]]


def test_one_point_is_a_path_of_no_length() -> None:
    path = Polyline([(1.0, 2.0)])
    assert path.length == 0.0
    assert path.heading(0.0) == 0.0
    assert path.position(3.0).tolist() == [1.0, 2.0]
    assert path.project((9.0, 9.0), 0.0, 5.0) == 0.0
    assert len(path.segment_headings) == 0


def test_the_path_cannot_be_changed_from_outside() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0]])
    path = Polyline(points)
    points[1] = 9.0
    assert path.length == 1.0
    with pytest.raises(ValueError):
        path.points[0, 0] = 5.0


def test_projection_against_dense_sampling() -> None:
    rng = np.random.RandomState(4)
    for _ in range(50):
        path = Polyline(rng.uniform(0.0, 5.0, (6, 2)))
        point = rng.uniform(-1.0, 6.0, 2)
        low, high = np.sort(rng.uniform(0.0, path.length, 2))
        samples = np.linspace(low, high, 4001)
        best = np.hypot(*(path.position(samples) - point).T).min()
        arc = path.project(tuple(point), low, high)
        assert low <= arc <= high
        assert np.hypot(*(path.position(arc) - point)) <= best + 1e-9


def test_projection_keeps_to_the_stretch_asked_for() -> None:
    there_and_back = Polyline([(0, 0), (10, 0), (0, 0)])
    assert there_and_back.project((4.0, 1.0), 0.0, 20.0) == pytest.approx(4.0), "the first of equals"
    assert there_and_back.project((4.0, 1.0), 8.0, 20.0) == pytest.approx(16.0)
    assert there_and_back.project((4.0, 1.0), 6.0, 9.0) == pytest.approx(6.0)
    assert there_and_back.project((4.0, 1.0), 50.0, 60.0) == pytest.approx(20.0), "clamped to the path"


def test_a_slice_keeps_the_vertices_between() -> None:
    assert CORNER.slice(1.0, 5.0).points.tolist() == [[1.0, 0.0], [3.0, 0.0], [3.0, 2.0]]
    assert CORNER.slice(3.0, 7.0).length == pytest.approx(4.0)
    assert CORNER.slice(2.0, 2.0).points.tolist() == [[2.0, 0.0]]


@pytest.mark.parametrize("points", [
    [], [1.0, 2.0], [[1.0, 2.0, 3.0]], [[0.0, math.nan]], [[math.inf, 0.0]], None, "ab", [[0.0, "east"]],
    [[0.0, 0.0], [1.0]]])
def test_what_is_no_path_is_refused(points: object) -> None:
    with pytest.raises(InvalidInput):
        Polyline(points)  # type: ignore[arg-type]
