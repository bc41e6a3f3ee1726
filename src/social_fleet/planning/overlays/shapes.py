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
from social_fleet.mapping.polygons import Corner, checked_polygon, polygon_distances

MAX_VERTICES = 500  # of a polygon; more than any obstacle needs, and few enough to be checked at once
FARTHEST = 1e9  # [m] of any place or extent; what is beyond lies off every map, and its squares may overflow


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
        For fewer than 3 vertices, a number that is not finite, or sides that cross or touch.
    """

    vertices: Tuple[Corner, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", _checked_points(self.vertices, "vertices"))
        if len(self.vertices) > MAX_VERTICES:
            raise InvalidOverlay(f"has {len(self.vertices)} vertices, more than {MAX_VERTICES}; leave some out, or "
                                 "give the obstacle as cells", field="vertices")
        checked_polygon(self.vertices, InvalidOverlay, field="vertices")

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


def _checked_points(value: Any, field: str) -> Tuple[Corner, ...]:
    points: List[Corner] = []
    for index, point in enumerate(_listed(value, field)):
        if not _is_pair(point):
            raise InvalidOverlay(f"must be two finite numbers (x, y), not {point!r:.80}", field=f"{field}[{index}]")
        points.append((float(point[0]), float(point[1])))
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
    number = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
    return number and bool(abs(value) <= FARTHEST)


def _check_numbers(shape: Any, names: Sequence[str]) -> None:
    for name in names:
        value = getattr(shape, name)
        if not _is_number(value):
            raise InvalidOverlay(f"must be a finite number, {FARTHEST:g} at most, not {value!r:.80}", field=name)


def _check_positive(shape: Any, names: Sequence[str]) -> None:
    _check_numbers(shape, names)
    for name in names:
        if getattr(shape, name) <= 0.0:
            raise InvalidOverlay(f"must be positive, not {getattr(shape, name)!r}", field=name)
