"""Where a robot stands on its way, and how it turns and creeps there."""

import math
from typing import List, NamedTuple, Optional

from social_fleet.coordination.robot import MotionLimits, Robot
from social_fleet.coordination.timing import TURN_SHARE
from social_fleet.execution.braking import approach, stopping_speed
from social_fleet.execution.reference_path import ReferencePath
from social_fleet.execution.state import Command
from social_fleet.geometry import Pose, wrap_angle

ALIGNED = 0.02  # a turn in place ends this close to its target [rad]
_TURN_SHARE = 1.1 * TURN_SHARE  # of the turn limits, a little more than scheduled
_CREEP = 0.15  # [m/s]


class Stop(NamedTuple):
    """Where a robot stands, and what it turns to there."""

    arc_length: float  # [m]
    heading: Optional[float]  # [rad, map frame]; None where any will do


def itinerary(robot: Robot, path: ReferencePath) -> List[Stop]:
    """The stops of a robot: its start, the vertices that it turns at in place, its goal; of one that stays, that."""
    departures = [Stop(leg.start, leg.headings[0]) for leg in path.legs] if path.length > 0.0 else []
    return [*departures, Stop(path.length, robot.goal_yaw)]


class Manoeuvres:
    """Turns in place with a trapezoidal turn rate, and straight corrections of a few centimetres.

    Parameters
    ----------
    limits : MotionLimits
        Of the robot.
    """

    def __init__(self, limits: MotionLimits) -> None:
        self._limits = limits
        self._rate = _TURN_SHARE * limits.max_turn_rate
        self._acceleration = _TURN_SHARE * limits.max_turn_acceleration

    def turn(self, heading: float, pose: Pose, turn_rate: float, period: float) -> float:
        """The next turn rate [rad/s] on the way to `heading` [rad], after `turn_rate`."""
        angle = wrap_angle(heading - pose.yaw)
        rate = min(stopping_speed(abs(angle), self._acceleration, period), self._rate)
        return approach(turn_rate, math.copysign(rate, angle), self._acceleration * period)

    def turned(self, heading: float, pose: Pose, turn_rate: float, period: float) -> bool:
        """Whether a turn to `heading` is over: there, and slow enough to stand still at once."""
        return (abs(wrap_angle(heading - pose.yaw)) <= ALIGNED
                and abs(turn_rate) <= self._limits.max_turn_acceleration * period)

    def creep(self, target: Pose, pose: Pose, turn_rate: float, period: float) -> Command:
        """Point at the position of `target`, then go there slowly."""
        bearing = math.atan2(target.y - pose.y, target.x - pose.x)
        turn_rate = self.turn(bearing, pose, turn_rate, period)
        if abs(wrap_angle(bearing - pose.yaw)) > 10.0 * ALIGNED:
            return Command(0.0, turn_rate)
        distance = math.hypot(target.x - pose.x, target.y - pose.y)
        return Command(min(_CREEP, stopping_speed(distance, 0.5 * self._limits.max_acceleration, period)), turn_rate)
