"""Simple polygons: whether an outline is one, and which places it holds."""

import math
from typing import Any, List, Optional, Sequence, Tuple, Type, Union

import numpy as np

from social_fleet.errors import InvalidInput

Corner = Tuple[float, float]


def checked_polygon(value: Any, error: Type[InvalidInput], *, field: str = "polygon") -> Tuple[Corner, ...]:
    """The corners of a simple polygon, in order along its outline, either way round.

    Parameters
    ----------
    value : sequence of (x, y)
        [m], three or more.
    error, field
        What to raise, and the field that it names.

    Raises
    ------
    InvalidInput
        An `error`, when there are too few corners, a corner is not two finite numbers, or the outline crosses or
        touches itself.
    """
    if not isinstance(value, (list, tuple)) or len(value) < 3:
        raise error(f"must be a list of three corners [x, y] or more, not {value!r}", field=field)
    corners: List[Corner] = []
    for index, corner in enumerate(value):
        numbers = list(corner) if isinstance(corner, (list, tuple)) else []
        if len(numbers) != 2 or not all(map(_is_finite, numbers)):
            raise error(f"must be two finite numbers [x, y], not {corner!r}", field=f"{field}[{index}]")
        corners.append((float(numbers[0]), float(numbers[1])))
    crossing = crossing_sides(corners)
    if crossing is not None:
        raise error(f"the sides that begin at corners {crossing[0]} and {crossing[1]} cross or touch; give the corners "
                    "in order along the outline", field=field)
    return tuple(corners)


def inside_polygon(corners: Union[np.ndarray, Sequence[Sequence[float]]], x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Which places (x, y) a polygon holds, by the even-odd rule: how many sides a ray along +x crosses.

    Ranges are half-open, so that polygons that share a side neither overlap nor leave a gap.
    """
    inside = np.zeros(np.broadcast(x, y).shape, dtype=bool)
    for (x_a, y_a), (x_b, y_b) in zip(corners, [*corners[1:], corners[0]]):
        if y_a != y_b:
            crossing = x_a + (y - y_a) * ((x_b - x_a) / (y_b - y_a))
            inside ^= ((y_a <= y) != (y_b <= y)) & (x < crossing)
    return inside


def polygon_distances(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distance from each of `points` (M, 2) to the polygon of `corners` (N, 2), 0 inside."""
    nearest = np.full(len(points), np.inf)
    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        side = b - a
        share = np.clip((points - a) @ side / max(side @ side, 1e-300), 0.0, 1.0)
        nearest = np.minimum(nearest, np.hypot(*(points - a - share[:, None] * side).T))
    return np.where(inside_polygon(corners, points[:, 0], points[:, 1]), 0.0, nearest)


def crossing_sides(corners: Sequence[Corner]) -> Optional[Tuple[int, int]]:
    """First two sides, by the index of their first corner, that share more than the corner between them."""
    count = len(corners)
    for first in range(count):
        a, b = corners[first], corners[(first + 1) % count]
        if a == b:
            return first, (first + 1) % count
        for second in range(first + 1, count):
            c, d = corners[second], corners[(second + 1) % count]
            if second == first + 1:
                touch = _turn(a, b, d) == 0.0 and _dot(b, a, d) > 0.0
            elif first == 0 and second == count - 1:
                touch = _turn(c, a, b) == 0.0 and _dot(a, c, b) > 0.0
            else:
                touch = _meet(a, b, c, d)
            if touch:
                return first, second
    return None


def _is_finite(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _turn(a: Corner, b: Corner, c: Corner) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _dot(origin: Corner, a: Corner, b: Corner) -> float:
    return (a[0] - origin[0]) * (b[0] - origin[0]) + (a[1] - origin[1]) * (b[1] - origin[1])


def _meet(a: Corner, b: Corner, c: Corner, d: Corner) -> bool:
    """Whether the closed segments a-b and c-d have a point in common."""
    for axis in (0, 1):
        if max(a[axis], b[axis]) < min(c[axis], d[axis]) or max(c[axis], d[axis]) < min(a[axis], b[axis]):
            return False
    return (_turn(a, b, c) * _turn(a, b, d) <= 0.0) and (_turn(c, d, a) * _turn(c, d, b) <= 0.0)
