"""Social cost of every edge, computed once per map, norm and radius."""

import math

import numpy as np
from numba import njit

from social_fleet.mapping.walls import HEADINGS, wall_distances
from social_fleet.planning.lattice import SQRT2, Lattice, neighbour
from social_fleet.planning.norms import Norm

# A change of the followed distance by more than this many steps is an opening, not a drift.
OPENING = 2.0


def walls_beside(blocked: np.ndarray, resolution: float, *, limit: float, stretch: float) -> np.ndarray:
    """Distance to the nearest wall in each heading, along a stretch of wall rather than a single ray.

    A robot that drives along a wall takes doors, gaps between the marks of a laser and other openings narrower than
    the stretch for wall. So the distance is the least of the rays that start within half a `stretch` [m] to either
    side of the cell and are not separated from it by a wall.

    Returns
    -------
    (8, rows, cols) float32 array
        [m], capped at `limit`.
    """
    walls = wall_distances(blocked, resolution, limit=limit)
    for heading in range(8):
        step = resolution * (1.0 if heading % 2 == 0 else SQRT2)
        reach = math.ceil(0.5 * stretch / step - 1e-9)
        dcol, drow = HEADINGS[(heading + 2) % 8]
        walls[heading] = _least_along(walls[heading], blocked, int(drow), int(dcol), reach)
    return walls


@njit(cache=True)
def _least_along(field: np.ndarray, blocked: np.ndarray, drow: int, dcol: int, reach: int) -> np.ndarray:
    """Least value within `reach` steps of (drow, dcol) or its opposite, as far as cells are not blocked."""
    rows, cols = field.shape
    least = field.copy()
    for sense in (1, -1):
        for r in range(rows):
            for c in range(cols):
                if blocked[r, c]:
                    continue
                value = least[r, c]
                r2, c2 = r, c
                for _ in range(reach):
                    r2 += sense * drow
                    c2 += sense * dcol
                    if r2 < 0 or c2 < 0 or r2 >= rows or c2 >= cols or blocked[r2, c2]:
                        break
                    value = min(value, field[r2, c2])
                least[r, c] = value
    return least


def edge_costs(lattice: Lattice, blocked: np.ndarray, norm: Norm, *, stretch: float = 0.0) -> np.ndarray:
    """The social cost phi of Eq. 3 for all edges.

    Parameters
    ----------
    lattice : Lattice
        The graph.
    blocked : (rows, cols) bool array
        The map that it was made from.
    norm : Norm
        What to charge.
    stretch : float
        Length of wall [m] that counts as one, see `walls_beside`.

    Returns
    -------
    (N, 8) float32 array
        Social cost [m] of the edge that leaves a node in a heading, infinite where there is no such edge. The
        line integral is by trapezoids; the drift counts as in `HeadingCost`.
    """
    walls = walls_beside(blocked, lattice.resolution, limit=norm.reach, stretch=stretch)
    walls = walls[:, lattice.row, lattice.col]
    social = np.empty((len(lattice), 8), dtype=np.float32)
    for heading in range(8):
        cost = norm.heading_cost(walls, heading)
        rate, followed, weight = (np.asarray(part, dtype=np.float32)
                                  for part in (cost.rate, cost.followed, cost.change_weight))
        _integrate(heading, lattice.lengths[heading], lattice.up, lattice.down, lattice.edges, rate, followed, weight,
                   social)
    return social


@njit(cache=True)
def _integrate(heading: int, length: float, up: np.ndarray, down: np.ndarray, edges: np.ndarray, rate: np.ndarray,
               followed: np.ndarray, weight: np.ndarray, social: np.ndarray) -> None:
    for n in range(len(up)):
        if not edges[n] >> heading & 1:
            social[n, heading] = np.inf
            continue
        m = neighbour(n, heading, up, down)
        cost = 0.5 * length * (rate[n] + rate[m])
        drift = abs(followed[m] - followed[n])
        if drift <= OPENING * length + 1e-6:
            cost += min(weight[n], weight[m]) * drift
        social[n, heading] = cost
