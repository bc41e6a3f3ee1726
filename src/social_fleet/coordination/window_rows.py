"""From conflicting links to encounter windows: extents, kinds, and the rows of both orders.

For an order, the second robot's links in a window are walked in ascending order; `clear` is the farthest that the
first has to be past by then. A row is kept as long as `clear` rises by no more than `STAIR`: see doc/coordination.md.
"""

from typing import NamedTuple, Optional, Sequence, Tuple

import numpy as np
from numba import njit

from social_fleet.coordination.conflict_regions import LINK, Links, close_runs, label_runs, squared_gap

SHORT = 2.0
"""A window whose arcs are both shorter than this is an intersection [m]."""

STAIR = 0.5
"""How far the first robot's mark may run ahead of what is needed, to save rows [m]."""

_TINY = 1e-6  # [m]
_NEAR = 0.3  # how far beyond what two robots are committed to they may be closer than the distance, ... [m]
_SLACK = 0.05  # ... and by how much: robots stand a little short of where they wait [m]
_NEARER = 0.02  # two that are closer than that already may come so much closer yet [m]
_SETBACK = 1.0  # by which a window that runs along, or against, the other path may depart from that [m]


class WindowRows(NamedTuple):
    """The N windows of two paths.

    Attributes
    ----------
    extents : (N, 4) array
        Where either path enters and leaves [m]: r from, r to, s from, s to.
    ends : (N, 4) bool array
        Whether r's start, r's goal, s's start, s's goal lie in the other's way; for robots under way, whether any place
        does that they are committed to.
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


def window_rows(r: Links, s: Links, distance: float, *, stops: Tuple[Sequence[float], Sequence[float]] = ((), ()),
                committed: Optional[Tuple[float, float]] = None, least: float = 0.0) -> WindowRows:
    """The windows of two paths: where links come closer than `distance` [m].

    Parameters
    ----------
    stops : pair of sequences of float
        Where either robot may stand for as long as others need [m]: before one that goes second has left such a place,
        nothing is asked of the first that it would only need beyond.
    committed : (float, float), optional
        The arc lengths that two robots under way are committed to [m], borders of links: what both reach within these
        is settled, and no part of any window. Where they are closer than the distance now, they need not keep it before
        they have got away from each other, only what they have.
    least : float
        What they keep even then [m].
    """
    r_upto, s_upto = committed or (0.0, 0.0)
    return WindowRows(*_windows(r.tails, r.heads, r.middles, r.starts, r.ends,
                                s.tails, s.heads, s.middles, s.starts, s.ends, distance,
                                np.array(stops[0], dtype=float), np.array(stops[1], dtype=float),
                                r_upto, s_upto, least if committed is not None else np.inf))


@njit(cache=True)
def _windows(r_tails, r_heads, r_middles, r_starts, r_ends,  # type: ignore[no-untyped-def]
             s_tails, s_heads, s_middles, s_starts, s_ends, distance, r_stops, s_stops, r_upto, s_upto, least):
    runs = close_runs(r_tails, r_heads, r_middles, s_tails, s_heads, s_middles, distance)
    r_own, s_own = max(np.sum(r_ends <= r_upto + _TINY), 1), max(np.sum(s_ends <= s_upto + _TINY), 1)
    if least < np.inf:
        present = np.sqrt((r_tails[0, 0] - s_tails[0, 0]) ** 2 + (r_tails[0, 1] - s_tails[0, 1]) ** 2)
        close = max(min(distance - _SLACK, present - _NEARER), least)
        near = _NEAR + 2.0 * (distance - _SLACK - close)
        runs = _unsettled(runs, r_own, s_own, np.sum(r_starts <= r_upto + near), np.sum(s_starts <= s_upto + near),
                          r_tails, r_heads, s_tails, s_heads, close)
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
        ends[window, 0], ends[window, 1] = mine[0, 0] < r_own, mine[last_row, 0] == len(r_starts) - 1
        ends[window, 2], ends[window, 3] = first < s_own, last == len(s_starts) - 1
        kinds[window] = _kind(mine, extents[window])
        by_first = np.argsort(mine[:, 1], kind="mergesort")
        rows = _stairs(s_starts, mine[:, 1], r_ends, mine[:, 0], by_first, s_stops, at, clear, rows)
        starts[2 * window + 1] = rows
        rows = _stairs(r_starts, mine[:, 0], s_ends, mine[:, 2], np.arange(len(mine)), r_stops, at, clear, rows)
        starts[2 * window + 2] = rows
    return extents, ends, kinds, starts, at[:rows], clear[:rows]


@njit(cache=True)
def _unsettled(runs, r_own, s_own, r_near, s_near,  # type: ignore[no-untyped-def]
               r_tails, r_heads, s_tails, s_heads, close):
    """The runs without what two robots under way are committed to, nor what is not really `close` [m] beside that."""
    rest = np.empty((len(runs) + r_near * s_near, 3), np.int64)
    count = 0
    for index in range(len(runs)):
        i, last = runs[index, 0], runs[index, 2]
        begun = False
        for j in range(runs[index, 1], last + 1):
            if i >= r_near or j >= s_near:
                if not begun:
                    rest[count, 0], rest[count, 1] = i, j
                    count += 1
                rest[count - 1, 2] = last
                break
            if (i < r_own and j < s_own) or squared_gap(r_tails[i], r_heads[i], s_tails[j],
                                                        s_heads[j]) >= close * close:
                begun = False
                continue
            if not begun:
                rest[count, 0], rest[count, 1] = i, j
                count += 1
                begun = True
            rest[count - 1, 2] = j
    return rest[:count]


@njit(cache=True)
def _stairs(entries, follower_links, exits,  # type: ignore[no-untyped-def]
            leader_links, order, stops, at, clear, rows):
    """Add the rows of one order; `entries` and `exits` are the arc lengths of links' starts and ends [m]."""
    begin = rows
    low = 0.0
    passed = -np.inf
    for index in order:
        entry = entries[follower_links[index]]
        passed = max(passed, exits[leader_links[index]])
        if rows == begin or (entry > at[rows - 1] and (passed - low > STAIR or _holds(stops, at[rows - 1], entry))):
            at[rows] = entry
            low = passed
            rows += 1
        clear[rows - 1] = passed
    return rows


@njit(cache=True)
def _holds(stops, low, high):  # type: ignore[no-untyped-def]
    """Whether a stop lies beyond `low`, up to `high` [m]."""
    for stop in stops:
        if low < stop - _TINY and stop <= high + _TINY:
            return True
    return False


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
