"""The driven curve as the tracker looks it up at every step: plain floats, no array calls."""

import math
from bisect import bisect_right
from typing import List, NamedTuple, Tuple

from social_fleet.coordination.driven_path import DrivenLeg, driven_legs
from social_fleet.coordination.robot import MotionLimits, Robot
from social_fleet.coordination.timing import turning_points
from social_fleet.geometry import Pose

# What the reference may use of the limits: more than the schedule, to catch up, and less than all, to correct errors.
_SPEED_SHARE = 0.99
_ACCELERATION_SHARE = 0.85
_TURN_SHARE = 0.9


class Leg(NamedTuple):
    """The way between two stops, in even samples."""

    start: float  # arc length [m]
    step: float  # [m]
    xs: List[float]  # [m]
    ys: List[float]
    headings: List[float]  # without jumps [rad]
    squares: List[float]  # of the highest speed [m^2/s^2]


class ReferencePath:
    """A robot's driven curve, addressed by the arc length of the planned polyline.

    Parameters
    ----------
    robot : Robot
        Its path and limits.
    moving : bool
        The robot is under way when it takes up this path: its start does not bound the speed.

    Attributes
    ----------
    length : float
        Of the polyline [m].
    legs : list of Leg
        One between every two stops; one without extent when the path is a point.
    """

    def __init__(self, robot: Robot, *, moving: bool = False) -> None:
        path, limits = robot.path, robot.limits
        self.length = path.length
        self._points: List[Tuple[float, float]] = [(float(x), float(y)) for x, y in path.points]
        self._arcs: List[float] = path.arc_lengths.tolist()
        self._directions = [(math.cos(heading), math.sin(heading)) for heading in path.segment_headings.tolist()]
        usable = MotionLimits(_SPEED_SHARE * limits.max_speed, _ACCELERATION_SHARE * limits.max_acceleration,
                              _TURN_SHARE * limits.max_turn_rate, _TURN_SHARE * limits.max_turn_acceleration)
        self.legs = [_listed(leg, usable, moving and number == 0)
                     for number, leg in enumerate(driven_legs(path, turning_points(path)[0].tolist()))]

    def pose(self, leg: int, arc_length: float) -> Pose:
        """Position and direction of travel at `arc_length` [m], which must lie on leg number `leg`."""
        start, step, xs, ys, headings, _ = self.legs[leg]
        place = (arc_length - start) / step
        index = min(max(int(place), 0), len(xs) - 2)
        share = place - index
        return Pose(xs[index] + share * (xs[index + 1] - xs[index]), ys[index] + share * (ys[index + 1] - ys[index]),
                    headings[index] + share * (headings[index + 1] - headings[index]))

    def speed(self, leg: int, arc_length: float) -> float:
        """The highest speed [m/s] at `arc_length` [m], clamped to leg number `leg`."""
        start, step, _, _, _, squares = self.legs[leg]
        place = (arc_length - start) / step
        index = min(max(int(place), 0), len(squares) - 2)
        share = min(max(place - index, 0.0), 1.0)
        return math.sqrt(squares[index] + share * (squares[index + 1] - squares[index]))

    def project(self, x: float, y: float, low: float, high: float) -> float:
        """Arc length within [low, high] whose point on the polyline is nearest to (x, y); the first of equals."""
        best, nearest = low, math.inf
        index = max(bisect_right(self._arcs, low) - 1, 0)
        while index < len(self._directions) and (self._arcs[index] < high or nearest == math.inf):
            start = self._arcs[index]
            corner_x, corner_y = self._points[index]
            cos, sin = self._directions[index]
            dx, dy = x - corner_x, y - corner_y
            along = min(max(cos * dx + sin * dy, low - start, 0.0), self._arcs[index + 1] - start, high - start)
            gap = (dx - cos * along) ** 2 + (dy - sin * along) ** 2
            if gap < nearest:
                best, nearest = start + along, gap
            index += 1
        return best


def _listed(leg: DrivenLeg, limits: MotionLimits, moving: bool) -> Leg:
    squares = leg.permitted_speeds(limits, moving=moving) ** 2
    return Leg(float(leg.arc_lengths[0]), leg.step, leg.points[:, 0].tolist(), leg.points[:, 1].tolist(),
               leg.headings.tolist(), squares.tolist())
