"""What a planner returns."""

from dataclasses import dataclass, field
from typing import Optional, Tuple

import numpy as np

from social_fleet.geometry import Polyline


def _no_cells() -> np.ndarray:
    return np.zeros((0, 2), dtype=np.int32)


@dataclass(frozen=True)
class Plan:
    """One robot's path: exactly the geometry that is scheduled and driven.

    Attributes
    ----------
    points : (N, 2) array
        Vertices of the path [m, map frame], from the start to the goal.
    length : float
        Arc length of `points` [m].
    social_cost, cost : float
        The social part of the cost of the searched cells, and Eq. 2 or 4 whole (length + social part) [m].
    cells : (M, 2) int array
        (row, column) of the searched path, what heatmaps aggregate.
    expanded : int
        Nodes that the search took from its queue.
    search_time : float
        Wall time of search and smoothing [s].
    planner : str
        ``social``, ``shortest`` or ``rrt_star``; ``given`` where the points came without a planner.
    robot_radius : float
        Radius that the path was planned for [m].
    start_yaw, goal_yaw : float, optional
        Headings at the ends [rad], None where any will do.
    temporary : bool
        The path is a detour round a temporary obstacle.
    obstacles : tuple of str
        Names of the temporary obstacles that it comes near.
    goal_shift : float
        How far from the goal that was asked for the path ends [m].
    stops : tuple of float
        Arc lengths [m] of places on the way where the robot may have to let others pass.
    message : str
        What a user should know of the path, such as why it ends elsewhere; empty when there is nothing.
    """

    points: np.ndarray
    length: float
    social_cost: float
    cost: float
    expanded: int
    search_time: float
    planner: str
    robot_radius: float
    cells: np.ndarray = field(default_factory=_no_cells)
    start_yaw: Optional[float] = None
    goal_yaw: Optional[float] = None
    temporary: bool = False
    obstacles: Tuple[str, ...] = ()
    goal_shift: float = 0.0
    stops: Tuple[float, ...] = ()
    message: str = ""

    @property
    def path(self) -> Polyline:
        """`points` as a polyline."""
        return Polyline(self.points)
