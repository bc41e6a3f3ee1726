"""What robots see of discs: the hits of a lidar without the map, at the price of a few distances."""

import math
from typing import Tuple

import numpy as np
from numba import njit

from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.simulation.lidar import cast_rays

_BEAM = math.radians(2.0)  # between two beams [rad]


def hits(x: float, y: float, discs: np.ndarray, reach: float, own: int = -1) -> np.ndarray:
    """Where beams from (x, y) hit discs within reach, (N, 2) [m, map frame], disc after disc, each in beam order.

    Parameters
    ----------
    discs : (D, 3) array
        Centres and radii [m, map frame].
    reach : float
        Range of the lidar [m].
    own : int
        Row of the disc that looks; -1 when it is none of them.
    """
    return _hits(x, y, discs, reach, _BEAM, own)


def in_sight(grid: OccupancyGrid, x: float, y: float, other: Tuple[float, float]) -> bool:
    """Whether no wall stands between two places [m, map frame]."""
    dx, dy = other[0] - x, other[1] - y
    gap = math.hypot(dx, dy)
    local = np.asarray(grid.to_local(np.array([[x, y]])), dtype=float)[0] / grid.resolution
    angle = np.array([math.atan2(dy, dx) - grid.origin.yaw])
    return bool(cast_rays(grid.blocked, local[0], local[1], angle, gap / grid.resolution)[0] * grid.resolution >= gap)


@njit(cache=True)
def _hits(x, y, all_discs, reach, beam, own):  # type: ignore[no-untyped-def]
    near = np.empty(len(all_discs), np.int64)
    found = 0
    for disc in range(len(all_discs)):
        reached = reach + all_discs[disc, 2]
        if disc != own and (all_discs[disc, 0] - x) ** 2 + (all_discs[disc, 1] - y) ** 2 <= reached * reached:
            near[found] = disc
            found += 1
    discs = all_discs[near[:found]]
    points = np.empty((64 if found else 0, 2))
    count = 0
    for disc in range(len(discs)):
        dx, dy, radius = discs[disc, 0] - x, discs[disc, 1] - y, discs[disc, 2]
        gap = math.sqrt(dx * dx + dy * dy)
        if gap - radius > reach or gap <= radius:
            continue
        half = math.asin(min(radius / gap, 1.0)) * 0.999
        middle = math.atan2(dy, dx)
        beams = max(int(2.0 * half / beam), 2)
        for index in range(beams + 1):
            angle = middle - half + 2.0 * half * index / beams
            along = dx * math.cos(angle) + dy * math.sin(angle)
            distance = along - math.sqrt(max(along * along - gap * gap + radius * radius, 0.0))
            hidden = distance > reach
            for other in range(len(discs)):
                if other == disc or hidden:
                    continue
                ex, ey = discs[other, 0] - x, discs[other, 1] - y
                across = ex * math.cos(angle) + ey * math.sin(angle)
                room = across * across - ex * ex - ey * ey + discs[other, 2] * discs[other, 2]
                hidden = across > 0.0 and room >= 0.0 and across - math.sqrt(room) < distance
            if hidden:
                continue
            if count == len(points):
                grown = np.empty((2 * count, 2))
                grown[:count] = points
                points = grown
            points[count, 0], points[count, 1] = x + distance * math.cos(angle), y + distance * math.sin(angle)
            count += 1
    return points[:count]
