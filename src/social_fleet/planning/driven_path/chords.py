"""Kernels for straight chords: what one costs on the lattice, and whether the robot fits along it.

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
        if distance(discs[d, 0], discs[d, 1], x0, y0, x1, y1) < discs[d, 2]:
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
def distance(px: float, py: float, x0: float, y0: float, x1: float, y1: float) -> float:
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
