"""Exact distances to blocked cells, taken as closed squares. Everything here is in cells, along the grid's axes.

Beyond the map's border all is blocked. See doc/clearance.md for why two passes give the exact field.
"""

import math
from typing import Sequence, Tuple

import numpy as np
from numba import njit


@njit(cache=True)
def centre_clearance(blocked: np.ndarray, limit: float) -> np.ndarray:
    """Distance [cells] from every cell's centre to the nearest blocked square, capped at `limit`: float32.

    A centre that is `d` columns from a square is max(d - 1/2, 0) from it along that axis. The squares of both axes'
    parts add, so the nearest square of a column and then the best column give the exact minimum.
    """
    rows, columns = blocked.shape
    height = np.empty((rows, columns), dtype=np.int32)  # rows to the nearest blocked cell of the same column
    for column in range(columns):
        height[0, column] = 0 if blocked[0, column] else 1
    for row in range(1, rows):
        for column in range(columns):
            height[row, column] = 0 if blocked[row, column] else height[row - 1, column] + 1
    for column in range(columns):
        height[rows - 1, column] = min(height[rows - 1, column], 1)
    for row in range(rows - 2, -1, -1):
        for column in range(columns):
            height[row, column] = min(height[row, column], height[row + 1, column] + 1)

    cap = limit * limit
    longest = max(rows, columns) + 1
    squared = np.empty(longest + 1)
    for distance in range(longest + 1):
        squared[distance] = max(distance - 0.5, 0.0) ** 2
    field = np.empty((rows, columns), dtype=np.float32)
    for row in range(rows):
        for column in range(columns):
            nearest = min(cap, squared[height[row, column]])
            nearest = min(nearest, squared[min(column + 1, columns - column)])
            for offset in range(1, columns):
                aside = squared[offset]
                if aside >= nearest:
                    break
                if column >= offset:
                    nearest = min(nearest, aside + squared[height[row, column - offset]])
                if column + offset < columns:
                    nearest = min(nearest, aside + squared[height[row, column + offset]])
            field[row, column] = math.sqrt(nearest)
    return field


@njit(cache=True)
def segment_clearance(blocked: np.ndarray, p: Sequence[float], q: Sequence[float], limit: float,
                      enough: float = 0.0) -> float:
    """Least distance [cells] from the segment p-q to a blocked square or the border, capped at `limit`.

    Parameters
    ----------
    blocked : (rows, columns) bool
        Blocked cells.
    p, q
        Ends (x, y) in cells along the column and row axes; they may coincide.
    limit
        Nothing farther away is looked at [cells].
    enough
        The search ends with the first square nearer than this, and its distance is returned [cells].
    """
    rows, columns = blocked.shape
    nearest = min(limit, p[0], columns - p[0], p[1], rows - p[1], q[0], columns - q[0], q[1], rows - q[1])
    if nearest <= 0.0 or nearest < enough:
        return max(nearest, 0.0)
    low, high = min(p[1], q[1]), max(p[1], q[1])
    first, last = max(int(low - nearest), 0), min(int(high + nearest), rows - 1)
    for row in range(first, last + 1):
        # only the stretch of the segment that comes near this row of cells, widened by what is still of interest
        start, end = _share_between(p[1], q[1], row - nearest, row + 1 + nearest)
        if start > end:
            continue
        x, y = p[0] + (q[0] - p[0]) * start, p[0] + (q[0] - p[0]) * end
        left, right = int(max(min(x, y) - nearest, 0.0)), int(min(max(x, y) + nearest, columns - 1.0))
        for column in range(left, right + 1):
            if blocked[row, column]:
                nearest = min(nearest, segment_square_distance(p, q, column, row))
                if nearest <= 0.0 or nearest < enough:
                    return nearest
    return nearest


@njit(cache=True)
def polyline_clearance(blocked: np.ndarray, points: np.ndarray, limit: float, enough: float = 0.0) -> float:
    """`segment_clearance` of the chain through `points` (N, 2) [cells], N >= 1."""
    nearest = segment_clearance(blocked, points[0], points[0], limit, enough)
    for index in range(len(points) - 1):
        if nearest <= 0.0 or nearest < enough:
            break
        nearest = segment_clearance(blocked, points[index], points[index + 1], nearest, enough)
    return nearest


@njit(cache=True)
def segment_square_distance(p: Sequence[float], q: Sequence[float], left: float, bottom: float) -> float:
    """Distance between the segment p-q and the closed unit square whose lower left corner is given; 0 if they touch."""
    if _meets_square(p, q, left, bottom):
        return 0.0
    nearest = min(_point_square(p[0], p[1], left, bottom), _point_square(q[0], q[1], left, bottom))
    step_x, step_y = q[0] - p[0], q[1] - p[1]
    length = step_x * step_x + step_y * step_y
    for corner in range(4):
        gap_x, gap_y = left + corner % 2 - p[0], bottom + corner // 2 - p[1]
        share = 0.0 if length == 0.0 else min(max((gap_x * step_x + gap_y * step_y) / length, 0.0), 1.0)
        nearest = min(nearest, math.hypot(gap_x - share * step_x, gap_y - share * step_y))
    return nearest


@njit(cache=True)
def _point_square(x: float, y: float, left: float, bottom: float) -> float:
    return math.hypot(max(left - x, 0.0, x - left - 1.0), max(bottom - y, 0.0, y - bottom - 1.0))


@njit(cache=True)
def _meets_square(p: Sequence[float], q: Sequence[float], left: float, bottom: float) -> bool:
    """Whether the shares of the segment within the square's column and within its row have one in common."""
    start_x, end_x = _share_between(p[0], q[0], left, left + 1.0)
    start_y, end_y = _share_between(p[1], q[1], bottom, bottom + 1.0)
    return max(start_x, start_y) <= min(end_x, end_y)


@njit(cache=True)
def _share_between(a: float, b: float, low: float, high: float) -> Tuple[float, float]:
    """The part [start, end] of 0..1 where a + (b - a) * share lies within [low, high]; start > end if none."""
    if max(a, b) < low or min(a, b) > high:
        return 1.0, 0.0
    if a == b:
        return 0.0, 1.0
    one, other = (low - a) / (b - a), (high - a) / (b - a)
    return max(min(one, other), 0.0), min(max(one, other), 1.0)
