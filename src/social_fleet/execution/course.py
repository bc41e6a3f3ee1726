"""The way of one schedule and the reference on it: legs, stops, and where between them the reference is."""

import math
from typing import List

from social_fleet.coordination.schedule import Schedule
from social_fleet.execution.governor import Governor
from social_fleet.execution.itinerary import Stop, itinerary
from social_fleet.execution.reference_path import ReferencePath
from social_fleet.geometry import Pose, wrap_angle

_JOIN_ANGLE = 0.2  # a new path is joined on the move by a robot that points this well along it [rad]
_JOIN_REACH = 0.5  # how far along a new path it is joined on the move [m]
_AT_STOP = 1e-6  # [m]


class Course:
    """Where the reference is on the path of a schedule.

    Parameters
    ----------
    schedule : Schedule
        What is driven.
    moving : bool
        The reference will not start from standstill.

    Attributes
    ----------
    path : ReferencePath
        The driven curve.
    stops : list of Stop
        Start, turning points and goal.
    leg : int
        Index of the stop that was reached last.
    turning : bool
        Whether the robot is still to turn there.
    governor : Governor
        Moves the reference.
    reference : Pose
        Where the robot ought to be [m, rad].
    reference_speed : float
        Of the last period, along the driven curve [m/s].
    """

    def __init__(self, schedule: Schedule, *, moving: bool = False) -> None:
        self.path = ReferencePath(schedule.robot, moving=moving)
        self.stops: List[Stop] = itinerary(schedule.robot, self.path)
        self.leg = 0
        self.turning = True
        self.governor = Governor(schedule, self.path)
        self.reference = self.path.pose(0, 0.0)
        self.reference_speed = 0.0

    @property
    def next_stop(self) -> Stop:
        """The stop ahead; at the goal, that."""
        return self.stops[min(self.leg + 1, len(self.stops) - 1)]

    @property
    def last_stop(self) -> Stop:
        """The stop that was reached last."""
        return self.stops[self.leg]

    @property
    def at_goal(self) -> bool:
        """Whether the reference has come to the end of the path."""
        return self.leg == len(self.stops) - 1

    @property
    def driven_leg(self) -> int:
        """Number of the leg that the reference is on."""
        return min(self.leg, len(self.path.legs) - 1)

    @property
    def goal(self) -> Pose:
        """The end of the driven curve [m, rad]."""
        return self.path.pose(len(self.path.legs) - 1, self.path.length)

    def retime(self, schedule: Schedule) -> None:
        """Other times for the same path."""
        governor = Governor(schedule, self.path)
        governor.arc_length, governor.speed = self.governor.arc_length, self.governor.speed
        self.governor = governor

    def continue_from(self, old: "Course", origin: float) -> None:
        """Go on from where `old` is, whose arc length `origin` [m] this path begins at and runs along at first."""
        arc_length = min(max(old.governor.arc_length - origin, 0.0), self.path.length)
        self.leg = max(index for index, stop in enumerate(self.stops) if stop.arc_length <= arc_length + _AT_STOP)
        self.governor.arc_length, self.governor.speed = arc_length, old.governor.speed
        at_stop = arc_length <= self.last_stop.arc_length + _AT_STOP
        self.turning = at_stop and (old.turning or old.governor.speed == 0.0 or self.at_goal)
        self.reference, self.reference_speed = self.path.pose(self.driven_leg, arc_length), old.reference_speed

    def join(self, pose: Pose, speed: float, tolerance: float) -> None:
        """Begin on the move where the robot drives along the path's beginning already, within `tolerance` [m] of it."""
        arc_length = self.path.project(pose.x, pose.y, 0.0, min(self.next_stop.arc_length, _JOIN_REACH))
        nearest = self.path.pose(0, arc_length)
        if distance(nearest, pose) <= tolerance and abs(wrap_angle(nearest.yaw - pose.yaw)) <= _JOIN_ANGLE:
            self.governor.arc_length, self.governor.speed = arc_length, speed
            self.reference, self.reference_speed = nearest, speed
            self.turning = False

    def place(self, arc_length: float) -> None:
        """Let the reference stand at `arc_length` [m] on the present leg."""
        self.governor.arc_length, self.governor.speed = arc_length, 0.0
        self.reference, self.reference_speed = self.path.pose(self.driven_leg, arc_length), 0.0

    def advance(self, now: float, period: float, *, bound: float, patience: float) -> None:
        """Move the reference on by one period; see `Governor.advance`."""
        self.governor.advance(now, period, self.driven_leg, stop=self.next_stop.arc_length, bound=bound,
                              patience=patience)
        self._move_reference(period)

    def brake(self, period: float) -> None:
        """Let the reference brake as the robot can."""
        if not self.turning:
            self.governor.brake(period, self.next_stop.arc_length)
            self._move_reference(period)

    def _move_reference(self, period: float) -> None:
        """Bring the reference pose to where the governor is, and measure its speed on the rounded path."""
        old = self.reference
        self.reference = self.path.pose(self.driven_leg, self.governor.arc_length)
        self.reference_speed = distance(self.reference, old) / period


def distance(one: Pose, other: Pose) -> float:
    """Between two positions [m]."""
    return math.hypot(one.x - other.x, one.y - other.y)
