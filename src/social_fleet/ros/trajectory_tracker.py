"""The node trajectory_tracker, one per robot: drives it along its schedule."""

import math
import threading
from dataclasses import dataclass
from typing import Dict, Optional, Tuple

import genpy
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool

from social_fleet.errors import InvalidInput
from social_fleet.execution.config import TrackerConfig
from social_fleet.execution.gate import ReportedProgress
from social_fleet.execution.tracker import Tracker
from social_fleet.geometry import Pose, compose
from social_fleet.msg import Progress, Schedule
from social_fleet.parameters import from_mapping, parameter
from social_fleet.ros import conversions, parameters
from social_fleet.ros.frames import Frames
from social_fleet.ros.identity import robot_name
from social_fleet.ros.tracker_health import TrackerHealth
from social_fleet.ros.tracker_reports import TrackerReports


@dataclass(frozen=True)
class TrajectoryTrackerParameters:
    """Parameters of the node; all others in its namespace are those of `TrackerConfig`."""

    robot: str = ""  # the robot's name in schedules; empty: the last part of the node's namespace
    map_frame: str = "map"
    radius: float = parameter(0.25, above=0.0)  # of the robot's disc, told while it has no schedule [m]
    progress_rate: float = parameter(10.0, above=0.0)  # of fleet/progress while there is news [Hz]
    odom_timeout: float = parameter(0.5, above=0.0)  # without odometry for so long the robot stops [s]


class TrajectoryTracker:
    """Answers every odometry message with one command; stands still without schedule, pose or fresh odometry.

    Subscribers
        schedule (Schedule): those for other robots are passed over.
        odom (nav_msgs/Odometry), tf.
        fleet/progress (Progress): of the other robots.
        hold (std_msgs/Bool): stand where you are while it is true.
    Publishers
        cmd_vel (geometry_msgs/Twist); those of `TrackerReports`; /diagnostics.
    Parameters
        `TrajectoryTrackerParameters`; those of `TrackerConfig`, see config/tracker.yaml.
    """

    def __init__(self) -> None:
        self._config, others = parameters.split_private(TrajectoryTrackerParameters)
        config = from_mapping(TrackerConfig, others, prefix=parameters.private_prefix())
        self.robot = robot_name(self._config.robot)
        self._lock = threading.Lock()
        self._tracker = Tracker(config=config)
        self._time_zero = genpy.Time()
        self._followed: Optional[Schedule] = None
        self._others: Dict[str, Progress] = {}
        self._stopped = False
        self._held = False
        self._heard_odom: Optional[float] = None
        self._frames = Frames(self._config.map_frame)
        self._health = TrackerHealth(self.robot, self._tracker, config)
        self._cmd_vel = rospy.Publisher("cmd_vel", Twist, queue_size=1)
        self._reports = TrackerReports(self.robot, self._config.map_frame, rate=self._config.progress_rate,
                                       radius=self._config.radius)
        rospy.on_shutdown(self._stop)
        options = {"queue_size": 10, "tcp_nodelay": True}
        rospy.Subscriber("schedule", Schedule, self._hear_schedule, **options)
        rospy.Subscriber("fleet/progress", Progress, self._hear_progress, **options)
        rospy.Subscriber("hold", Bool, self._hear_hold, **options)
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
            self._reports.follow(message)
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
                self._others[message.robot] = message

    def _hear_hold(self, message: Bool) -> None:
        if message.data != self._held:
            self._held = message.data
            rospy.loginfo("%s: %s", self.robot, "holds" if self._held else "may go on")

    def _hear_odom(self, message: Odometry) -> None:
        with self._lock:
            self._heard_odom = rospy.get_time()
            self._health.tick()
            self._step(message.header.stamp, *self._pose(message))
        self._health.update()

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
        self._health.update()

    def _step(self, stamp: genpy.Time, pose: Optional[Pose], measured: Optional[genpy.Time] = None) -> None:
        """Command for the period that begins at `stamp`, and report when it is time to."""
        if self._stopped:
            return
        now = self._seconds(stamp)
        measured_at = None if measured is None else self._seconds(measured)
        reference = self._tracker.reference or pose  # of this moment: `step` moves it on
        command = self._tracker.step(now, pose, self._heard(), pose_stamp=measured_at,
                                     horizon=-math.inf if self._held else math.inf)
        self._cmd_vel.publish(conversions.twist_to_message(command.speed, command.turn_rate))
        self._reports.step(self._tracker, stamp, pose, reference)
        self._health.note(now, measured_at)

    def _heard(self) -> Dict[str, ReportedProgress]:
        """What the others reported last, on this schedule's clock."""
        return {name: ReportedProgress(news.schedule_version, news.arc_length, self._seconds(news.header.stamp))
                for name, news in self._others.items()}

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
