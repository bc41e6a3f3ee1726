"""From the cells of a search to the path that is driven: long chords and round corners.

String pulling replaces stretches of the searched path by straight chords where the robot fits and the cost, measured
over the same edges, stays within a bound; so a lane beside a wall remains a lane. Corners become arcs as large as the
room allows. See doc/planning.md.
"""

import math

import numpy as np
from numba import njit

from social_fleet.planning.driven_path.chords import Ground, Prices
from social_fleet.planning.driven_path.corners import merge_bends, round_corners
from social_fleet.planning.driven_path.pulling import candidates_of, drop_needless, pull

STAIRCASE = 0.75  # [cells] a staircase strays from the line that it approximates
UNEVEN = 0.1  # [m] by which what is one straight piece may stray from a line on fine grids
SPACING = 1.0  # [m] between places where a chord may end
VERTEX_COST = 0.1  # [m] that a vertex is worth, so that chords come out long
TURN_COST = 1.5  # [m/rad] that a turn is worth at least
STEADY_TURN_COST = 40.0  # [m/rad] that it is worth at most on a social path
SHORT_WAY = 25.0  # [m] what a social path costs for which a turn is worth no more
MOST_SLACK = 14.0  # [m] by which any chord may be dearer than what it replaces
REACH = 20.0  # [m] of a single chord before the last pass
PATIENCE = 4
MENDING_PATIENCE = 20
SMALLEST_RADIUS = 0.1  # [m] of a corner's arc
ARC_STEP = 0.15  # [m] between vertices on an arc
SHARP = math.radians(20.0)  # a turn for which a robot stops
JOG = 0.4  # [m] below which a side beside a sharp turn belongs to a jog
JOG_MARGIN = 1.0  # [m] of the path beside a jog that is looked at again
MOST_MENDING = 60  # points that are looked at again, or hardly more
NARROW_REACH = 1.0  # [m] of a chord that may use up some of the margin
SHORT_SIDE = 0.8  # [m] below which two turns of the same sense become one


def smooth(points: np.ndarray, nodes: np.ndarray, paid: np.ndarray, ground: Ground, prices: Prices, *,
           bound: float, corner_radius: float, least: float) -> np.ndarray:
    """The drivable path along a searched one.

    Parameters
    ----------
    points : (M, 2) array
        The searched path in cells along the grid's axes, ends included.
    nodes : (M,) int array
        Lattice node of every point.
    paid : (M,) array
        Cost of the path up to every point [m].
    ground, prices
        Where a robot fits with its margin, and what edges cost.
    bound : float
        Share of the path's whole cost by which a chord may be dearer than what it replaces; negative to look at
        length alone.
    corner_radius : float
        Largest radius of an arc [m], 0 for none.
    least : float
        The robot's radius with less of a margin [cells], for places where all of it leaves only a jog.

    Returns
    -------
    (N, 2) array
        Vertices in cells, the first and last those of `points`.
    """
    return _smooth(points, nodes, paid, bound, corner_radius, least, *ground, *prices.links, prices.social,
                   prices.exempt)


@njit(cache=True, nogil=True)
def _smooth(points: np.ndarray, nodes: np.ndarray, paid: np.ndarray, bound: float, corner_radius: float, least: float,
            blocked: np.ndarray, clearance: np.ndarray, resolution: float, radius: float, discs: np.ndarray,
            row: np.ndarray, col: np.ndarray, up: np.ndarray, down: np.ndarray, edges: np.ndarray,
            lengths: np.ndarray, social: np.ndarray, exempt: np.ndarray) -> np.ndarray:
    """`smooth`, with the arrays of ground and prices one by one: Numba is slow to recognise tuples of arrays."""
    ground = (blocked, clearance, resolution, radius, discs)
    prices = (row, col, up, down, edges, lengths), social, exempt
    slack, turn_cost = bound, TURN_COST
    if bound >= 0.0:
        slack = min(bound * paid[-1], MOST_SLACK)
        # A long way leaves room for gentle lane changes; a short one would consist of them.
        turn_cost = min(max(paid[-1] - SHORT_WAY, TURN_COST), STEADY_TURN_COST)
    tolerance = max(STAIRCASE, UNEVEN / resolution)
    candidates = candidates_of(ground, prices, points, nodes, paid, tolerance, SPACING / resolution, slack)
    chosen = pull(ground, prices, points, nodes, paid, candidates, slack, VERTEX_COST, turn_cost, REACH, PATIENCE,
                  radius, 0.0)
    chosen = drop_needless(ground, prices, points, nodes, paid, chosen, slack, VERTEX_COST, turn_cost)
    path = rounded(ground, points[chosen], corner_radius, least)
    if not (turns(path) > SHARP).any():
        return path
    for first, last in jogs(points[chosen], JOG / resolution)[::-1]:
        window = _around(chosen, first, last, int(JOG_MARGIN / resolution))
        # So short a stretch is no lane: length alone counts.
        mended = pull(ground, prices, points, nodes, paid, window, -1.0, VERTEX_COST, TURN_COST, REACH,
                      MENDING_PATIENCE, least, NARROW_REACH)
        chosen = np.concatenate((chosen[:first], mended, chosen[last + 1:]))
    return rounded(ground, points[chosen], corner_radius, least)


@njit(cache=True, nogil=True)
def _around(chosen: np.ndarray, first: int, last: int, margin: int) -> np.ndarray:
    """Candidates to mend a jog: the vertices `first` and `last`, and all points up to `margin` from those between."""
    low, high = chosen[first], chosen[last]
    near = np.arange(max(low + 1, chosen[first + 1] - margin), min(high, chosen[last - 1] + margin + 1))
    # Where jogs follow one another over a long stretch, some of its points will do.
    return np.concatenate((np.array([low]), near[::1 + len(near) // MOST_MENDING], np.array([high])))


@njit(cache=True, nogil=True)
def turns(vertices: np.ndarray) -> np.ndarray:
    """Heading change [rad] at every inner vertex, without sign."""
    steps = vertices[1:] - vertices[:-1]
    headings = np.arctan2(steps[:, 1], steps[:, 0])
    change = headings[1:] - headings[:-1]
    return np.abs((change + math.pi) % (2.0 * math.pi) - math.pi)


@njit(cache=True, nogil=True)
def jogs(vertices: np.ndarray, longest: float) -> np.ndarray:
    """First and last vertex (J, 2) of the stretches with a turn in place beside a side shorter than `longest`."""
    steps = vertices[1:] - vertices[:-1]
    sides = np.hypot(steps[:, 0], steps[:, 1])
    sharp = np.flatnonzero((turns(vertices) > SHARP) & (np.minimum(sides[:-1], sides[1:]) < longest)) + 1
    stretches, count = np.empty((len(sharp), 2), dtype=np.int64), 0
    for v in sharp:
        if count and v - 1 <= stretches[count - 1, 1]:
            count -= 1
        else:
            stretches[count, 0] = v - 1
        stretches[count, 1] = v + 1
        count += 1
    return stretches[:count]


@njit(cache=True, nogil=True)
def rounded(ground: Ground, vertices: np.ndarray, corner_radius: float, least: float) -> np.ndarray:
    """A polyline (M, 2) in cells with short bends merged and corners rounded by up to `corner_radius` [m].

    Where the margin leaves no room for an arc, the radius `least` [cells] does.
    """
    _, _, resolution, _, _ = ground
    kept, count = vertices.copy(), 1
    for v in range(1, len(vertices)):
        apart = np.abs(vertices[v] - vertices[v - 1]).max() > 1e-9
        if apart or v == len(vertices) - 1:
            kept[count] = vertices[v]
            count += 1
    kept = kept[:count].copy()
    if corner_radius <= 0.0 or count < 3:
        return kept
    kept = merge_bends(ground, kept, SHORT_SIDE / resolution)
    return round_corners(ground, least, kept, corner_radius / resolution, SMALLEST_RADIUS / resolution,
                         ARC_STEP / resolution)
