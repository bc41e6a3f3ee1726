"""The node trajectory_tracker, one per robot: drives it along its schedule."""

import threading
from dataclasses import dataclass
from typing import Dict, Optional, Tuple

import genpy
import rospy
from geometry_msgs.msg import Pose2D, Twist
from nav_msgs.msg import Odometry

from social_fleet.errors import InvalidInput
from social_fleet.execution.config import TrackerConfig
from social_fleet.execution.gate import ReportedProgress
from social_fleet.execution.state import ProgressState
from social_fleet.execution.tracker import Tracker
from social_fleet.geometry import Pose, compose
from social_fleet.msg import Progress, Schedule
from social_fleet.parameters import from_mapping, parameter
from social_fleet.ros import conversions, parameters
from social_fleet.ros.frames import Frames

_EARLY = 1e-3  # a report that is due within this [s] is sent: stamps are rounded
_QUIET = 0.5  # [s] between reports of a robot that has nothing new to tell
_NEWS = 0.05  # what is new: so much further on [m], or faster or slower [m/s]


@dataclass(frozen=True)
class TrajectoryTrackerParameters:
    """Parameters of the node; all others in its namespace are those of `TrackerConfig`."""

    robot: str = ""  # the robot's name in schedules; empty: the last part of the node's namespace
    map_frame: str = "map"
    progress_rate: float = parameter(10.0, above=0.0)  # of fleet/progress while there is news [Hz]
    odom_timeout: float = parameter(0.5, above=0.0)  # without odometry for so long the robot stops [s]


class TrajectoryTracker:
    """Answers every odometry message with one command; stands still without schedule, pose or fresh odometry.

    Subscribers
        schedule (Schedule): those for other robots are passed over.
        odom (nav_msgs/Odometry), tf.
        fleet/progress (Progress): of the other robots.
    Publishers
        cmd_vel (geometry_msgs/Twist), fleet/progress (Progress).
    Parameters
        `TrajectoryTrackerParameters`; those of `TrackerConfig`, see config/tracker.yaml.
    """

    def __init__(self) -> None:
        self._config, others = parameters.split_private(TrajectoryTrackerParameters)
        config = from_mapping(TrackerConfig, others, prefix=parameters.private_prefix())
        self.robot = self._config.robot or rospy.get_namespace().strip("/").split("/")[-1]
        if not self.robot:
            raise InvalidInput("is empty and the node has no namespace; give the robot's name",
                               field=f"{parameters.private_prefix()}robot")
        self._lock = threading.Lock()
        self._tracker = Tracker(config=config)
        self._time_zero = genpy.Time()
        self._followed: Optional[Schedule] = None
        self._others: Dict[str, ReportedProgress] = {}
        self._stopped = False
        self._heard_odom: Optional[float] = None
        self._reported: Optional[Progress] = None
        self._frames = Frames(self._config.map_frame)
        self._cmd_vel = rospy.Publisher("cmd_vel", Twist, queue_size=1)
        self._progress = rospy.Publisher("fleet/progress", Progress, queue_size=10)
        rospy.on_shutdown(self._stop)
        options = {"queue_size": 10, "tcp_nodelay": True}
        rospy.Subscriber("schedule", Schedule, self._hear_schedule, **options)
        rospy.Subscriber("fleet/progress", Progress, self._hear_progress, **options)
        rospy.Subscriber("odom", Odometry, self._hear_odom, **options)
        rospy.Timer(rospy.Duration(0.5 * self._config.odom_timeout), self._watch)

    def _hear_schedule(self, message: Schedule) -> None:
        """Take up a schedule of this robot: a newer one, or other precedences of the same one."""
        if message.robot != self.robot:
            return
        try:
            schedule = conversions.schedule_from_message(message, self._config.map_frame)
        except InvalidInput as error:
            rospy.logerr("the schedule was not taken up: %s", error)
            return
        with self._lock:
            if self._followed is not None and not self._supersedes(message, self._followed):
                return
            self._followed = message
            self._time_zero = message.header.stamp
            self._tracker.follow(schedule)
            self._reported = None
        rospy.loginfo("%s: took up schedule %d, %.1f m in %.1f s, %d precedences", self.robot, schedule.version,
                      schedule.robot.path.length, schedule.arrival_time, len(schedule.precedences))

    def _supersedes(self, new: Schedule, old: Schedule) -> bool:
        """Whether `new` has anything to say to a robot that follows `old`; what cannot be right is logged."""
        if new.version > old.version:
            return True
        if new.version < old.version:
            rospy.logwarn("%s: schedule %d came after schedule %d and is not taken up", self.robot, new.version,
                          old.version)
            return False
        if _motion(new) != _motion(old):
            rospy.logerr("%s: another motion has the version %d of the present one and is not taken up", self.robot,
                         new.version)
            return False
        return new.precedences != old.precedences

    def _hear_progress(self, message: Progress) -> None:
        if message.robot != self.robot:
            with self._lock:
                self._others[message.robot] = ReportedProgress(message.schedule_version, message.arc_length,
                                                               self._seconds(message.header.stamp))

    def _hear_odom(self, message: Odometry) -> None:
        with self._lock:
            self._heard_odom = rospy.get_time()
            self._step(message.header.stamp, *self._pose(message))

    def _pose(self, odom: Odometry) -> Tuple[Optional[Pose], Optional[genpy.Time]]:
        """The pose in the map: where odometry is there, and the robot in it; None when either is unknown.

        With it the time that it is from: the older one of both.
        """
        try:
            frame, stamp = self._frames.stamped_pose_of(conversions.frame_name(odom.header.frame_id))
            pose = compose(frame, conversions.pose_from_message(odom.pose.pose, "odometry"))
        except InvalidInput as error:
            if self._tracker.schedule is not None:
                rospy.logwarn_throttle(10.0, "%s: no pose: %s" % (self.robot, error))
            return None, None
        return pose, odom.header.stamp if stamp is None else min(stamp, odom.header.stamp)

    def _watch(self, _event: rospy.timer.TimerEvent) -> None:
        """Brake when odometry has ceased to come, whatever its stamps say."""
        now = rospy.Time.now()
        with self._lock:
            if self._heard_odom is not None and now.to_sec() - self._heard_odom > self._config.odom_timeout:
                rospy.logwarn_throttle(10.0, "%s: no odometry for %.1f s" % (
                    self.robot, now.to_sec() - self._heard_odom))
                self._step(now, None)

    def _step(self, stamp: genpy.Time, pose: Optional[Pose], measured: Optional[genpy.Time] = None) -> None:
        """Command for the period that begins at `stamp`, and report when it is time to."""
        if self._stopped:
            return
        now = self._seconds(stamp)
        reference = self._tracker.reference or pose  # of this moment: `step` moves it on
        command = self._tracker.step(now, pose, self._others,
                                     pose_stamp=None if measured is None else self._seconds(measured))
        self._cmd_vel.publish(conversions.twist_to_message(command.speed, command.turn_rate))
        if self._reported is None or self._tracker.state != self._reported.state:
            self._log_change()
        if self._has_news(stamp):
            self._report(stamp, reference)

    def _has_news(self, stamp: genpy.Time) -> bool:
        """Whether a report is due: at once on a change of state, otherwise by what has changed since the last one.

        Every robot hears every report: those of standing robots would be most of what a fleet has to say.
        """
        tracker, last = self._tracker, self._reported
        if last is None or tracker.state != last.state:
            return True
        moved = (abs(tracker.progress - last.arc_length) >= _NEWS or abs(tracker.command.speed - last.speed) >= _NEWS)
        elapsed = self._seconds(stamp) - self._seconds(last.header.stamp)
        return elapsed >= (1.0 / self._config.progress_rate if moved else _QUIET) - _EARLY

    def _report(self, stamp: genpy.Time, reference: Optional[Pose]) -> None:
        tracker, message = self._tracker, Progress(robot=self.robot)
        message.header.stamp, message.header.frame_id = stamp, self._config.map_frame
        message.schedule_version = 0 if tracker.schedule is None else tracker.schedule.version
        message.arc_length, message.speed = tracker.progress, tracker.command.speed
        message.state, message.tracking_error = int(tracker.state), tracker.tracking_error
        if reference is not None:
            message.reference = Pose2D(*reference)
        self._progress.publish(message)
        self._reported = message

    def _log_change(self) -> None:
        """A line for what an operator wants to know of: waiting, stopping, arriving."""
        tracker = self._tracker
        if tracker.state is ProgressState.HOLDING and tracker.waiting_for is not None:
            rospy.loginfo("%s: waits for %s at %.1f m", self.robot, tracker.waiting_for.other, tracker.progress)
        elif tracker.state is ProgressState.STOPPED:
            rospy.logwarn("%s: stopped at %.1f m: %s", self.robot, tracker.progress, tracker.reason)
        elif tracker.state is ProgressState.ARRIVED:
            rospy.loginfo("%s: arrived", self.robot)

    def _seconds(self, stamp: genpy.Time) -> float:
        """`stamp` on the schedule's clock; in two steps, for the sake of the last digits."""
        return (stamp.secs - self._time_zero.secs) + 1e-9 * (stamp.nsecs - self._time_zero.nsecs)

    def _stop(self) -> None:
        """Leave the robot standing, and its topics to rospy, which closes them next."""
        with self._lock:
            self._stopped = True
            self._cmd_vel.publish(Twist())


def _motion(message: Schedule) -> Tuple:
    """What two schedules of one version have to share."""
    return message.header.stamp, message.path.poses, message.arc_lengths, message.times
