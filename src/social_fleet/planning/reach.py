"""What a robot can reach with obstacles about, and the place nearest to a goal that is blocked or cut off."""

import math
from typing import Optional, Sequence, Tuple

import numpy as np
from numba import njit

from social_fleet.errors import InvalidParameter
from social_fleet.planning.driven_path.chords import Ground, fits_along
from social_fleet.planning.ends import reachable
from social_fleet.planning.lattice import Lattice, Links, neighbour

_STEP_ASIDE = 2.5  # [cells] from the lattice towards the goal; within what `reachable` bridges
_HALVINGS = 14


def check_tolerance(tolerance: float) -> None:
    """Raise InvalidParameter unless `tolerance` [m] is a finite number from 0 on."""
    if not (math.isfinite(tolerance) and tolerance >= 0.0):
        raise InvalidParameter(f"must be zero or more metres, not {tolerance}", field="tolerance")


def joined_clear(lattice: Lattice, ground: Ground, ends: Sequence[np.ndarray],
                 closed: np.ndarray) -> Optional[Tuple[int, int]]:
    """Nodes where a path may leave the start and reach the goal without entering `closed`; None: there is no path.

    As `joined`, which is quicker and does not know what `closed` cuts off.
    """
    starts, goals = (reachable(lattice, ground, end, closed, all_near=True) for end in ends)
    known = np.zeros(len(lattice), dtype=bool)
    for start in starts:
        if known[start]:
            continue
        reached = reached_from(lattice.links, np.array([start]), closed)
        for goal in goals:
            if reached[goal]:
                return start, goal
        known |= reached
    return None


def nearest_reachable(lattice: Lattice, ground: Ground, start: np.ndarray, goal: np.ndarray, closed: np.ndarray,
                      tolerance: float) -> Optional[np.ndarray]:
    """The place (x, y) within `tolerance` of the goal that is nearest to it among those that a path can end at.

    Parameters
    ----------
    lattice : Lattice
        What is searched.
    ground : Ground
        Where the robot fits at the ends of a path, without margin.
    start, goal : (2,) array
        In cells along the grid's axes; the goal may lie anywhere, off the map too.
    closed : (M,) int array
        Nodes that the path must not enter.
    tolerance : float
        [cells]
    """
    nodes = _nodes_about(lattice, goal, tolerance + _STEP_ASIDE)
    seeds = np.array(reachable(lattice, ground, start, closed, all_near=True), dtype=np.int64)
    if not len(nodes) or not len(seeds):
        return None
    nodes = nodes[reached_from(lattice.links, seeds, closed)[nodes]]
    centres = lattice.centres(nodes)
    gaps = np.hypot(*(centres - goal).T)
    best: Tuple[float, Optional[np.ndarray]] = (tolerance + 1e-9, None)
    for index in np.argsort(gaps, kind="stable"):
        if gaps[index] - _STEP_ASIDE > best[0]:
            break
        place = _towards(ground, centres[index], goal)
        gap = float(np.hypot(*(place - goal)))
        if gap <= best[0] - 1e-9:
            best = gap, place
    return best[1]


def nearest_departure(lattice: Lattice, blocked: np.ndarray, start: np.ndarray, closed: np.ndarray,
                      tolerance: float) -> Optional[np.ndarray]:
    """The node's centre (x, y) within `tolerance` of a start where no robot fits that is nearest to it.

    Parameters
    ----------
    lattice : Lattice
        Where paths lead.
    blocked : (rows, columns) bool array
        The straight line from the start crosses none of these cells.
    start : (2,) array
        In cells along the grid's axes.
    closed : (M,) int array
        Nodes that a path must not enter.
    tolerance : float
        [cells]
    """
    nodes = np.setdiff1d(_nodes_about(lattice, start, tolerance), closed)
    centres = lattice.centres(nodes)
    for index in np.argsort(np.hypot(*(centres - start).T), kind="stable"):
        if not blocked[_cells_between(start, centres[index])].any():
            return centres[index]
    return None


def _cells_between(start: np.ndarray, end: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Rows and columns of the cells under a straight line, sampled ten times a cell."""
    steps = np.linspace(0.0, 1.0, 2 + int(10.0 * np.hypot(*(end - start))))[:, None]
    cells = np.floor(start + steps * (end - start)).astype(int)
    return cells[:, 1], cells[:, 0]


def _nodes_about(lattice: Lattice, place: np.ndarray, reach: float) -> np.ndarray:
    """Nodes whose centres are within `reach` [cells] of `place`."""
    rows, columns = lattice.node.shape
    low_row, high_row = (int(np.clip(place[1] + side * (reach + 1.0), 0, rows)) for side in (-1, 1))
    low_column, high_column = (int(np.clip(place[0] + side * (reach + 1.0), 0, columns)) for side in (-1, 1))
    window = lattice.node[low_row:high_row, low_column:high_column]
    nodes = window[window >= 0]
    return nodes[np.hypot(*(lattice.centres(nodes) - place).T) <= reach]


def _towards(ground: Ground, place: np.ndarray, goal: np.ndarray) -> np.ndarray:
    """How far the robot can go on from `place` straight towards the goal, up to a step aside."""
    gap = float(np.hypot(*(goal - place)))
    if gap <= 0.0:
        return place
    ahead = (goal - place) * min(1.0, _STEP_ASIDE / gap)
    if fits_along(ground, place[0], place[1], place[0] + ahead[0], place[1] + ahead[1]):
        return place + ahead
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if fits_along(ground, place[0], place[1], place[0] + middle * ahead[0], place[1] + middle * ahead[1]):
            low = middle
        else:
            high = middle
    return place + low * ahead


@njit(cache=True)
def reached_from(links: Links, seeds: np.ndarray, closed: np.ndarray) -> np.ndarray:
    """Which nodes a path from one of `seeds` reaches without entering `closed`: (N,) bool."""
    reached = np.zeros(len(links.row), dtype=np.bool_)
    barred = np.zeros(len(links.row), dtype=np.bool_)
    for n in closed:
        barred[n] = True
    stack = np.empty(len(links.row), dtype=np.int32)
    top = 0
    for n in seeds:
        if not barred[n] and not reached[n]:
            reached[n] = True
            stack[top] = n
            top += 1
    while top > 0:
        top -= 1
        n = np.int64(stack[top])
        for k in range(8):
            if links.edges[n] >> k & 1:
                m = neighbour(links, n, k)
                if not reached[m] and not barred[m]:
                    reached[m] = True
                    stack[top] = m
                    top += 1
    return reached
