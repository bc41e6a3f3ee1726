"""Which cells of a map an obstacle touches."""

import math
from typing import Iterable, NamedTuple, Tuple

import numpy as np

from social_fleet.errors import InvalidOverlay
from social_fleet.mapping.grid import OCCUPIED, OccupancyGrid
from social_fleet.mapping.polygons import inside_polygon
from social_fleet.planning.overlays.shapes import Cells, DiscObstacle, Shape

_ROUNDING = 1e-9  # [cells]; a side along the edge between two cells touches neither of the other's side


class Raster(NamedTuple):
    """The cells of a shape: `mask` (rows, columns) bool begins at cell (`row`, `column`) and lies within the map."""

    row: int
    column: int
    mask: np.ndarray

    @property
    def cells(self) -> np.ndarray:
        """(row, column) of every cell, shape (M, 2)."""
        return np.argwhere(self.mask) + (self.row, self.column)


def rasterised(grid: OccupancyGrid, shape: Shape) -> Raster:
    """The cells of `grid` whose area the shape overlaps, a cell that it merely touches from outside excluded.

    Raises
    ------
    InvalidOverlay
        When the shape lies wholly off the map. What is partly on it counts as far as it is.
    """
    if isinstance(shape, Cells):
        return _of_cells(grid, shape)
    corners = grid.to_local(shape.extent) / grid.resolution
    low, high = corners.min(axis=0), corners.max(axis=0)
    left, bottom = (max(0, math.floor(value + _ROUNDING)) for value in low)
    right, top = (min(limit, math.ceil(value - _ROUNDING)) for value, limit in zip(high, grid.shape[::-1]))
    if left >= right or bottom >= top:
        raise _off(grid)
    x, y = np.arange(left, right)[None, :] + 0.5, np.arange(bottom, top)[:, None] + 0.5
    if isinstance(shape, DiscObstacle):
        centre = grid.to_local([(shape.x, shape.y)])[0] / grid.resolution
        aside, above = np.maximum(np.abs(x - centre[0]) - 0.5, 0.0), np.maximum(np.abs(y - centre[1]) - 0.5, 0.0)
        mask = aside ** 2 + above ** 2 < (shape.radius / grid.resolution - _ROUNDING) ** 2
    else:
        mask = _of_polygon(corners, x, y)
    if not mask.any():
        raise _off(grid)
    return Raster(bottom, left, mask)


def drawn_on(grid: OccupancyGrid, shapes: Iterable[Shape]) -> OccupancyGrid:
    """The map as it would be with the shapes' cells occupied."""
    values = grid.values.copy()
    for shape in shapes:
        row, column, mask = rasterised(grid, shape)
        values[row:row + mask.shape[0], column:column + mask.shape[1]][mask] = OCCUPIED
    return OccupancyGrid(values, grid.resolution, grid.origin)


def _of_cells(grid: OccupancyGrid, shape: Cells) -> Raster:
    places = np.floor(grid.to_local(shape.points)[:, ::-1] / grid.resolution + _ROUNDING)
    places = places[((places >= 0) & (places < grid.shape)).all(axis=1)].astype(np.int64)
    if not len(places):
        raise _off(grid)
    row, column = places.min(axis=0)
    mask = np.zeros(places.max(axis=0) - (row, column) + 1, dtype=bool)
    mask[places[:, 0] - row, places[:, 1] - column] = True
    return Raster(int(row), int(column), mask)


def _of_polygon(corners: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The unit squares about (x, y) that overlap the polygon: a side passes through, or the centre is inside."""
    mask = inside_polygon(corners, x, y)
    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        columns, rows = (_near(a[0], b[0], x[0]), _near(a[1], b[1], y[:, 0]))
        mask[rows, columns] |= _passes(a, b, x[:, columns], y[rows])
    return mask


def _near(a: float, b: float, centres: np.ndarray) -> slice:
    """The stretch of ascending `centres` less than a cell from the range between a and b."""
    return slice(int(np.searchsorted(centres, min(a, b) - 1.0)), int(np.searchsorted(centres, max(a, b) + 1.0)))


def _passes(a: np.ndarray, b: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Whether the segment a-b enters the open unit squares about (x, y), by separating axes."""
    middle, half = 0.5 * (a + b), 0.5 * (b - a)
    reach = 0.5 - _ROUNDING
    aside, above = x - middle[0], y - middle[1]
    length = max(math.hypot(half[0], half[1]), 1e-300)
    normal = -half[1] / length, half[0] / length
    apart = np.abs(aside * normal[0] + above * normal[1]) >= reach * (abs(normal[0]) + abs(normal[1]))
    return (np.abs(aside) < reach + abs(half[0])) & (np.abs(above) < reach + abs(half[1])) & ~apart


def _off(grid: OccupancyGrid) -> InvalidOverlay:
    low, high = map_bounds(grid)
    return InvalidOverlay(f"the obstacle lies off the map, which lies within x {low[0]:.2f} to {high[0]:.2f} m "
                          f"and y {low[1]:.2f} to {high[1]:.2f} m")


def map_bounds(grid: OccupancyGrid) -> Tuple[np.ndarray, np.ndarray]:
    """The least and greatest (x, y) [m] of a map in the map frame."""
    corners = grid.from_local([(0, 0), (grid.size[0], 0), grid.size, (0, grid.size[1])])
    return corners.min(axis=0), corners.max(axis=0)
