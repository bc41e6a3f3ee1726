"""Kernels of string pulling: which chords replace the searched path.

Coordinates are in cells along the grid's column and row axes; costs are in metres.
"""

import math

import numpy as np
from numba import njit

from social_fleet.planning.driven_path.chords import Ground, Prices, chord, distance


@njit(cache=True, nogil=True)
def turn_at(points: np.ndarray, i: int, j: int, k: int) -> float:
    """Heading change [rad] between the chords i-j and j-k of `points`, without sign; 0 where there is no chord i-j."""
    if i < 0:
        return 0.0
    ux, uy = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
    vx, vy = points[k, 0] - points[j, 0], points[k, 1] - points[j, 1]
    return abs(math.atan2(ux * vy - uy * vx, ux * vx + uy * vy))


@njit(cache=True, nogil=True)
def pull(ground: Ground, prices: Prices, points: np.ndarray, nodes: np.ndarray, paid: np.ndarray,
         candidates: np.ndarray, slack: float, vertex_cost: float, turn_cost: float, reach: float, patience: int,
         narrow: float, narrow_reach: float) -> np.ndarray:
    """A cheap and calm chain of chords over `candidates` (indices into `points`, first and last included).

    Every chord costs `vertex_cost` [m] and `turn_cost` [m/rad] of its turn beside its own cost. It spans at most
    `reach` [m], and the search from one candidate gives up after `patience` failures in a row. Along chords of up to
    `narrow_reach` [m] a disc of the radius `narrow` [cells] has to fit only. Where no chord fits, the path's own points
    stay.
    """
    _, _, resolution, radius, _ = ground
    count = len(candidates)
    straight = _straight_until(points)
    best = np.full(count, np.inf)
    origin = np.full(count, -1, dtype=np.int64)
    before = np.full(count, -1, dtype=np.int64)  # the point before each candidate on the best chain to it
    best[0] = 0.0
    # The chain from candidate to candidate first: what is dearer than it need not be looked at to the end.
    for a in range(count - 1):
        i, j = candidates[a], candidates[a + 1]
        best[a + 1] = best[a] + paid[j] - paid[i] + (vertex_cost + turn_cost) * (j - i)
        before[a + 1] = j - 1
        base = best[a] + vertex_cost + turn_cost * turn_at(points, before[a], i, j)
        cost = paid[j] - paid[i]
        if j > straight[i]:
            span = math.hypot(points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]) * resolution
            fitting = narrow if span <= narrow_reach else radius
            cost = chord(ground, fitting, prices, points, nodes, paid, i, j, slack, best[a + 1] - base)
        if base + cost < best[a + 1]:
            best[a + 1], origin[a + 1], before[a + 1] = base + cost, a, i
    for a in range(count - 1):
        i = candidates[a]
        failures = 0
        for b in range(a + 1, count):
            j = candidates[b]
            span = math.hypot(points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]) * resolution
            if b > a + 1 and span > reach:
                break
            base = best[a] + vertex_cost + turn_cost * turn_at(points, before[a], i, j)
            # Even a straight line cannot improve on what is known.
            if base + span >= best[b]:
                continue
            if j <= straight[i]:
                cost = base + paid[j] - paid[i]
            else:
                fitting = narrow if span <= narrow_reach else radius
                cost = base + chord(ground, fitting, prices, points, nodes, paid, i, j, slack, best[b] - base)
            if not cost < best[b]:
                failures += 1
                if failures >= patience:
                    break
                continue
            failures = 0
            best[b], origin[b], before[b] = cost, a, i
    return _unwind(candidates, origin)


@njit(cache=True, nogil=True)
def _straight_until(points: np.ndarray) -> np.ndarray:
    """For every point the last one that the path reaches from it without any turn."""
    count = len(points)
    until = np.empty(count, dtype=np.int64)
    until[count - 1] = count - 1
    for i in range(count - 2, -1, -1):
        until[i] = i + 1
        if i + 2 < count:
            ux, uy = points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1]
            vx, vy = points[i + 2, 0] - points[i + 1, 0], points[i + 2, 1] - points[i + 1, 1]
            if abs(ux - vx) < 1e-9 and abs(uy - vy) < 1e-9:
                until[i] = until[i + 1]
    return until


@njit(cache=True, nogil=True)
def _unwind(candidates: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """The chosen indices in order; -1 as origin stands for the path's own points since the candidate before."""
    chosen = np.empty(candidates[-1] + 1, dtype=np.int64)
    top = 0
    b = len(candidates) - 1
    while b > 0:
        chosen[top] = candidates[b]
        top += 1
        if origin[b] >= 0:
            b = origin[b]
            continue
        for index in range(candidates[b] - 1, candidates[b - 1], -1):
            chosen[top] = index
            top += 1
        b -= 1
    chosen[top] = candidates[0]
    return chosen[:top + 1][::-1].copy()


@njit(cache=True, nogil=True)
def drop_needless(ground: Ground, prices: Prices, points: np.ndarray, nodes: np.ndarray, paid: np.ndarray,
                  chosen: np.ndarray, slack: float, vertex_cost: float, turn_cost: float) -> np.ndarray:
    """`chosen` without the vertices that are dearer than a longer chord without them."""
    _, _, _, radius, _ = ground
    kept = chosen.copy()
    count = len(kept)
    unbounded = np.inf if slack >= 0.0 else slack
    sides = np.empty(count)  # cost of the side that ends at each vertex
    for v in range(1, count):
        sides[v] = chord(ground, radius, prices, points, nodes, paid, kept[v - 1], kept[v], unbounded, np.inf)
    v = 1
    while v < count - 1:
        i, k = kept[v - 1], kept[v + 1]
        saved = sides[v] + sides[v + 1] + vertex_cost + turn_cost * _turn_change(points, kept, v, count)
        without = chord(ground, radius, prices, points, nodes, paid, i, k, slack, saved)
        if without < np.inf:
            kept[v:count - 1] = kept[v + 1:count].copy()
            sides[v:count - 1] = sides[v + 1:count].copy()
            sides[v] = without
            count -= 1
            v = max(v - 1, 1)
        else:
            v += 1
    return kept[:count].copy()


@njit(cache=True, nogil=True)
def _turn_change(points: np.ndarray, kept: np.ndarray, v: int, count: int) -> float:
    """By how much the path turns less [rad] without its vertex v, with both neighbours' turns."""
    i, j, k = kept[v - 1], kept[v], kept[v + 1]
    change = turn_at(points, i, j, k)
    if v >= 2:
        change += turn_at(points, kept[v - 2], i, j) - turn_at(points, kept[v - 2], i, k)
    if v + 2 < count:
        change += turn_at(points, j, k, kept[v + 2]) - turn_at(points, i, k, kept[v + 2])
    return change


@njit(cache=True, nogil=True)
def candidates_of(ground: Ground, prices: Prices, points: np.ndarray, nodes: np.ndarray, paid: np.ndarray,
                  tolerance: float, spacing: float, slack: float) -> np.ndarray:
    """Indices where a path (in cells) turns by more than `tolerance` or a chord would not fit, and others in between.

    These lie `spacing` and its doubles from either end of a straight piece: lanes are joined and left near its ends.
    """
    _, _, _, radius, _ = ground
    count = len(points)
    straight = _straight_until(points)
    keep = np.zeros(count, dtype=np.bool_)
    keep[0] = keep[count - 1] = True
    stack = np.empty((count + 1, 2), dtype=np.int64)
    stack[0, 0], stack[0, 1] = 0, count - 1
    top = 1
    while top > 0:
        top -= 1
        i, j = stack[top, 0], stack[top, 1]
        if j <= i + 1:
            continue
        farthest, where = -1.0, -1
        if j > straight[i]:
            for m in range(i + 1, j):
                gap = distance(points[m, 0], points[m, 1], points[i, 0], points[i, 1], points[j, 0], points[j, 1])
                if gap > farthest:
                    farthest, where = gap, m
        fits = (j <= straight[i] or farthest <= tolerance
                and chord(ground, radius, prices, points, nodes, paid, i, j, slack, np.inf) < np.inf)
        if not fits:
            keep[where] = True
            stack[top, 0], stack[top, 1] = i, where
            stack[top + 1, 0], stack[top + 1, 1] = where, j
            top += 2
            continue
        span = math.hypot(points[j, 0] - points[i, 0], points[j, 1] - points[i, 1])
        step = spacing
        while 2.0 * step <= span:
            offset = int(round((j - i) * step / span))
            keep[i + offset] = keep[j - offset] = True
            step *= 2.0
    return np.flatnonzero(keep)
