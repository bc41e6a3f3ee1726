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

_LONGEST = LINK * (1.0 + 1e-6)  # with rounding [m]
_SAME = 1e-6  # arc lengths this close are one [m]
_STRETCH = 8  # links of r whose neighbourhood on s is searched at once


class Links(NamedTuple):
    """A path cut into links: ends and middles (K, 2) [m], and the arc lengths (K,) [m] at which they start and end."""

    tails: np.ndarray
    heads: np.ndarray
    middles: np.ndarray
    starts: np.ndarray
    ends: np.ndarray


def cut_into_links(path: Polyline, *, border: float = 0.0) -> Links:
    """`path` as links that never straddle a vertex, nor the arc length `border`, with one of length zero at either end.
    """
    vertices = path.arc_lengths
    if np.abs(vertices - border).min() > _SAME and border < path.length:
        vertices = np.insert(vertices, np.searchsorted(vertices, border), border)
    lengths = np.diff(vertices)
    counts = np.maximum(np.ceil(lengths / LINK - 1e-9).astype(int), 1)
    first = np.repeat(vertices[:-1], counts)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    steps = np.repeat(lengths / counts, counts)
    starts = first + within * steps
    arcs = np.concatenate(([0.0], starts, [path.length]))
    ends = np.concatenate((arcs[:1], starts[1:], [path.length, path.length])) if len(starts) else arcs
    tails, heads = path.position(arcs), path.position(ends)
    return Links(tails, heads, 0.5 * (tails + heads), arcs, ends)


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
    runs = close_runs(r.tails, r.heads, r.middles, s.tails, s.heads, s.middles, distance)
    return runs, label_runs(runs)


@njit(cache=True)
def close_runs(r_tails, r_heads, r_middles,  # type: ignore[no-untyped-def]
               s_tails, s_heads, s_middles, distance):
    """The runs of `conflict_regions`.

    Stretch by stretch of r, the links of s are walked in steps as long as their distance allows: neighbouring middles
    are at most a link apart. How far all of s stays away says, in the same way, how many links of r need no look.
    """
    runs = np.empty((64, 3), np.int64)
    count = 0
    near = np.empty(len(s_middles), np.int64)
    surely_not, surely = (distance + _LONGEST) ** 2, max(distance - _LONGEST, 0.0) ** 2
    low = 0
    while low < len(r_middles):
        high = min(low + _STRETCH, len(r_middles))
        found, spare = _near_links(r_middles, low, high, s_middles, distance, near)
        for i in range(low, high if found else low):
            x, y = r_middles[i, 0], r_middles[i, 1]
            for place in range(found):
                j = near[place]
                # How far the middles are apart is mostly enough to tell.
                square = (x - s_middles[j, 0]) ** 2 + (y - s_middles[j, 1]) ** 2
                if square >= surely_not or (square >= surely and squared_gap(
                        r_tails[i], r_heads[i], s_tails[j], s_heads[j]) >= distance * distance):
                    continue
                if count and runs[count - 1, 0] == i and runs[count - 1, 2] == j - 1:
                    runs[count - 1, 2] = j
                    continue
                if count == len(runs):
                    grown = np.empty((2 * count, 3), np.int64)
                    grown[:count] = runs
                    runs = grown
                runs[count, 0], runs[count, 1], runs[count, 2] = i, j, j
                count += 1
        low = high if found else high + max(int(spare / _LONGEST) - _STRETCH // 2 - 1, 0)
    return runs[:count]


@njit(cache=True)
def _near_links(r_middles, low, high, s_middles, distance, near):  # type: ignore[no-untyped-def]
    """Links of s that may conflict with links low..high of r, how many, and else by how much all are too far [m]."""
    centre = (low + high) // 2
    x, y = r_middles[centre, 0], r_middles[centre, 1]
    spread = 0.0
    for i in range(low, high):
        spread = max(spread, (r_middles[i, 0] - x) ** 2 + (r_middles[i, 1] - y) ** 2)
    reach = distance + np.sqrt(spread) + _LONGEST
    found = 0
    spare = np.inf
    j = 0
    while j < len(s_middles):
        beyond = np.sqrt((s_middles[j, 0] - x) ** 2 + (s_middles[j, 1] - y) ** 2) - reach
        if beyond <= 0.0:
            near[found] = j
            found += 1
            j += 1
        else:
            spare = min(spare, 0.5 * beyond)
            j += 1 + int(0.5 * beyond / _LONGEST)
    return found, spare


@njit(cache=True)
def squared_gap(a, b, c, d):  # type: ignore[no-untyped-def]
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
def label_runs(runs):  # type: ignore[no-untyped-def]
    """The region that each run belongs to."""
    count = len(runs)
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
    return labels
