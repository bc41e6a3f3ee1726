"""Shapes of obstacles in the map frame, each validated when it is made.

An obstacle is physical: a robot's disc keeps clear of it. (`planning.overlays.discs.Disc` is something else: a place
that a path's centre line keeps out of.)
"""

import math
from dataclasses import dataclass
from typing import Any, List, Sequence, Tuple, Union

import numpy as np

from social_fleet.errors import InvalidOverlay
from social_fleet.mapping.grid import OccupancyGrid

Corner = Tuple[float, float]

MAX_VERTICES = 500  # of a polygon; more than any obstacle needs, and few enough to be checked at once


@dataclass(frozen=True)
class DiscObstacle:
    """A disc: centre `x`, `y` [m, map frame] and `radius` [m]."""

    x: float
    y: float
    radius: float

    def __post_init__(self) -> None:
        _check_numbers(self, ("x", "y"))
        _check_positive(self, ("radius",))

    @property
    def extent(self) -> np.ndarray:
        """Corners (4, 2) [m] of the square about it."""
        return np.array([(self.x + across * self.radius, self.y + along * self.radius)
                         for across, along in ((-1, -1), (1, -1), (1, 1), (-1, 1))])

    def distances(self, points: np.ndarray) -> np.ndarray:
        """Distance [m] from each of `points` (M, 2) to the disc, 0 inside."""
        return np.maximum(np.hypot(points[:, 0] - self.x, points[:, 1] - self.y) - self.radius, 0.0)


@dataclass(frozen=True)
class Rectangle:
    """A rectangle: centre `x`, `y` [m, map frame], `width` along its own x and `height` along y [m], `yaw` [rad]."""

    x: float
    y: float
    width: float
    height: float
    yaw: float = 0.0

    def __post_init__(self) -> None:
        _check_numbers(self, ("x", "y", "yaw"))
        _check_positive(self, ("width", "height"))

    @property
    def extent(self) -> np.ndarray:
        """Its corners (4, 2) [m], counter-clockwise."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        ends = 0.5 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (self.width, self.height)
        return ends @ np.array([[cos, sin], [-sin, cos]]) + (self.x, self.y)

    def distances(self, points: np.ndarray) -> np.ndarray:
        """Distance [m] from each of `points` (M, 2) to the rectangle, 0 inside."""
        return polygon_distances(self.extent, points)


@dataclass(frozen=True)
class Polygon:
    """A simple polygon, convex or not: its `vertices` (x, y) [m, map frame] in order, either way round.

    Raises
    ------
    InvalidOverlay
        For fewer than 3 vertices, a number that is not finite, sides that cross or touch, or no area.
    """

    vertices: Tuple[Corner, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", _checked_points(self.vertices, "vertices"))
        if len(self.vertices) < 3:
            raise InvalidOverlay(f"a polygon needs at least 3 vertices, not {len(self.vertices)}", field="vertices")
        if len(self.vertices) > MAX_VERTICES:
            raise InvalidOverlay(f"has {len(self.vertices)} vertices, more than {MAX_VERTICES}; leave some out, or "
                                 "give the obstacle as cells", field="vertices")
        pair = _crossing_sides(self.extent)
        if pair:
            raise InvalidOverlay(f"the sides from vertex {pair[0]} and from vertex {pair[1]} cross or touch; "
                                 "give the vertices in order along the outline", field="vertices")
        if abs(_area(self.extent)) < 1e-9:
            raise InvalidOverlay("the polygon has no area", field="vertices")

    @property
    def extent(self) -> np.ndarray:
        """The vertices as an (N, 2) array [m]."""
        return np.array(self.vertices)

    def distances(self, points: np.ndarray) -> np.ndarray:
        """Distance [m] from each of `points` (M, 2) to the polygon, 0 inside."""
        return polygon_distances(self.extent, points)


@dataclass(frozen=True)
class Cells:
    """Whole cells of a map: those that hold the `points` (x, y) [m, map frame]; `size` [m] is a cell's edge."""

    points: Tuple[Corner, ...]
    size: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", _checked_points(self.points, "points"))
        _check_positive(self, ("size",))
        if not self.points:
            raise InvalidOverlay("there must be at least one cell", field="points")

    @classmethod
    def of(cls, grid: OccupancyGrid, cells: Any) -> "Cells":
        """The cells (M, 2) of `grid` given as (row, column), or where a mask (rows, columns) of bool is true."""
        array = np.asarray(cells)
        if array.dtype == bool:
            if array.shape != grid.shape:
                raise InvalidOverlay(f"the mask of {array.shape} cells does not fit a map of {grid.shape}",
                                     field="cells")
            array = np.argwhere(array)
        if array.ndim != 2 or array.shape[1] != 2 or array.dtype.kind not in "iu":
            raise InvalidOverlay("must be pairs (row, column) of whole numbers, or a mask of bool", field="cells")
        return cls(tuple((x, y) for x, y in grid.centres(array).tolist()), grid.resolution)

    @property
    def extent(self) -> np.ndarray:
        """Corners (4, 2) [m] of the rectangle about it along the map's axes, turned cells included."""
        points = np.array(self.points)
        low, high = points.min(axis=0) - self.size, points.max(axis=0) + self.size
        return np.array([low, (high[0], low[1]), high, (low[0], high[1])])

    def distances(self, points: np.ndarray) -> np.ndarray:
        """Distance [m] from each of `points` (M, 2) to the nearest cell, taken as the disc within it, 0 inside."""
        from scipy.spatial import cKDTree
        gaps, _ = cKDTree(np.array(self.points)).query(points)
        return np.maximum(gaps - 0.5 * self.size, 0.0)


Shape = Union[DiscObstacle, Rectangle, Polygon, Cells]


def inside_polygon(corners: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Which places lie inside, by the even-odd rule: how many sides a ray along +x crosses."""
    inside = np.zeros(np.broadcast(x, y).shape, dtype=bool)
    for (x_a, y_a), (x_b, y_b) in zip(corners, np.roll(corners, -1, axis=0)):
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


def _area(corners: np.ndarray) -> float:
    following = np.roll(corners, -1, axis=0)
    return float(0.5 * (corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0]).sum())


def _crossing_sides(corners: np.ndarray) -> Tuple[int, ...]:
    """The first two sides that have more in common than a vertex between them; empty when there are none."""
    count = len(corners)
    following = np.roll(corners, -1, axis=0)
    for first in range(count):
        for second in range(first + 1, count):
            adjacent = second == first + 1 or (first == 0 and second == count - 1)
            a, b = corners[first], following[first]
            c, d = corners[second], following[second]
            if _fold_back(a, b, c, d, first, second) if adjacent else _meet(a, b, c, d):
                return first, second
    return ()


def _fold_back(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray, first: int, second: int) -> bool:
    """Whether two sides in succession lie on each other, or one has no length."""
    before, joint, after = (a, b, d) if second == first + 1 else (c, d, b)
    one, other = joint - before, after - joint
    scale = math.hypot(*one) * math.hypot(*other)
    return bool(scale == 0.0 or (abs(one[0] * other[1] - one[1] * other[0]) <= 1e-12 * scale and one @ other < 0.0))


def _meet(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> bool:
    """Whether the closed segments a-b and c-d have a point in common."""
    def turn(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> float:
        return float(np.sign((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])))

    if (np.maximum(a, b) < np.minimum(c, d)).any() or (np.maximum(c, d) < np.minimum(a, b)).any():
        return False
    return turn(a, b, c) * turn(a, b, d) <= 0.0 and turn(c, d, a) * turn(c, d, b) <= 0.0


def _checked_points(value: Any, field: str) -> Tuple[Corner, ...]:
    points: List[Corner] = []
    for index, point in enumerate(_listed(value, field)):
        numbers = [float(number) for number in point] if _is_pair(point) else []
        if not numbers or not all(map(math.isfinite, numbers)):
            raise InvalidOverlay(f"must be two finite numbers (x, y), not {point!r}", field=f"{field}[{index}]")
        points.append((numbers[0], numbers[1]))
    return tuple(points)


def _listed(value: Any, field: str) -> Sequence[Any]:
    if isinstance(value, np.ndarray):
        return value.tolist()
    if not isinstance(value, (list, tuple)):
        raise InvalidOverlay(f"must be a list of (x, y), not {value!r}", field=field)
    return value


def _is_pair(point: Any) -> bool:
    return isinstance(point, (list, tuple)) and len(point) == 2 and all(map(_is_number, point))


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def _check_numbers(shape: Any, names: Sequence[str]) -> None:
    for name in names:
        value = getattr(shape, name)
        if not (_is_number(value) and math.isfinite(value)):
            raise InvalidOverlay(f"must be a finite number, not {value!r}", field=name)


def _check_positive(shape: Any, names: Sequence[str]) -> None:
    _check_numbers(shape, names)
    for name in names:
        if getattr(shape, name) <= 0.0:
            raise InvalidOverlay(f"must be positive, not {getattr(shape, name)!r}", field=name)
