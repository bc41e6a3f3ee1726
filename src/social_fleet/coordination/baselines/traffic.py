"""Motions of robots as straight pieces, sorted into bins so that a search finds those near a place at once."""

from dataclasses import dataclass
from typing import NamedTuple, Sequence, Tuple

import numpy as np
from numba import njit

MARGIN = 1e-6
"""Discs keep this much apart, so that rounding never makes them touch [m]."""

# Columns of `Trajectory.pieces`, and further ones of `Traffic.pieces`.
BEGIN, END, X, Y, VX, VY, NODE, EDGE = range(8)
RADIUS, OWNER, HARD = range(8, 11)
WAIT = -1.0  # in column EDGE: the piece is no move


@dataclass(frozen=True)
class Trajectory:
    """A robot's motion over all time.

    Attributes
    ----------
    pieces : (K, 8) array
        Begin and end [s], position at the begin [m], velocity [m/s], node at the begin, edge or `WAIT`. The first
        piece begins at minus infinity, the last ends at infinity; in both the robot stands.
    radius : float
        Of its disc [m].
    """

    pieces: np.ndarray
    radius: float

    @property
    def arrival(self) -> float:
        """When the robot comes to its goal to stay [s]."""
        return float(self.pieces[-1, BEGIN])


class Traffic(NamedTuple):
    """Pieces of many robots as the search's kernels see them.

    Attributes
    ----------
    pieces : (K, 11) array
        As in `Trajectory`; then radius [m], whose piece it is, and 1 where it must be kept clear of: else a contact is
        only counted.
    first, items : int arrays
        The items of bin b are those from first[b] on, below first[b + 1]. Each names a piece that a move beginning in
        the bin can come near to.
    frame : (3,) array
        Edge of a bin [m], rows and columns of bins.
    """

    pieces: np.ndarray
    first: np.ndarray
    items: np.ndarray
    frame: np.ndarray


def owned(trajectory: Trajectory, owner: int, *, hard: bool) -> np.ndarray:
    """The pieces of a motion as those of `Traffic`."""
    pieces = np.empty((len(trajectory.pieces), 11))
    pieces[:, :RADIUS] = trajectory.pieces
    pieces[:, RADIUS:] = trajectory.radius, owner, hard
    return pieces


def traffic_of(pieces: Sequence[np.ndarray], *, extent: Tuple[float, float], reach: float, radius: float) -> Traffic:
    """Sort pieces into bins.

    Parameters
    ----------
    pieces : sequence of (K, 11) arrays
        See `owned`.
    extent
        Size of the map [m].
    reach : float
        Length of the longest move [m].
    radius : float
        The largest of those who will ask [m].
    """
    joined = np.concatenate([np.empty((0, 11)), *pieces])
    size = 2.0 * reach
    frame = np.array([size, int(extent[1] / size) + 1, int(extent[0] / size) + 1])
    first, items = _binned(joined, joined[:, RADIUS] + radius + reach + MARGIN, frame)
    return Traffic(joined, first, items, frame)


@njit(cache=True, nogil=True)
def bin_of(frame: np.ndarray, x: float, y: float) -> int:
    """The bin that holds (x, y) [m], or the nearest one."""
    column = min(max(int(x / frame[0]), 0), int(frame[2]) - 1)
    row = min(max(int(y / frame[0]), 0), int(frame[1]) - 1)
    return row * int(frame[2]) + column


@njit(cache=True, nogil=True)
def _binned(pieces: np.ndarray, reach: np.ndarray, frame: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """First items and items: a piece is in every bin that its bounding box, widened by its reach, meets."""
    count, columns = len(pieces), int(frame[2])
    low, high = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    load = np.zeros(int(frame[1]) * columns + 1, dtype=np.int64)
    for k in range(count):
        x, y = pieces[k, X], pieces[k, Y]
        end_x, end_y = x, y
        if pieces[k, EDGE] != WAIT:
            span = pieces[k, END] - pieces[k, BEGIN]
            end_x, end_y = x + span * pieces[k, VX], y + span * pieces[k, VY]
        low[k] = bin_of(frame, min(x, end_x) - reach[k], min(y, end_y) - reach[k])
        high[k] = bin_of(frame, max(x, end_x) + reach[k], max(y, end_y) + reach[k])
        for row in range(low[k] // columns, high[k] // columns + 1):
            for column in range(low[k] % columns, high[k] % columns + 1):
                load[row * columns + column + 1] += 1
    first = np.cumsum(load)
    free = first[:-1].copy()
    items = np.empty(first[len(load) - 1], dtype=np.int32)
    for k in range(count):
        for row in range(low[k] // columns, high[k] // columns + 1):
            for column in range(low[k] % columns, high[k] % columns + 1):
                items[free[row * columns + column]] = k
                free[row * columns + column] += 1
    return first, items
