"""Whether a pose can be believed: one that has moved farther than the robot can is a jump."""

import math
from typing import Optional

from social_fleet.coordination.robot import MotionLimits
from social_fleet.geometry import Pose, wrap_angle

_RETURN = 1.0  # for how long poses must hang together that came back to where the robot can be [s]


class PoseWatch:
    """Compares each pose with the one before, and after a jump with the last one that was believed.

    A pose that comes back to where the robot can be is believed after a second. One that stays elsewhere is believed
    after `settle`: then somebody has moved the robot, or its localisation was wrong before.

    Parameters
    ----------
    jump, turn_jump : float
        By how much a pose may move more than the robot can, for the noise of localisation [m, rad].
    settle : float
        For how long poses must hang together elsewhere before they are believed [s].

    Attributes
    ----------
    reason : str
        Why the pose is not believed, as a sentence; empty when it is.
    """

    def __init__(self, *, jump: float = 0.15, turn_jump: float = 0.3, settle: float = 10.0) -> None:
        self._jump = jump
        self._turn_jump = turn_jump
        self._settle = settle
        self._last: Optional[Pose] = None
        self._seen = -math.inf
        self._believed = Pose(0.0, 0.0)
        self._jumped = -math.inf
        self.reason = ""

    def believes(self, now: float, pose: Pose, limits: MotionLimits) -> bool:
        """Whether `pose` [m, rad], got at `now` [s], can be acted on."""
        if self._last is not None and pose != self._last and not self._near(pose, self._last, now - self._seen, limits):
            self._jumped = now
        self._last, self._seen = pose, now
        since = now - self._jumped
        if since < 0.0:  # a clock that went back starts anew
            self._jumped, since = -math.inf, math.inf
        stopped = limits.max_speed / limits.max_acceleration  # since the jump it has braked
        settled = since >= self._settle or (since >= _RETURN and self._near(pose, self._believed, stopped, limits))
        if settled or since == math.inf:
            self._jumped = -math.inf
            self._believed = pose
            self.reason = ""
            return True
        self.reason = f"the pose has jumped by {math.hypot(pose.x - self._believed.x, pose.y - self._believed.y):.2f} m"
        return False

    def _near(self, pose: Pose, other: Pose, elapsed: float, limits: MotionLimits) -> bool:
        """Whether the robot can have come from one pose to the other in the time [s], but for noise."""
        elapsed = max(elapsed, 0.0)
        return (math.hypot(pose.x - other.x, pose.y - other.y) <= self._jump + limits.max_speed * elapsed
                and abs(wrap_angle(pose.yaw - other.yaw)) <= self._turn_jump + limits.max_turn_rate * elapsed)
