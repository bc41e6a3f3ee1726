"""What a tracker tells the fleet and its operators: progress, what it follows, what it waits for, and how it is."""

import math
from typing import Any, Optional, Tuple

import genpy
import rospy
from geometry_msgs.msg import Pose2D

from social_fleet.execution.state import ProgressState
from social_fleet.execution.tracker import Tracker
from social_fleet.geometry import Pose
from social_fleet.msg import Progress, Schedule, Waiting

_EARLY = 1e-3  # a report that is due within this [s] is sent: stamps are rounded
_QUIET = 0.5  # [s] between reports of a robot that has nothing new to tell
_NEWS = 0.05  # what is new: so much further on [m], or faster or slower [m/s]
_UNKNOWN = Pose(math.nan, math.nan, math.nan)


class TrackerReports:
    """Publishes what has changed, as often as it is worth it.

    Publishers
        fleet/progress, progress (Progress): the same; `progress` is for those who care for this robot alone.
        fleet/following (Schedule), latched: what the tracker has taken up.
        fleet/waiting (Waiting), latched.

    Parameters
    ----------
    robot, frame
        The robot's name and the map's frame.
    rate
        Of progress while there is news [Hz].
    radius
        Of the robot's disc while it has no schedule [m].
    """

    def __init__(self, robot: str, frame: str, *, rate: float, radius: float) -> None:
        self._robot, self._frame, self._rate, self._radius = robot, frame, rate, radius
        self._progress = [rospy.Publisher(topic, Progress, queue_size=10) for topic in ("fleet/progress", "progress")]
        self._following = rospy.Publisher("fleet/following", Schedule, latch=True, queue_size=1)
        self._waiting = rospy.Publisher("fleet/waiting", Waiting, latch=True, queue_size=10)
        self._last: Optional[Progress] = None
        self._wait: Tuple[Any, ...] = ()

    def follow(self, message: Schedule) -> None:
        """The tracker has taken up `message`: everybody is told at the next step."""
        self._following.publish(message)
        self._last = None

    def step(self, tracker: Tracker, stamp: genpy.Time, pose: Optional[Pose], reference: Optional[Pose]) -> None:
        """Report what is due.

        Parameters
        ----------
        tracker
            After its step.
        stamp
            Of the odometry that it answered.
        pose, reference
            Where the robot was then, and where it ought to have been; None when that is not known.
        """
        if self._last is None or tracker.state != self._last.state:
            self._log_change(tracker)
        if self._is_due(tracker, stamp):
            self._report(tracker, stamp, pose, reference)
        self._tell_waiting(tracker, stamp, pose or reference)

    def _is_due(self, tracker: Tracker, stamp: genpy.Time) -> bool:
        """At once on a change of state, otherwise by what has changed since the last report.

        Every robot hears every report: those of standing robots would be most of what a fleet has to say.
        """
        last = self._last
        if last is None or tracker.state != last.state:
            return True
        command = tracker.command
        stands = command.speed == 0.0 and command.turn_rate == 0.0
        moved = (abs(tracker.progress - last.arc_length) >= _NEWS or abs(command.speed - last.speed) >= _NEWS
                 or stands != (last.speed == 0.0 and last.turn_rate == 0.0))
        elapsed = (stamp.secs - last.header.stamp.secs) + 1e-9 * (stamp.nsecs - last.header.stamp.nsecs)
        return elapsed >= (1.0 / self._rate if moved else _QUIET) - _EARLY

    def _report(self, tracker: Tracker, stamp: genpy.Time, pose: Optional[Pose], reference: Optional[Pose]) -> None:
        message = Progress(robot=self._robot, radius=self._radius)
        message.header.stamp, message.header.frame_id = stamp, self._frame
        if tracker.schedule is not None:
            message.schedule_version, message.radius = tracker.schedule.version, tracker.schedule.robot.body_radius
        message.arc_length, message.speed, message.turn_rate = tracker.progress, *tracker.command
        message.state, message.tracking_error = int(tracker.state), tracker.tracking_error
        message.pose, message.reason = Pose2D(*(pose or _UNKNOWN)), tracker.reason
        if reference is not None:
            message.reference = Pose2D(*reference)
        for publisher in self._progress:
            publisher.publish(message)
        self._last = message

    def _tell_waiting(self, tracker: Tracker, stamp: genpy.Time, pose: Optional[Pose]) -> None:
        """When a wait begins and when it ends."""
        waiting = tracker.waiting_for
        wait = () if waiting is None else (waiting.other, waiting.at)
        if wait == self._wait:
            return
        self._wait = wait
        message = Waiting(robot=self._robot, waits=waiting is not None, pose=Pose2D(*(pose or _UNKNOWN)))
        message.header.stamp, message.header.frame_id = stamp, self._frame
        if waiting is not None:
            message.other, message.at, message.other_at = waiting.other, waiting.at, waiting.other_at
            message.reason = f"{waiting.other} has not passed {waiting.other_at:.1f} m of its path yet"
        self._waiting.publish(message)

    def _log_change(self, tracker: Tracker) -> None:
        """A line for what an operator wants to know of: waiting, stopping, arriving."""
        if tracker.state is ProgressState.HOLDING and tracker.waiting_for is not None:
            rospy.loginfo("%s: waits for %s at %.1f m", self._robot, tracker.waiting_for.other, tracker.progress)
        elif tracker.state is ProgressState.STOPPED:
            rospy.logwarn("%s: stopped at %.1f m: %s", self._robot, tracker.progress, tracker.reason)
        elif tracker.state is ProgressState.ARRIVED:
            rospy.loginfo("%s: arrived", self._robot)
