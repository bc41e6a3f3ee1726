"""Kernels of string pulling: what a straight chord costs on the lattice, and whether the robot fits along it.

Coordinates are in cells along the grid's column and row axes; costs are in metres.
"""

import math
from typing import NamedTuple, Tuple

import numpy as np
from numba import njit

from social_fleet.mapping.distances import segment_clearance
from social_fleet.planning.lattice import Links, step


class Ground(NamedTuple):
    """Where a robot fits: `radius` in cells, `clearance` in metres, `discs` (D, 3) as x, y, radius in cells."""

    blocked: np.ndarray
    clearance: np.ndarray
    resolution: float
    radius: float
    discs: np.ndarray


class Prices(NamedTuple):
    """What an edge costs: the lattice, the social part, and the nodes (N,) uint8 at which that is waived."""

    links: Links
    social: np.ndarray
    exempt: np.ndarray


@njit(cache=True, nogil=True)
def is_free(ground: Ground, x0: float, y0: float, x1: float, y1: float) -> bool:
    """Whether the robot's disc fits all along the segment."""
    _, _, _, radius, _ = ground
    return is_free_for(ground, radius, x0, y0, x1, y1)


def fits_along(ground: Ground, x0: float, y0: float, x1: float, y1: float) -> bool:
    """`is_free` for those who are no kernels: Numba is slow to recognise tuples of arrays."""
    return bool(_fits_along(x0, y0, x1, y1, *ground))


@njit(cache=True, nogil=True)
def _fits_along(x0: float, y0: float, x1: float, y1: float, blocked: np.ndarray, clearance: np.ndarray,
                resolution: float, radius: float, discs: np.ndarray) -> bool:
    return is_free_for((blocked, clearance, resolution, radius, discs), radius, x0, y0, x1, y1)


@njit(cache=True, nogil=True)
def is_free_for(ground: Ground, radius: float, x0: float, y0: float, x1: float, y1: float) -> bool:
    """Whether a disc of `radius` [cells] fits all along the segment."""
    blocked, clearance, resolution, _, discs = ground
    length = math.hypot(x1 - x0, y1 - y0)
    for d in range(len(discs)):
        if _distance(discs[d, 0], discs[d, 1], x0, y0, x1, y1) < discs[d, 2]:
            return False
    if length < 1e-12:
        return segment_clearance(blocked, (x0, y0), (x1, y1), radius, radius) >= radius
    dx, dy = (x1 - x0) / length, (y1 - y0) / length
    rows, cols = blocked.shape
    along = 0.0
    while along < length:
        x, y = x0 + along * dx, y0 + along * dy
        r, c = int(math.floor(y)), int(math.floor(x))
        if r < 0 or c < 0 or r >= rows or c >= cols:
            return False
        room = clearance[r, c] / resolution - radius - math.hypot(x - c - 0.5, y - r - 0.5) - 1e-6
        if room > 0.5:
            along += room
            continue
        ahead = min(along + 4.0, length)
        there = (x0 + ahead * dx, y0 + ahead * dy)
        if segment_clearance(blocked, (x, y), there, radius, radius) < radius:
            return False
        along = ahead
    return True


@njit(cache=True, nogil=True)
def _has_room(clearance: np.ndarray, least: float, x0: float, y0: float, x1: float, y1: float) -> bool:
    """Whether the clearance is at least `least` [m] at places every few cells along the segment; a quick look."""
    pieces = int(max(abs(x1 - x0), abs(y1 - y0)) / 4.0) + 1
    for p in range(1, pieces):
        share = p / pieces
        if clearance[int(y0 + share * (y1 - y0)), int(x0 + share * (x1 - x0))] < least:
            return False
    return True


@njit(cache=True, nogil=True)
def _distance(px: float, py: float, x0: float, y0: float, x1: float, y1: float) -> float:
    """Distance of a point from a segment."""
    dx, dy = x1 - x0, y1 - y0
    square = dx * dx + dy * dy
    share = 0.0
    if square > 0.0:
        share = min(max(((px - x0) * dx + (py - y0) * dy) / square, 0.0), 1.0)
    return math.hypot(px - x0 - share * dx, py - y0 - share * dy)


@njit(cache=True, nogil=True)
def chain_cost(prices: Prices, node: int, goal: int, budget: float) -> Tuple[float, float]:
    """Length and social cost of the digital line between two nodes; infinite where it breaks or passes `budget`."""
    (row, col, up, down, edges, lengths), social_of, exempt = prices
    drow, dcol = row[goal] - row[node], col[goal] - col[node]
    steps, minor = max(abs(drow), abs(dcol)), min(abs(drow), abs(dcol))
    straight, diagonal = _line_headings(drow, dcol)
    length, social = 0.0, 0.0
    error = steps // 2
    for _ in range(steps):
        error -= minor
        heading = straight
        if error < 0:
            heading = diagonal
            error += steps
        if not edges[node] >> heading & 1:
            return np.inf, np.inf
        other = step(up, down, node, heading)
        length += lengths[heading]
        if not (exempt[node] or exempt[other]):
            social += social_of[node, heading]
        if length + social > budget:
            return np.inf, np.inf
        node = other
    return length, social


@njit(cache=True, nogil=True)
def _line_headings(drow: int, dcol: int) -> Tuple[int, int]:
    """The straight and the diagonal heading of which a digital line is made."""
    diagonal = (1 if dcol > 0 else 3) if drow > 0 else (7 if dcol > 0 else 5)
    if abs(dcol) >= abs(drow):
        return (0 if dcol > 0 else 4), diagonal
    return (2 if drow > 0 else 6), diagonal


@njit(cache=True, nogil=True)
def chord(ground: Ground, radius: float, prices: Prices, points: np.ndarray, nodes: np.ndarray, paid: np.ndarray,
          i: int, j: int, slack: float, limit: float) -> float:
    """Cost of the straight chord between two points of a path, infinite where it may not replace what lies between.

    A disc of `radius` [cells] has to fit along it. `paid` is the cost of the path up to each point. The chord may be
    dearer than what it replaces by `slack` [m], by three times as much at the path's first and last point; a negative
    `slack` asks for length alone. Infinite too where the cost reaches `limit`.
    """
    _, clearance, resolution, _, _ = ground
    x0, y0, x1, y1 = points[i, 0], points[i, 1], points[j, 0], points[j, 1]
    length = math.hypot(x1 - x0, y1 - y0) * resolution
    cost = length
    if cost >= limit or not _has_room(clearance, (radius - 1.0) * resolution, x0, y0, x1, y1):
        return np.inf
    if slack >= 0.0:
        share = 3.0 if i == 0 or j == len(points) - 1 else 1.0
        # A cell's width of slack lets a short staircase become a line.
        budget = paid[j] - paid[i] + share * slack + resolution
        # The digital line is longer than the chord by 8.3 % at most.
        steps, social = chain_cost(prices, nodes[i], nodes[j], min(budget, 1.083 * limit))
        if not steps < np.inf:
            return np.inf
        cost += social * (length / steps if steps > 0.0 else 1.0)
    if cost >= limit or not is_free_for(ground, radius, x0, y0, x1, y1):
        return np.inf
    return cost


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
                gap = _distance(points[m, 0], points[m, 1], points[i, 0], points[i, 1], points[j, 0], points[j, 1])
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
