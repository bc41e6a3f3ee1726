"""Where two paths come closer than a distance, as a set in the plane of both arc lengths.

Each path is cut into links of at most `LINK` metres; the ends of the path stand as links of length zero, so that a
robot that waits at its start or stands at its goal is told apart from one that passes there. Two links conflict when
they come closer than the distance, so the set of conflicting pairs covers the true set and exceeds it by less than a
link. Its connected components, both arc lengths taken together, are the encounter windows of 3.3.1.
"""

from typing import NamedTuple, Tuple

import numpy as np
from numba import njit

from social_fleet.geometry import Polyline

LINK = 0.1
"""Longest link [m]: the resolution of encounter windows."""


class Links(NamedTuple):
    """A path cut into links: ends (K, 2) [m], and the arc lengths (K,) [m] at which they start and end."""

    tails: np.ndarray
    heads: np.ndarray
    starts: np.ndarray
    ends: np.ndarray


def cut_into_links(path: Polyline) -> Links:
    """`path` as links that never straddle a vertex, with a link of length zero at either end."""
    lengths = np.diff(path.arc_lengths)
    counts = np.maximum(np.ceil(lengths / LINK - 1e-9).astype(int), 1)
    first = np.repeat(path.arc_lengths[:-1], counts)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    steps = np.repeat(lengths / counts, counts)
    starts = first + within * steps
    arcs = np.concatenate(([0.0], starts, [path.length]))
    ends = np.concatenate((arcs[:1], starts[1:], [path.length, path.length])) if len(starts) else arcs
    return Links(path.position(arcs), path.position(ends), arcs, ends)


def conflict_regions(r: Links, s: Links, distance: float) -> Tuple[np.ndarray, np.ndarray]:
    """The link pairs of two paths that come closer than `distance` [m], in connected regions.

    Returns
    -------
    runs : (M, 3) int array
        Rows (i, first j, last j): link i of r conflicts with links first..last of s; ascending in i, then j.
    labels : (M,) int array
        The connected region of every run, numbered from 0 in order of appearance; links that touch at a corner are
        connected.
    """
    pairs = _close_links(r.tails, r.heads, r.starts, r.ends, s.tails, s.heads, s.starts, s.ends, distance)
    pairs.sort()
    return _label_runs(pairs, len(s.starts))


@njit(cache=True)
def _close_links(r_tails, r_heads, r_starts, r_ends,  # type: ignore[no-untyped-def]
                 s_tails, s_heads, s_starts, s_ends, distance):
    """Keys i * len(s) + j of all links closer than `distance`, by halving both paths.

    Two stretches cannot come close when their middles are farther apart than `distance` and the arc lengths that
    lie between the middles and the stretches' ends.
    """
    found = np.empty(256, np.int64)
    count = 0
    width = len(s_starts)
    stack = [(0, len(r_starts), 0, width)]
    square = distance * distance
    while stack:
        r_low, r_high, s_low, s_high = stack.pop()
        r_middle, s_middle = (r_low + r_high) // 2, (s_low + s_high) // 2
        if r_high - r_low == 1 and s_high - s_low == 1:
            if _squared_gap(r_tails[r_low], r_heads[r_low], s_tails[s_low], s_heads[s_low]) < square:
                if count == len(found):
                    grown = np.empty(2 * count, np.int64)
                    grown[:count] = found
                    found = grown
                found[count] = r_low * width + s_low
                count += 1
            continue
        reach = (distance
                 + max(r_ends[r_high - 1] - r_starts[r_middle], r_starts[r_middle] - r_starts[r_low])
                 + max(s_ends[s_high - 1] - s_starts[s_middle], s_starts[s_middle] - s_starts[s_low]))
        dx = r_tails[r_middle, 0] - s_tails[s_middle, 0]
        dy = r_tails[r_middle, 1] - s_tails[s_middle, 1]
        if dx * dx + dy * dy >= reach * reach:
            continue
        if r_high - r_low >= s_high - s_low:
            stack.append((r_low, r_middle, s_low, s_high))
            stack.append((r_middle, r_high, s_low, s_high))
        else:
            stack.append((r_low, r_high, s_low, s_middle))
            stack.append((r_low, r_high, s_middle, s_high))
    return found[:count]


@njit(cache=True)
def _squared_gap(a, b, c, d):  # type: ignore[no-untyped-def]
    """Squared distance between the segments a-b and c-d (Ericson, Real-Time Collision Detection, 5.1.9)."""
    ux, uy, vx, vy = b[0] - a[0], b[1] - a[1], d[0] - c[0], d[1] - c[1]
    wx, wy = a[0] - c[0], a[1] - c[1]
    uu, vv = ux * ux + uy * uy, vx * vx + vy * vy
    uw, vw = ux * wx + uy * wy, vx * wx + vy * wy
    uv = ux * vx + uy * vy
    along_r = 0.0
    along_s = 0.0
    if uu < 1e-18:
        if vv >= 1e-18:
            along_s = min(max(vw / vv, 0.0), 1.0)
    elif vv < 1e-18:
        along_r = min(max(-uw / uu, 0.0), 1.0)
    else:
        cross = uu * vv - uv * uv
        if cross > 1e-18:
            along_r = min(max((uv * vw - uw * vv) / cross, 0.0), 1.0)
        along_s = (uv * along_r + vw) / vv
        if along_s < 0.0:
            along_s = 0.0
            along_r = min(max(-uw / uu, 0.0), 1.0)
        elif along_s > 1.0:
            along_s = 1.0
            along_r = min(max((uv - uw) / uu, 0.0), 1.0)
    gx = wx + along_r * ux - along_s * vx
    gy = wy + along_r * uy - along_s * vy
    return gx * gx + gy * gy


@njit(cache=True)
def _root(parents, index):  # type: ignore[no-untyped-def]
    while parents[index] != index:
        parents[index] = parents[parents[index]]
        index = parents[index]
    return index


@njit(cache=True)
def _label_runs(pairs, width):  # type: ignore[no-untyped-def]
    """Runs of neighbouring pairs along s, and which region each belongs to."""
    runs = np.empty((len(pairs), 3), np.int64)
    count = 0
    for key in pairs:
        i, j = key // width, key % width
        if count and runs[count - 1, 0] == i and runs[count - 1, 2] == j - 1:
            runs[count - 1, 2] = j
        else:
            runs[count, 0], runs[count, 1], runs[count, 2] = i, j, j
            count += 1
    parents = np.arange(count)
    above = 0
    row_start = 0
    for index in range(count):
        if index and runs[index, 0] != runs[index - 1, 0]:
            above, row_start = row_start, index
        for other in range(above, row_start):
            if (runs[other, 0] == runs[index, 0] - 1 and runs[other, 1] <= runs[index, 2] + 1
                    and runs[index, 1] <= runs[other, 2] + 1):
                parents[_root(parents, index)] = _root(parents, other)
    labels = np.full(count, -1, np.int64)
    names = np.full(count, -1, np.int64)
    next_name = 0
    for index in range(count):
        root = _root(parents, index)
        if names[root] < 0:
            names[root] = next_name
            next_name += 1
        labels[index] = names[root]
    return runs[:count], labels
