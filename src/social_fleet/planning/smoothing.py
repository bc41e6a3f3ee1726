"""From the cells of a search to the path that is driven: long chords and round corners.

String pulling replaces stretches of the searched path by straight chords where the robot fits and the cost, measured
over the same edges, stays within a bound; so a lane beside a wall remains a lane. Corners become arcs as large as the
room allows. See doc/planning.md.
"""

import numpy as np

from social_fleet.planning.chords import Ground, Prices, candidates_of, drop_needless, pull
from social_fleet.planning.corners import merge_bends, round_corners

STAIRCASE = 0.75  # [cells] a staircase strays from the line that it approximates
SPACING = 1.0  # [m] between places where a chord may end
VERTEX_COST = 0.1  # [m] that a vertex is worth, so that chords come out long
TURN_COST = 1.5  # [m/rad] that a turn is worth
REACH = 15.0  # [m] of a single chord before the last pass
PATIENCE = 6
SMALLEST_RADIUS = 0.1  # [m] of a corner's arc
ARC_STEP = 0.15  # [m] between vertices on an arc
SHORT_SIDE = 0.8  # [m] below which two turns of the same sense become one


def smooth(points: np.ndarray, nodes: np.ndarray, paid: np.ndarray, ground: Ground, prices: Prices, *,
           bound: float, corner_radius: float) -> np.ndarray:
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
        Where a robot fits and what edges cost.
    bound : float
        Share by which a chord may be dearer than what it replaces; negative to look at length alone.
    corner_radius : float
        Largest radius of an arc [m], 0 for none.

    Returns
    -------
    (N, 2) array
        Vertices in cells, the first and last those of `points`.
    """
    if len(points) < 3:
        return points.copy()
    cells = 1.0 / ground.resolution
    candidates = candidates_of(points, STAIRCASE, SPACING * cells)
    chosen = pull(ground, prices, points, nodes, paid, candidates, bound, VERTEX_COST, TURN_COST, REACH, PATIENCE)
    # Where no chord fitted, every point of the path becomes a candidate.
    chosen = pull(ground, prices, points, nodes, paid, chosen, bound, VERTEX_COST, TURN_COST, REACH, 2 * PATIENCE)
    chosen = drop_needless(ground, prices, points, nodes, paid, chosen, bound, VERTEX_COST, TURN_COST)
    vertices = points[chosen]
    if corner_radius <= 0.0:
        return vertices
    vertices = merge_bends(ground, vertices, SHORT_SIDE * cells)
    return round_corners(ground, vertices, corner_radius * cells, SMALLEST_RADIUS * cells, ARC_STEP * cells)
