"""What a tracker tells the fleet and its operators: progress, reports, what it follows, and what it waits for."""

import math
from typing import Any, Optional, Tuple

import genpy
import rospy
from geometry_msgs.msg import Pose2D

from social_fleet.execution.recovery.member import Member
from social_fleet.execution.recovery.messages import Report
from social_fleet.execution.state import STANDSTILL, ProgressState
from social_fleet.geometry import Pose
from social_fleet.msg import Progress, RobotReport, Schedule, Waiting
from social_fleet.ros.exchange_conversions import FleetClock, plane_from_pose, report_to_message

_EARLY = 1e-3  # a report that is due within this [s] is sent: stamps are rounded
_QUIET = 0.5  # [s] between reports of a robot that has nothing new to tell
_MOVING = 0.2  # [s] between those of one that moves to who makes schedules
_NEWS = 0.05  # what is new: so much further on [m], or faster or slower [m/s]


class TrackerReports:
    """Publishes what has changed, as often as it is worth it.

    Publishers
        fleet/progress (Progress): for the other robots' gates.
        fleet/reports, report (RobotReport): the same; `report` is for those who care for this robot alone.
        fleet/following (Schedule), latched: what the tracker has taken up.
        fleet/waiting (Waiting), latched.

    Parameters
    ----------
    member
        Whose tracker it is.
    frame, clock
        The map's frame, and the member's clock.
    rate
        Of progress while there is news [Hz].
    """

    def __init__(self, member: Member, frame: str, clock: FleetClock, *, rate: float) -> None:
        self._member, self._tracker, self._robot = member, member.tracker, member.name
        self._frame, self._clock, self._rate = frame, clock, rate
        self._progress = rospy.Publisher("fleet/progress", Progress, queue_size=10)
        self._reports = [rospy.Publisher(topic, RobotReport, queue_size=10) for topic in ("fleet/reports", "report")]
        self._following = rospy.Publisher("fleet/following", Schedule, latch=True, queue_size=1)
        self._waiting = rospy.Publisher("fleet/waiting", Waiting, latch=True, queue_size=10)
        self._last: Optional[Progress] = None
        self._reported: Optional[genpy.Time] = None
        self._key: Tuple[Any, ...] = ()
        self._wait: Tuple[Any, ...] = ()

    def follow(self, message: Schedule) -> None:
        """The tracker has taken up `message`: everybody is told at the next step."""
        self._following.publish(message)
        self._last = self._reported = None

    def relay(self, report: Report) -> None:
        """Pass on what was last heard of another robot, for a coordinator that has never heard of it."""
        message = report_to_message(report, self._frame, self._clock)
        message.relayed = True
        self._reports[0].publish(message)

    def step(self, stamp: genpy.Time, pose: Optional[Pose], reference: Optional[Pose], obstructed: str) -> None:
        """Report what is due, after the tracker's step.

        Parameters
        ----------
        stamp
            Of the odometry that it answered.
        pose, reference
            Where the robot was then, and where it ought to have been; None when that is not known.
        obstructed
            What stands in its way, as a sentence; empty when nothing does.
        """
        state = self._tracker.state
        if self._last is None or state != self._last.state:
            self._log_change()
        if self._is_due(stamp):
            self._tell_progress(stamp, pose, reference)
        self._tell_report(stamp)
        self._tell_waiting(stamp, pose or reference, obstructed)

    def _is_due(self, stamp: genpy.Time) -> bool:
        """At once on a change of state, otherwise by what has changed since the last report.

        Every robot hears every report: those of standing robots would be most of what a fleet has to say.
        """
        tracker, last = self._tracker, self._last
        if last is None or tracker.state != last.state:
            return True
        moved = abs(tracker.progress - last.arc_length) >= _NEWS or abs(tracker.command.speed - last.speed) >= _NEWS
        return _elapsed(last.header.stamp, stamp) >= (1.0 / self._rate if moved else _QUIET) - _EARLY

    def _tell_progress(self, stamp: genpy.Time, pose: Optional[Pose], reference: Optional[Pose]) -> None:
        tracker = self._tracker
        message = Progress(robot=self._robot, session=self._member.session, radius=self._member.body.radius,
                           schedule_version=self._member.version, arc_length=tracker.progress, state=int(tracker.state),
                           tracking_error=tracker.tracking_error, reason=tracker.reason, pose=plane_from_pose(pose))
        message.header.stamp, message.header.frame_id = stamp, self._frame
        message.speed, message.turn_rate = tracker.command
        if reference is not None:
            message.reference = Pose2D(*reference)
        self._progress.publish(message)
        self._last = message

    def _tell_report(self, stamp: genpy.Time) -> None:
        """At once what others wait for, the rest several times a second."""
        member, given = self._member, self._member.assignment
        errand = 0 if member.errand is None else member.errand.number
        key = (member.version, member.exchange, member.tracker.state, errand, member.astray, member.lapsed,
               member.cleared, tuple(member.obstacles))
        period = _QUIET if self._tracker.command == STANDSTILL else _MOVING
        if key == self._key and self._reported is not None and _elapsed(self._reported, stamp) < period - _EARLY:
            return
        self._key, self._reported = key, stamp
        message = report_to_message(member.report(self._clock.seconds(stamp)), self._frame, self._clock)
        message.turn_rate, message.trouble = self._tracker.command.turn_rate, self._tracker.reason
        if given is not None:
            message.temporary = given.temporary
        elif errand == member.version:
            message.serving = errand  # a schedule that came by itself leads where it leads
        for publisher in self._reports:
            publisher.publish(message)

    def _tell_waiting(self, stamp: genpy.Time, pose: Optional[Pose], obstructed: str) -> None:
        """When a wait begins and when it ends."""
        tracker, waiting = self._tracker, self._tracker.waiting_for
        wait: Tuple[Any, ...] = ()
        if waiting is not None:
            wait = waiting.other, waiting.at
        elif obstructed and tracker.command == STANDSTILL and not tracker.arrived:
            wait = ("",)
        if wait == self._wait:
            return
        self._wait = wait
        message = Waiting(robot=self._robot, waits=bool(wait), pose=plane_from_pose(pose), at=tracker.progress,
                          other_at=math.nan)
        message.header.stamp, message.header.frame_id = stamp, self._frame
        if waiting is not None:
            message.other, message.at, message.other_at = waiting.other, waiting.at, waiting.other_at
            message.reason = f"{waiting.other} has not passed {waiting.other_at:.1f} m of its path yet"
        elif wait:
            message.reason = obstructed
            rospy.loginfo("%s: stands at %.1f m: %s", self._robot, tracker.progress, obstructed)
        self._waiting.publish(message)

    def _log_change(self) -> None:
        """A line for what an operator wants to know of: waiting, stopping, arriving."""
        tracker = self._tracker
        if tracker.state is ProgressState.HOLDING and tracker.waiting_for is not None:
            rospy.loginfo("%s: waits for %s at %.1f m", self._robot, tracker.waiting_for.other, tracker.progress)
        elif tracker.state is ProgressState.STOPPED:
            rospy.logwarn("%s: stopped at %.1f m: %s", self._robot, tracker.progress, tracker.reason)
        elif tracker.state is ProgressState.ARRIVED:
            rospy.loginfo("%s: arrived", self._robot)


def _elapsed(since: genpy.Time, stamp: genpy.Time) -> float:
    """Between two times [s]; for ever when time has gone back, as where clocks start anew."""
    elapsed = (stamp.secs - since.secs) + 1e-9 * (stamp.nsecs - since.nsecs)
    return elapsed if elapsed >= 0.0 else math.inf
