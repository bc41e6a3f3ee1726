"""From conflicting links to encounter windows: extents, kinds, and the rows of both orders.

For an order, the second robot's links in a window are walked in ascending order; `clear` is the farthest that the
first has to be past by then. A row is kept as long as `clear` rises by no more than `_STAIR`: see doc/coordination.md.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from social_fleet.coordination.conflict_regions import LINK, Links, close_runs, label_runs

SHORT = 2.0
"""A window whose arcs are both shorter than this is an intersection [m]."""

_STAIR = 0.5  # see `window_rows` [m]
_SETBACK = 1.0  # by which a window that runs along, or against, the other path may depart from that [m]


class WindowRows(NamedTuple):
    """The N windows of two paths.

    Attributes
    ----------
    extents : (N, 4) array
        Where either path enters and leaves [m]: r from, r to, s from, s to.
    ends : (N, 4) bool array
        Whether r's start, r's goal, s's start, s's goal lie in the other's way.
    kinds : (N,) int array
        Positions in `schedule.KINDS`.
    starts : (2 N + 1,) int array
        Rows starts[2 n]..starts[2 n + 1] belong to window n with r first, the next ones to it with s first.
    at, clear : (M,) arrays
        The second robot may not pass `at` [m] before the first has passed `clear` [m].
    """

    extents: np.ndarray
    ends: np.ndarray
    kinds: np.ndarray
    starts: np.ndarray
    at: np.ndarray
    clear: np.ndarray


def window_rows(r: Links, s: Links, distance: float, *, stair: float = _STAIR) -> WindowRows:
    """The windows of two paths, where links come closer than `distance` [m].

    Parameters
    ----------
    stair : float
        How far the first robot's mark may run ahead of what is needed, to save rows [m].
    """
    return WindowRows(*_windows(r.tails, r.heads, r.middles, r.starts, r.ends,
                                s.tails, s.heads, s.middles, s.starts, s.ends, distance, stair))


@njit(cache=True)
def _windows(r_tails, r_heads, r_middles, r_starts, r_ends,  # type: ignore[no-untyped-def]
             s_tails, s_heads, s_middles, s_starts, s_ends, distance, stair):
    runs = close_runs(r_tails, r_heads, r_middles, s_tails, s_heads, s_middles, distance)
    labels = label_runs(runs)
    count = labels.max() + 1 if len(labels) else 0
    extents = np.empty((count, 4))
    ends = np.empty((count, 4), np.bool_)
    kinds = np.empty(count, np.int64)
    starts = np.zeros(2 * count + 1, np.int64)
    at = np.empty(2 * len(runs))
    clear = np.empty(2 * len(runs))
    rows = 0
    for window in range(count):
        mine = runs[labels == window]
        last_row, first, last = len(mine) - 1, mine[:, 1].min(), mine[:, 2].max()
        extents[window, 0], extents[window, 1] = r_starts[mine[0, 0]], r_ends[mine[last_row, 0]]
        extents[window, 2], extents[window, 3] = s_starts[first], s_ends[last]
        ends[window, 0], ends[window, 1] = mine[0, 0] == 0, mine[last_row, 0] == len(r_starts) - 1
        ends[window, 2], ends[window, 3] = first == 0, last == len(s_starts) - 1
        kinds[window] = _kind(mine, extents[window])
        by_first = np.argsort(mine[:, 1], kind="mergesort")
        rows = _stairs(s_starts, mine[:, 1], r_ends, mine[:, 0], by_first, at, clear, rows, stair)
        starts[2 * window + 1] = rows
        rows = _stairs(r_starts, mine[:, 0], s_ends, mine[:, 2], np.arange(len(mine)), at, clear, rows, stair)
        starts[2 * window + 2] = rows
    return extents, ends, kinds, starts, at[:rows], clear[:rows]


@njit(cache=True)
def _stairs(entries, follower_links, exits,  # type: ignore[no-untyped-def]
            leader_links, order, at, clear, rows, stair):
    """Add the rows of one order; `entries` and `exits` are the arc lengths of links' starts and ends [m]."""
    begin = rows
    low = 0.0
    passed = -np.inf
    for index in order:
        entry = entries[follower_links[index]]
        passed = max(passed, exits[leader_links[index]])
        if rows == begin or (entry > at[rows - 1] and passed - low > stair):
            at[rows] = entry
            low = passed
            rows += 1
        clear[rows - 1] = passed
    return rows


@njit(cache=True)
def _kind(runs, extent):  # type: ignore[no-untyped-def]
    """3.3.1's kind; what is neither short nor monotone is read as an intersection, one robot at a time."""
    r_length, s_length = extent[1] - extent[0], extent[3] - extent[2]
    if max(r_length, s_length) < SHORT or min(r_length, s_length) <= 0.0:
        return 0
    highest = np.full(2, -(1 << 40))  # so far, of the first and last links of a row, ...
    lowest = np.full(2, 1 << 40)
    rises, falls = True, True
    index = 0
    while index < len(runs):
        row, first, last = runs[index, 0], runs[index, 1], runs[index, 2]
        while index < len(runs) and runs[index, 0] == row:
            first, last = min(first, runs[index, 1]), max(last, runs[index, 2])
            index += 1
        for side, link in ((0, first), (1, last)):
            highest[side], lowest[side] = max(highest[side], link), min(lowest[side], link)
            rises &= highest[side] - link <= _SETBACK / LINK
            falls &= link - lowest[side] <= _SETBACK / LINK
    return 2 if rises else (1 if falls else 0)
