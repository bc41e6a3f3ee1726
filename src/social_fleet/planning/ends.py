"""The two ends of a plan: poses checked, and joined to the lattice where the robot can drive straight."""

import math
from typing import List, Optional, Sequence, Tuple

import numpy as np

from social_fleet.errors import InvalidGoal, InvalidStart
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.driven_path.chords import Ground, fits_along
from social_fleet.planning.lattice import Lattice
from social_fleet.planning.overlays.discs import Disc
from social_fleet.planning.overlays.overlaid import Overlaid, check_clear

REACH = 3  # [cells] how far from a pose its path may join the lattice


def parsed_pose(pose: Sequence[float], what: str) -> List[float]:
    """A pose's two or three finite numbers.

    Raises
    ------
    InvalidStart, InvalidGoal
        As `what` says: when it holds something else.
    """
    error = InvalidStart if what == "start" else InvalidGoal
    try:
        numbers = [float(value) for value in pose]
    except (TypeError, ValueError):
        raise error(f"must be (x, y) or (x, y, yaw), not {pose!r}", field=what) from None
    if len(numbers) not in (2, 3):
        raise error(f"must be (x, y) or (x, y, yaw), not {len(numbers)} numbers", field=what)
    if not all(map(math.isfinite, numbers)):
        raise error(f"must be finite, not ({', '.join(f'{value:g}' for value in numbers)})", field=what)
    return numbers


def checked_position(space: ConfigurationSpace, pose: Sequence[float], what: str, avoid: Sequence[Disc],
                     overlaid: Optional[Overlaid] = None) -> np.ndarray:
    """A pose's position in cells along the grid's axes.

    Parameters
    ----------
    space : ConfigurationSpace
        Where the robot fits.
    pose : (x, y) or (x, y, yaw)
        [m, rad, map frame].
    what : str
        ``start`` or ``goal``.
    avoid : sequence of Disc
        What the path keeps out of.
    overlaid : Overlaid, optional
        Obstacles that the map does not hold.

    Raises
    ------
    InvalidStart, InvalidGoal
        As `what` says: when the robot cannot stand there.
    """
    error = InvalidStart if what == "start" else InvalidGoal
    x, y = parsed_pose(pose, what)[:2]
    space.check_pose(x, y, what)
    if overlaid is not None:
        check_clear(overlaid, space, x, y, what)
    for disc in avoid:
        if disc.holds(x, y):
            raise error(f"({x:.2f}, {y:.2f}) lies within {disc.radius:.2f} m of ({disc.x:.2f}, {disc.y:.2f}), "
                        "which the path must avoid", field=what)
    return space.grid.to_local([(x, y)])[0] / space.grid.resolution


def joined(lattice: Lattice, ground: Ground, ends: Sequence[np.ndarray], closed: np.ndarray) -> List[Tuple[int, int]]:
    """Nodes where a path may leave the start and reach the goal: pairs that reach each other, the nearest first.

    A pose joins its own cell's node. Where that lies in a pocket too tight for the margin, from which the robot gets
    out as an end of a path needs its radius alone, it joins others.

    Parameters
    ----------
    ends : (start, goal)
        In cells along the grid's axes.
    closed : (M,) int array
        Nodes that the path must not enter.
    """
    component = lattice.component
    for all_near in (False, True):
        starts, goals = (reachable(lattice, ground, end, closed, all_near=all_near) for end in ends)
        pairs = [(start, goal) for start in starts for goal in goals if component[start] == component[goal]]
        if pairs:
            return pairs
    return []


def reachable(lattice: Lattice, ground: Ground, point: np.ndarray, closed: np.ndarray, *,
              all_near: bool = False) -> List[int]:
    """Nodes that the robot reaches from `point` in a straight line, nearest first.

    Its own cell's alone if possible, unless `all_near` are wanted.
    """
    node = lattice.node
    row, col = int(math.floor(point[1] + 1e-9)), int(math.floor(point[0] + 1e-9))
    own = int(node[row, col])
    if not all_near and own >= 0 and own not in closed and fits_along(ground, point[0], point[1], col + 0.5, row + 0.5):
        return [own]
    window = node[max(row - REACH, 0):row + REACH + 1, max(col - REACH, 0):col + REACH + 1]
    near = window[(window >= 0) & ~np.isin(window, closed)]
    x, y = lattice.col[near] + 0.5, lattice.row[near] + 0.5
    order = np.argsort(np.hypot(x - point[0], y - point[1]), kind="stable")
    return [int(near[i]) for i in order if fits_along(ground, point[0], point[1], x[i], y[i])]
