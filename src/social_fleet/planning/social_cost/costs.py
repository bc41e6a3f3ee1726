"""Social cost of every edge, computed once per map, norm and radius."""

import math
from typing import Sequence, Tuple

import numpy as np
from numba import njit

from social_fleet.errors import InvalidParameter
from social_fleet.mapping.walls import HEADINGS, wall_distances
from social_fleet.planning.lattice import SQRT2, Lattice, Links, neighbour
from social_fleet.planning.social_cost.norms import Norm

# A change of the followed distance by more than this many steps is an opening, not a drift.
OPENING = 2.0
MOST_RATE = 1e8  # of social cost per metre; sums of what is dearer would not be exact, and take a search minutes
STRAIGHT_GAIN = 0.95  # share of a zigzag's cost that the straight way costs at most


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


def edge_costs(lattice: Lattice, blocked: np.ndarray, norm: Norm, *, stretch: float = 0.0,
               zoned: Sequence[Tuple[np.ndarray, Norm]] = ()) -> np.ndarray:
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
    zoned : sequence of (nodes, norm)
        Nodes where another norm holds, see `zones.zoned_norms`. The rate of an edge between two norms is the mean of
        theirs.

    Returns
    -------
    (N, 8) float32 array
        Social cost [m] of the edge that leaves a node in a heading, infinite where there is no such edge. The
        line integral is by trapezoids; the drift counts as in `HeadingCost`.

    Raises
    ------
    InvalidParameter
        When the norm yields a rate that is negative, not finite, or beyond `MOST_RATE`.
    """
    reach = max(each.reach for each in (norm, *(other for _, other in zoned)))
    walls = walls_beside(blocked, lattice.resolution, limit=reach, stretch=stretch)
    walls = walls[:, lattice.row, lattice.col]
    fields = _fields(norm, walls)
    for nodes, other in zoned:
        fields[:, :, nodes] = _fields(other, walls[:, nodes])
    rates, followed, weights = fields
    _forbid_tacking(rates)
    social = np.empty((len(lattice), 8), dtype=np.float32)
    for heading in range(8):
        _integrate(lattice.links, heading, rates[heading], followed[heading], weights[heading], social)
    return social


def _fields(norm: Norm, walls: np.ndarray) -> np.ndarray:
    """Rate, followed distance and weight of its drift for all headings at all nodes, shape (3, 8, N)."""
    fields = np.empty((3, *walls.shape), dtype=np.float32)
    name = type(norm).__name__
    for heading in range(8):
        cost = norm.heading_cost(walls, heading)
        for index, values in enumerate((cost.rate, cost.followed, cost.change_weight)):
            if np.shape(values) != walls.shape[1:]:
                raise InvalidParameter(f"{name} yields arrays of shape {np.shape(values)} for {walls.shape[1]} cells",
                                       field="norm")
            fields[index, heading] = values
    for values, what in ((fields[0], "rate"), (fields[2], "weight of drift")):
        if not ((values >= 0.0) & (values <= MOST_RATE)).all():  # NaN is neither
            raise InvalidParameter(f"{name} yields a {what} that is not within 0 to {MOST_RATE:g}", field="norm")
    return fields


@njit(cache=True)
def _forbid_tacking(rates: np.ndarray) -> None:
    """Lower the rate of a heading to what it costs to make way in it by zigzag in two others, and a little less.

    A norm judges every heading by itself, so two headings may be cheap that enclose a dear one; the cheapest way in
    the dear one would then be to tack like a boat. A unit of way is made by 1 / sqrt(2) in each of the two headings 45
    degrees off, or by sqrt(2) in one of these and 1 in the one 90 degrees off on the other side.
    """
    per_metre = np.empty(8)
    for n in range(rates.shape[1]):
        for k in range(8):
            per_metre[k] = 1.0 + rates[k, n]
        for k in range(8):
            left, right = per_metre[(k + 1) % 8], per_metre[(k + 7) % 8]
            zigzag = min((left + right) / SQRT2, SQRT2 * left + per_metre[(k + 6) % 8],
                         SQRT2 * right + per_metre[(k + 2) % 8])
            rates[k, n] = min(rates[k, n], max(STRAIGHT_GAIN * zigzag - 1.0, 0.0))


@njit(cache=True)
def _integrate(links: Links, heading: int, rate: np.ndarray, followed: np.ndarray, weight: np.ndarray,
               social: np.ndarray) -> None:
    """Fill the column of `social` for one heading."""
    length = links.lengths[heading]
    for n in range(len(links.row)):
        if not links.edges[n] >> heading & 1:
            social[n, heading] = np.inf
            continue
        m = neighbour(links, n, heading)
        cost = 0.5 * length * (rate[n] + rate[m])
        drift = abs(followed[m] - followed[n])
        if drift <= OPENING * length + 1e-6:
            cost += min(weight[n], weight[m]) * drift
        social[n, heading] = cost
