"""Messages of the exchange of schedules to core values and back; pure functions, as in conversions.py.

The core counts seconds from a moment that is each node's own: its `FleetClock`.
"""

import math
from dataclasses import dataclass
from typing import Dict, Iterable, List, Mapping, Optional, Sequence

import genpy
from geometry_msgs.msg import Pose2D
from social_fleet.msg import (Assignment as AssignmentMessage, Directive as DirectiveMessage, Errand as ErrandMessage,
                              Obstacle, Progress, RobotReport, Schedule as ScheduleMessage)
from std_msgs.msg import Header

from social_fleet.coordination.robot import MotionLimits
from social_fleet.coordination.schedule import Schedule
from social_fleet.errors import InvalidInput
from social_fleet.execution.gate import Waiting
from social_fleet.execution.recovery.messages import Assignment, Body, Directive, Errand, Report
from social_fleet.execution.state import ProgressState
from social_fleet.geometry import Pose
from social_fleet.planning.overlays.shapes import DiscObstacle
from social_fleet.ros.conversions import schedule_from_message, schedule_to_message

UNKNOWN = Pose2D(math.nan, math.nan, math.nan)
_LIMITS = ("max_speed", "max_acceleration", "max_turn_rate", "max_turn_acceleration")


@dataclass(frozen=True)
class FleetClock:
    """Seconds as floats for ROS times, and back.

    Parameters
    ----------
    origin : genpy.Time
        Zero of the seconds: near the times that are converted, for the sake of the last digits.
    """

    origin: genpy.Time

    def seconds(self, stamp: genpy.Time) -> float:
        """[s]."""
        return (stamp.secs - self.origin.secs) + 1e-9 * (stamp.nsecs - self.origin.nsecs)

    def stamp(self, seconds: float) -> genpy.Time:
        """The moment; what lies before ROS time zero is that."""
        nanoseconds = self.origin.to_nsec() + round(seconds * 1e9)
        return genpy.Time(*divmod(max(nanoseconds, 0), 10**9))


def pose_from_plane(message: Pose2D) -> Optional[Pose]:
    """None where the pose is not known."""
    pose = Pose(message.x, message.y, message.theta)
    return pose if all(map(math.isfinite, pose)) else None


def plane_from_pose(pose: Optional[Pose]) -> Pose2D:
    """Not a number where the pose is not known."""
    return UNKNOWN if pose is None else Pose2D(*pose)


def errand_to_message(errand: Optional[Errand], number: int = 0) -> ErrandMessage:
    """`number` is that of an order to stay."""
    if errand is None:
        return ErrandMessage(number=number, idle=True)
    x, y, yaw = (*errand.goal, 0.0)[:3]
    return ErrandMessage(errand.number, False, Pose2D(x, y, yaw), len(errand.goal) < 3)


def errand_from_message(message: ErrandMessage) -> Optional[Errand]:
    """None for a robot that is to stay; raises InvalidInput for a goal that is not finite."""
    if message.idle or message.number == 0:
        return None
    goal = (message.goal.x, message.goal.y, message.goal.theta)[:2 if message.any_heading else 3]
    if not all(map(math.isfinite, goal)):
        raise InvalidInput(f"the goal {goal} of errand {message.number} is not finite")
    return Errand(message.number, goal)


def schedule_to_absolute(schedule: Schedule, frame: str, clock: FleetClock) -> ScheduleMessage:
    """A schedule on the node's clock; the message's time zero is when it begins."""
    begin = float(schedule.times[0])
    return schedule_to_message(schedule.shifted(-begin), frame, clock.stamp(begin))


def schedule_from_absolute(message: ScheduleMessage, frame: str, clock: FleetClock) -> Schedule:
    """A schedule on the node's clock; raises InvalidInput or InvalidSchedule."""
    return schedule_from_message(message, frame).shifted(clock.seconds(message.header.stamp))


def report_to_message(report: Report, frame: str, clock: FleetClock) -> RobotReport:
    """All but the schedule, which fleet/following has."""
    message = RobotReport(
        header=Header(stamp=clock.stamp(report.stamp), frame_id=frame), robot=report.name, session=report.session,
        radius=report.body.radius, weight=report.body.weight, schedule_version=report.version,
        arc_length=report.arc_length, speed=report.speed, state=int(report.state), pose=plane_from_pose(report.pose),
        exchange=report.exchange, bound=report.bound, lapsed=report.lapsed, astray=report.astray,
        errand=errand_to_message(report.errand), serving=report.serving, unserved=report.unserved, final=report.final,
        obstacles=obstacles_to_messages(report.obstacles),
        cleared=list(report.cleared), blocked=report.blocked)
    for name in _LIMITS:
        setattr(message, name, getattr(report.body.limits, name))
    if report.waiting_for is not None:
        waiting = report.waiting_for
        message.waits_for, message.waits_at, message.waits_until = waiting.other, waiting.at, waiting.other_at
        message.waits_since = clock.stamp(waiting.since)
    return message


def report_from_message(message: RobotReport, clock: FleetClock, schedule: Optional[Schedule] = None) -> Report:
    """With `schedule` where the receiver wants to know it; raises InvalidInput for what cannot be."""
    if not message.robot or message.session == 0:
        raise InvalidInput("a report without a robot's name or session")
    try:
        body = Body(message.radius, MotionLimits(*(getattr(message, name) for name in _LIMITS)), message.weight)
        state = ProgressState(message.state)
    except ValueError as error:  # InvalidScenario is one, too
        raise InvalidInput(f"the report of {message.robot}: {error}") from error
    waiting = Waiting(message.waits_for, message.waits_at, message.waits_until, clock.seconds(message.waits_since))
    return Report(
        message.robot, message.session, clock.seconds(message.header.stamp), body, message.schedule_version,
        message.arc_length, message.speed, state, pose_from_plane(message.pose), message.exchange, message.bound,
        message.lapsed, message.astray, errand_from_message(message.errand), message.serving, message.unserved,
        message.final, obstacles_from_messages(message.obstacles), tuple(message.cleared), message.blocked,
        waiting if message.waits_for else None, schedule)


def report_from_progress(message: Progress, clock: FleetClock) -> Report:
    """The part of a report that other robots need: for their gates, and to tell it from an obstacle."""
    pose = pose_from_plane(message.pose) if message.header.frame_id else None
    return Report(message.robot, message.session, clock.seconds(message.header.stamp),
                  Body(message.radius or Body.radius), message.schedule_version, message.arc_length, message.speed,
                  pose=pose)


def directive_to_message(directive: Directive, frame: str, clock: FleetClock) -> DirectiveMessage:
    """All of it."""
    names = sorted(directive.heard)
    return DirectiveMessage(
        header=Header(stamp=clock.stamp(directive.stamp), frame_id=frame), robots=names,
        heard=[clock.stamp(directive.heard[name]) for name in names], exchange=directive.exchange,
        assignments=[assignment_to_message(directive.assignments[name], frame, clock)
                     for name in sorted(directive.assignments)],
        obstacles=obstacles_to_messages(directive.obstacles), missing=list(directive.missing))


def directive_from_message(message: DirectiveMessage, frame: str, clock: FleetClock,
                           only: str = "") -> Directive:
    """With the assignment of the robot `only`, or with all; raises InvalidInput."""
    if len(message.robots) != len(message.heard):
        raise InvalidInput("a directive's robots and stamps must be as many")
    return Directive(clock.seconds(message.header.stamp),
                     {name: clock.seconds(stamp) for name, stamp in zip(message.robots, message.heard)},
                     message.exchange, assignments_from_messages(message.assignments, frame, clock, only),
                     obstacles_from_messages(message.obstacles), tuple(message.missing))


def assignment_to_message(assignment: Assignment, frame: str, clock: FleetClock) -> AssignmentMessage:
    """Its schedule with absolute time."""
    return AssignmentMessage(assignment.session, schedule_to_absolute(assignment.schedule, frame, clock),
                             assignment.origin, assignment.errand, assignment.reason, assignment.final,
                             assignment.temporary)


def assignments_from_messages(messages: Iterable[AssignmentMessage], frame: str, clock: FleetClock,
                              only: str = "") -> Dict[str, Assignment]:
    """By robot; those of others than `only` are passed over."""
    return {message.schedule.robot: Assignment(
        message.session, schedule_from_absolute(message.schedule, frame, clock), message.origin, message.errand,
        message.reason, message.final, message.temporary)
        for message in messages if not only or message.schedule.robot == only}


def obstacles_to_messages(obstacles: Mapping[str, DiscObstacle]) -> List[Obstacle]:
    """Sorted by name."""
    return [Obstacle(name, shape.x, shape.y, shape.radius) for name, shape in sorted(obstacles.items())]


def obstacles_from_messages(messages: Sequence[Obstacle]) -> Dict[str, DiscObstacle]:
    """By name; raises InvalidOverlay for what is no disc."""
    return {message.name: DiscObstacle(message.x, message.y, message.radius) for message in messages}
