"""Whether a pose can be believed: one that has moved farther than the robot can is a jump."""

import math
from typing import Optional

from social_fleet.coordination.robot import MotionLimits
from social_fleet.geometry import Pose, wrap_angle


class PoseWatch:
    """Compares each pose with the one before.

    Parameters
    ----------
    jump, turn_jump : float
        By how much a pose may move more than the robot can, for the noise of localisation [m, rad].
    settle : float
        For how long poses must hang together after a jump before they are believed again [s].

    Attributes
    ----------
    reason : str
        Why the pose is not believed, as a sentence; empty when it is.
    """

    def __init__(self, *, jump: float = 0.15, turn_jump: float = 0.3, settle: float = 1.0) -> None:
        self._jump = jump
        self._turn_jump = turn_jump
        self._settle = settle
        self._last: Optional[Pose] = None
        self._seen = -math.inf
        self._jumped = -math.inf
        self._length = 0.0
        self.reason = ""

    def believes(self, now: float, pose: Pose, limits: MotionLimits) -> bool:
        """Whether `pose` [m, rad], got at `now` [s], can be acted on."""
        if self._last is not None and pose != self._last:
            elapsed = max(now - self._seen, 0.0)
            moved = math.hypot(pose.x - self._last.x, pose.y - self._last.y)
            turned = abs(wrap_angle(pose.yaw - self._last.yaw))
            if (moved > self._jump + limits.max_speed * elapsed
                    or turned > self._turn_jump + limits.max_turn_rate * elapsed):
                self._jumped, self._length = now, moved
        self._last, self._seen = pose, now
        settled = now - self._jumped >= self._settle or now < self._jumped  # a clock that went back starts anew
        self.reason = "" if settled else f"the pose has jumped by {self._length:.2f} m"
        return settled
