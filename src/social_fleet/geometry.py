"""Poses, angles and polylines measured by arc length.

Everything is in metres and radians, in the map frame (REP 103), unless a name says otherwise.
"""

import math
from typing import NamedTuple, Sequence, Union

import numpy as np

from social_fleet.errors import InvalidInput


class Pose(NamedTuple):
    """A position [m] and heading [rad, counter-clockwise from x] in the plane."""

    x: float
    y: float
    yaw: float = 0.0


def wrap_angle(angle: float) -> float:
    """`angle` [rad] brought into (-pi, pi]."""
    wrapped = math.fmod(angle + math.pi, 2.0 * math.pi)
    if wrapped <= 0.0:
        wrapped += 2.0 * math.pi
    return wrapped - math.pi


def compose(frame: Pose, local: Pose) -> Pose:
    """The pose `local`, given in `frame`, expressed in the parent of `frame`."""
    cos, sin = math.cos(frame.yaw), math.sin(frame.yaw)
    return Pose(frame.x + cos * local.x - sin * local.y,
                frame.y + sin * local.x + cos * local.y,
                wrap_angle(frame.yaw + local.yaw))


def inverse(pose: Pose) -> Pose:
    """The pose of the parent frame as seen from `pose`."""
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    return Pose(-cos * pose.x - sin * pose.y, sin * pose.x - cos * pose.y, wrap_angle(-pose.yaw))


class Polyline:
    """An immutable chain of straight segments, addressed by arc length from its start.

    Parameters
    ----------
    points : (N, 2) array_like
        Vertices [m], N >= 1. Repeated neighbours are dropped.

    Raises
    ------
    InvalidInput
        When the array has another shape or holds values that are not finite.
    """

    def __init__(self, points: Union[np.ndarray, Sequence[Sequence[float]]]) -> None:
        try:
            array = np.array(points, dtype=float)
        except (TypeError, ValueError) as error:
            raise InvalidInput("a path needs points of two numbers each") from error
        if array.ndim != 2 or array.shape[0] < 1 or array.shape[1] != 2:
            raise InvalidInput("a path needs an (N, 2) array of points with N >= 1, not shape "
                               f"{array.shape}")
        if not np.isfinite(array).all():
            raise InvalidInput("a path holds a point that is not finite")
        if len(array) > 1:
            steps = np.hypot(*np.diff(array, axis=0).T)
            array = array[np.concatenate(([True], steps > 1e-9))]
        self.points = array
        self.arc_lengths = np.zeros(len(array))
        if len(array) > 1:
            self.arc_lengths[1:] = np.cumsum(np.hypot(*np.diff(array, axis=0).T))
        self.points.setflags(write=False)
        self.arc_lengths.setflags(write=False)

    @property
    def length(self) -> float:
        """Arc length from the first to the last vertex [m]."""
        return float(self.arc_lengths[-1])

    @property
    def segment_headings(self) -> np.ndarray:
        """Heading of every segment [rad], shape (N - 1,)."""
        steps = np.diff(self.points, axis=0)
        return np.arctan2(steps[:, 1], steps[:, 0])

    def position(self, arc_length: Union[float, np.ndarray]) -> np.ndarray:
        """The point(s) [m] at `arc_length`, clamped to the path: shape (2,) or (M, 2)."""
        return np.stack([np.interp(arc_length, self.arc_lengths, self.points[:, axis])
                         for axis in (0, 1)], axis=-1)

    def segment_index(self, arc_length: float) -> int:
        """Index of the segment that holds `arc_length`; at a vertex, the segment after it."""
        index = int(np.searchsorted(self.arc_lengths, arc_length, side="right")) - 1
        return min(max(index, 0), max(len(self.points) - 2, 0))

    def heading(self, arc_length: float) -> float:
        """Direction of travel [rad] at `arc_length`; at a vertex, that of the segment after it. 0 for one point."""
        if len(self.points) == 1:
            return 0.0
        index = self.segment_index(arc_length)
        step = self.points[index + 1] - self.points[index]
        return math.atan2(step[1], step[0])

    def project(self, point: Sequence[float], low: float, high: float) -> float:
        """Arc length within [low, high] whose point is nearest to `point`; the first of equals."""
        if len(self.points) == 1:
            return 0.0
        low = min(max(low, 0.0), self.length)
        high = min(max(high, low), self.length)
        first, last = self.segment_index(low), self.segment_index(high)
        starts = self.points[first:last + 1]
        steps = self.points[first + 1:last + 2] - starts
        offsets = np.asarray(point, dtype=float) - starts
        lengths = np.hypot(steps[:, 0], steps[:, 1])
        along = np.einsum("ij,ij->i", offsets, steps) / lengths
        base = self.arc_lengths[first:last + 1]
        arcs = np.clip(base + np.clip(along, 0.0, lengths), low, high)
        gaps = starts + steps * ((arcs - base) / lengths)[:, None] - np.asarray(point, dtype=float)
        return float(arcs[int(np.argmin(np.hypot(gaps[:, 0], gaps[:, 1])))])

    def slice(self, low: float, high: float) -> "Polyline":
        """The part of the path between two arc lengths [m]."""
        inner = (self.arc_lengths > low) & (self.arc_lengths < high)
        return Polyline(np.vstack([self.position(low), self.points[inner], self.position(high)]))
