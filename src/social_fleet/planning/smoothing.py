"""From the cells of a search to the path that is driven: long chords and round corners.

String pulling replaces stretches of the searched path by straight chords where the robot fits and the cost, measured
over the same edges, stays within a bound; so a lane beside a wall remains a lane. Corners become arcs as large as the
room allows. See doc/planning.md.
"""

import math
from typing import List, Tuple

import numpy as np

from social_fleet.planning.chords import Ground, Prices, candidates_of, drop_needless, pull
from social_fleet.planning.corners import merge_bends, round_corners

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
    slack = min(bound * paid[-1], MOST_SLACK) if bound >= 0.0 else bound
    turn_cost = TURN_COST
    if bound >= 0.0:
        # A long way leaves room for gentle lane changes; a short one would consist of them.
        turn_cost = min(max(paid[-1] - SHORT_WAY, TURN_COST), STEADY_TURN_COST)
    tolerance, spacing = max(STAIRCASE, UNEVEN / ground.resolution), SPACING / ground.resolution
    candidates = candidates_of(ground, prices, points, nodes, paid, tolerance, spacing, slack)
    chosen = pull(ground, prices, points, nodes, paid, candidates, slack, VERTEX_COST, turn_cost, REACH, PATIENCE,
                  ground, 0.0)
    chosen = drop_needless(ground, prices, points, nodes, paid, chosen, slack, VERTEX_COST, turn_cost)
    path = rounded(ground, points[chosen], corner_radius, least)
    if not (turns(path) > SHARP).any():
        return path
    narrow = ground._replace(radius=least)
    for first, last in reversed(jogs(points[chosen], JOG / ground.resolution)):
        window = _around(chosen, first, last, int(JOG_MARGIN / ground.resolution))
        # So short a stretch is no lane: length alone counts.
        mended = pull(ground, prices, points, nodes, paid, window, -1.0, VERTEX_COST, TURN_COST, REACH,
                      MENDING_PATIENCE, narrow, NARROW_REACH)
        chosen = np.concatenate([chosen[:first], mended, chosen[last + 1:]])
    return rounded(ground, points[chosen], corner_radius, least)


def _around(chosen: np.ndarray, first: int, last: int, margin: int) -> np.ndarray:
    """Candidates to mend a jog: the vertices `first` and `last`, and all points up to `margin` from those between."""
    low, high = chosen[first], chosen[last]
    near = np.arange(max(low + 1, chosen[first + 1] - margin), min(high, chosen[last - 1] + margin + 1))
    # Where jogs follow one another over a long stretch, some of its points will do.
    return np.concatenate([[low], near[::1 + len(near) // MOST_MENDING], [high]])


def turns(vertices: np.ndarray) -> np.ndarray:
    """Heading change [rad] at every inner vertex, without sign."""
    steps = np.diff(vertices, axis=0)
    change = np.diff(np.arctan2(steps[:, 1], steps[:, 0]))
    return np.abs((change + math.pi) % (2.0 * math.pi) - math.pi)


def jogs(vertices: np.ndarray, longest: float) -> List[Tuple[int, int]]:
    """First and last vertex of the stretches that hold a turn in place beside a side shorter than `longest`."""
    sides = np.hypot(*np.diff(vertices, axis=0).T)
    sharp = np.flatnonzero((turns(vertices) > SHARP) & (np.minimum(sides[:-1], sides[1:]) < longest)) + 1
    stretches: List[Tuple[int, int]] = []
    for v in sharp:
        low, high = int(v) - 1, int(v) + 1
        if stretches and low <= stretches[-1][1]:
            low = stretches.pop()[0]
        stretches.append((low, high))
    return stretches


def rounded(ground: Ground, vertices: np.ndarray, corner_radius: float, least: float) -> np.ndarray:
    """A polyline (M, 2) in cells with short bends merged and corners rounded by up to `corner_radius` [m].

    Where the margin leaves no room for an arc, the radius `least` [cells] does.
    """
    distinct = np.concatenate([[True], (np.abs(np.diff(vertices, axis=0)) > 1e-9).any(axis=1)])
    distinct[-1] = True
    vertices = np.ascontiguousarray(vertices[distinct])
    if corner_radius <= 0.0 or len(vertices) < 3:
        return vertices
    cells = 1.0 / ground.resolution
    vertices = merge_bends(ground, vertices, SHORT_SIDE * cells)
    return round_corners(ground, ground._replace(radius=least), vertices, corner_radius * cells,
                         SMALLEST_RADIUS * cells, ARC_STEP * cells)
