"""How far a robot's path is free of the obstacles that it can see."""

import math
from typing import List, Sequence, Tuple

import numpy as np

from social_fleet.coordination.robot import Robot
from social_fleet.simulation.faults import CircleObstacle

_MARGIN = 0.1  # room to leave [m]
_SIGHT = 5.0  # how far ahead obstacles are seen [m]
_STEP = 0.05  # sampling of the path [m]


class Lookout:
    """Knows the stretches of one robot's path that each obstacle blocks while it is there.

    Parameters
    ----------
    robot : Robot
        The robot with its path.
    obstacles : sequence of CircleObstacle
        What may stand in its way.
    """

    def __init__(self, robot: Robot, obstacles: Sequence[CircleObstacle]) -> None:
        arcs = np.linspace(0.0, robot.path.length, max(2, int(robot.path.length / _STEP) + 1))
        points = robot.path.position(arcs)
        self._blocked: List[Tuple[float, float, CircleObstacle]] = []
        for obstacle in obstacles:
            reach = robot.body_radius + obstacle.radius + _MARGIN
            near = np.hypot(points[:, 0] - obstacle.x, points[:, 1] - obstacle.y) < reach
            edges = np.diff(np.pad(near.astype(int), 1, mode="constant"))
            self._blocked += [(float(arcs[begin]), float(arcs[end - 1]), obstacle)
                              for begin, end in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1))]

    def horizon(self, now: float, progress: float) -> float:
        """The arc length [m] that must not be passed at `now` by a robot at `progress`; infinite when all is free."""
        bounds = (begin for begin, end, obstacle in self._blocked
                  if end > progress and begin < progress + _SIGHT and obstacle.present(now))
        return min(bounds, default=math.inf)
