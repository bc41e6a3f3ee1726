"""Distance to the nearest wall in each of the eight directions in which a grid path can go."""

import math

import numpy as np
from numba import njit

# (column step, row step) of heading k, which points k * 45 degrees counter-clockwise from the +column axis
HEADINGS = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)], dtype=np.int64)
HEADINGS.setflags(write=False)


def wall_distances(blocked: np.ndarray, resolution: float, *, limit: float) -> np.ndarray:
    """Distance from every cell's centre to where a ray in each heading meets a wall.

    The ray ends at the face (or corner) by which it enters a blocked cell, at the map's border, and at a corner
    where two blocked cells touch: it does not slip through a diagonal wall of one cell's thickness.

    Parameters
    ----------
    blocked : (rows, columns) bool
        Where walls are.
    resolution
        Edge length of a cell [m].
    limit
        Distances are capped at this [m], which may be infinite.

    Returns
    -------
    (8, rows, columns) float32
        [m], 0 in blocked cells; the first index is that of `HEADINGS`, in grid axes.
    """
    blocked = np.ascontiguousarray(blocked, dtype=np.bool_)
    distances = np.empty((len(HEADINGS),) + blocked.shape, dtype=np.float32)
    for heading, (column_step, row_step) in enumerate(HEADINGS):
        stride = resolution * math.hypot(column_step, row_step)
        # by step count, so that no error adds up along a ray
        longest = max(blocked.shape)
        table = np.minimum((np.arange(longest + 1) - 0.5) * stride, limit).astype(np.float32)
        table[0] = 0.0
        if row_step == 0:
            _rays_along_rows(blocked, column_step, table, distances[heading])
        else:
            _rays_across_rows(blocked, column_step, row_step, table, distances[heading])
    return distances


@njit(cache=True)
def _rays_along_rows(blocked: np.ndarray, column_step: int, table: np.ndarray, distances: np.ndarray) -> None:
    rows, columns = blocked.shape
    for row in range(rows):
        steps = 0
        for index in range(columns):
            column = columns - 1 - index if column_step > 0 else index
            steps = 0 if blocked[row, column] else steps + 1
            distances[row, column] = table[steps]


@njit(cache=True)
def _rays_across_rows(blocked: np.ndarray, column_step: int, row_step: int, table: np.ndarray,
                      distances: np.ndarray) -> None:
    """Rows in the order in which a ray comes home: a cell is one step farther than the cell the ray goes to."""
    rows, columns = blocked.shape
    ahead = np.zeros(columns + 2, dtype=np.int32)  # steps from the row ahead; the border's two are 0 as a wall's
    here = np.zeros(columns + 2, dtype=np.int32)
    for index in range(rows):
        row = rows - 1 - index if row_step > 0 else index
        for column in range(columns):
            if blocked[row, column]:
                steps = 0
            elif column_step == 0:
                steps = ahead[column + 1] + 1
            else:
                beside = column + column_step
                pinched = (0 <= beside < columns and blocked[row, beside]) and ahead[column + 1] == 0
                steps = 1 if pinched else ahead[beside + 1] + 1
            here[column + 1] = steps
            distances[row, column] = table[steps]
        ahead, here = here, ahead
