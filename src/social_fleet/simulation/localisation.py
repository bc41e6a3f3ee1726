"""Localisation as a robot gets it: the true pose with a wandering, bounded error."""

import math
import random

from social_fleet.geometry import Pose, wrap_angle

_MEMORY = 2.0  # time constant of the wandering [s]


class Localisation:
    """Adds to a pose an error that wanders smoothly and never exceeds its bound.

    Parameters
    ----------
    position_error, heading_error : float
        Bounds [m, rad]; 0 gives the true value. A third of a bound is the standard deviation.
    seed : int
        Of the noise.
    name : str
        Robots of different names err differently.
    """

    def __init__(self, position_error: float = 0.0, heading_error: float = 0.0, *, seed: int = 0,
                 name: str = "") -> None:
        self._position_error = position_error
        self._heading_error = heading_error
        self._random = random.Random(f"{seed}/{name}")
        self._offset = (0.0, 0.0, 0.0)

    def estimate(self, pose: Pose, period: float) -> Pose:
        """What localisation says of the true `pose`, `period` seconds after it was last asked."""
        if self._position_error == 0.0 and self._heading_error == 0.0:
            return pose
        keep = math.exp(-period / _MEMORY)
        spread = math.sqrt(1.0 - keep * keep)
        x, y, yaw = (keep * old + spread * self._random.gauss(0.0, bound / 3.0) for old, bound in
                     zip(self._offset, (self._position_error, self._position_error, self._heading_error)))
        excess = max(math.hypot(x, y) / self._position_error, 1.0) if self._position_error > 0.0 else 1.0
        yaw = min(max(yaw, -self._heading_error), self._heading_error)
        self._offset = (x / excess, y / excess, yaw)
        return Pose(pose.x + self._offset[0], pose.y + self._offset[1], wrap_angle(pose.yaw + yaw))
