"""The node trajectory_tracker, one per robot: drives it along its schedule, and holds to what it promises the fleet."""

import math
import threading
import time
from dataclasses import dataclass
from typing import Optional, Tuple

import genpy
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

from social_fleet.coordination.robot import MotionLimits
from social_fleet.errors import InvalidInput
from social_fleet.execution.config import TrackerConfig
from social_fleet.execution.recovery.config import RecoveryConfig
from social_fleet.execution.recovery.member import Member
from social_fleet.execution.recovery.messages import Body, Errand
from social_fleet.execution.tracker import Tracker
from social_fleet.geometry import Pose, compose
from social_fleet.msg import Directive, Errand as ErrandMessage, Progress, Schedule
from social_fleet.parameters import from_mapping, parameter
from social_fleet.ros import conversions, exchange_conversions as exchange, parameters
from social_fleet.ros.eyes import Eyes, EyesParameters
from social_fleet.ros.frames import Frames
from social_fleet.ros.identity import robot_name
from social_fleet.ros.tracker_health import TrackerHealth
from social_fleet.ros.tracker_reports import TrackerReports


@dataclass(frozen=True)
class TrajectoryTrackerParameters:
    """Parameters of the node; all others in its namespace are those of `TrackerConfig`, `recovery` and `lidar`."""

    robot: str = ""  # the robot's name in schedules; empty: the last part of the node's namespace
    map_frame: str = "map"
    radius: float = parameter(0.25, above=0.0)  # of the robot's disc [m]
    max_speed: float = parameter(MotionLimits.max_speed, above=0.0)  # [m/s]
    max_acceleration: float = parameter(MotionLimits.max_acceleration, above=0.0)  # [m/s^2]
    max_turn_rate: float = parameter(MotionLimits.max_turn_rate, above=0.0)  # [rad/s]
    max_turn_acceleration: float = parameter(MotionLimits.max_turn_acceleration, above=0.0)  # [rad/s^2]
    weight: float = parameter(1.0, above=0.0)  # what a second of its delay costs, against 1 for others
    progress_rate: float = parameter(10.0, above=0.0)  # of fleet/progress while there is news [Hz]
    odom_timeout: float = parameter(0.5, above=0.0)  # without odometry for so long the robot stops [s]


class TrajectoryTracker:
    """Answers every odometry message with one command; stands still without schedule, pose or fresh odometry.

    Until the coordinator has sent its first directive, the robot follows schedules as they come; from then on those
    that are made from its promises, see doc/execution.md.

    Subscribers
        schedule (Schedule), fleet/directives (Directive): what is for other robots is passed over.
        errand (Errand): of the robot's navigator.
        odom (nav_msgs/Odometry), tf; scan (sensor_msgs/LaserScan), map (nav_msgs/OccupancyGrid), see `Eyes`.
        fleet/progress (Progress): of the other robots.
    Publishers
        cmd_vel (geometry_msgs/Twist); those of `TrackerReports`; /diagnostics.
    Parameters
        `TrajectoryTrackerParameters`; those of `TrackerConfig`, see config/tracker.yaml; `recovery`, a mapping of those
        of `RecoveryConfig`, see config/recovery.yaml; `lidar`, a mapping of those of `EyesParameters`.
    """

    def __init__(self) -> None:
        self._config, others = parameters.split_private(TrajectoryTrackerParameters)
        prefix = parameters.private_prefix()
        recovery = RecoveryConfig.from_mapping(others.pop("recovery", {}), prefix=f"{prefix}recovery/")
        eyes = from_mapping(EyesParameters, others.pop("lidar", {}), prefix=f"{prefix}lidar/")
        config = from_mapping(TrackerConfig, others, prefix=prefix)
        self.robot, frame = robot_name(self._config.robot), self._config.map_frame
        self._lock = threading.Lock()
        self._tracker = Tracker(config=config)
        self._member = Member(self.robot, _body(self._config), self._tracker, session=int(1e3 * time.time()),
                              config=recovery)
        self._clock = exchange.FleetClock(rospy.Time.now())
        self._directed = False  # whether the coordinator has ever sent a directive
        self._errand = 0  # number of the latest errand message
        self._followed: Optional[Schedule] = None
        self._base = ""  # the robot's frame, as odometry names it
        self._stopped = False
        self._heard_odom: Optional[float] = None
        self._frames = Frames(frame)
        self._eyes = Eyes(f"{self.robot}/{self._member.session}", self._config.radius, self._clock, self._frames, eyes)
        self._health = TrackerHealth(self.robot, self._tracker, config)
        self._cmd_vel = rospy.Publisher("cmd_vel", Twist, queue_size=1)
        self._reports = TrackerReports(self._member, frame, self._clock, rate=self._config.progress_rate)
        rospy.on_shutdown(self._stop)
        options = {"queue_size": 10, "tcp_nodelay": True}
        rospy.Subscriber("schedule", Schedule, self._hear_schedule, **options)
        rospy.Subscriber("fleet/directives", Directive, self._hear_directive, **options)
        rospy.Subscriber("errand", ErrandMessage, self._hear_errand, **options)
        rospy.Subscriber("fleet/progress", Progress, self._hear_progress, **options)
        rospy.Subscriber("odom", Odometry, self._hear_odom, **options)
        rospy.Timer(rospy.Duration(0.5 * self._config.odom_timeout), self._watch)

    def _hear_schedule(self, message: Schedule) -> None:
        """Take up a schedule of this robot: a newer one, or other precedences of the same one.

        Those of robots under way answer promises, and come by directive alone.
        """
        if message.robot != self.robot or message.under_way:
            return
        try:
            schedule = exchange.schedule_from_absolute(message, self._config.map_frame, self._clock)
        except InvalidInput as error:
            rospy.logerr("the schedule was not taken up: %s", error)
            return
        with self._lock:
            if self._directed or (self._followed is not None and not self._supersedes(message, self._followed)):
                return
            self._tracker.follow(schedule)
            if self._followed is None or message.version > self._followed.version:
                self._member.bound = math.inf  # that of an errand taken back ended with its path
            goal = schedule.robot.goal
            self._member.errand = Errand(schedule.version, tuple(goal))
            self._take_up(message)

    def _take_up(self, message: Schedule) -> None:
        """Note, tell and log that the robot follows `message`."""
        self._followed = message
        self._reports.follow(message)
        rospy.loginfo("%s: took up schedule %d, %.1f m in %.1f s, %d precedences", self.robot, message.version,
                      message.arc_lengths[-1], message.times[-1], len(message.precedences))

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

    def _hear_directive(self, message: Directive) -> None:
        try:
            directive = exchange.directive_from_message(message, self._config.map_frame, self._clock, only=self.robot)
        except InvalidInput as error:
            rospy.logerr("a directive was not taken: %s", error)
            return
        with self._lock:
            self._directed = True
            self._eyes.know(directive.obstacles)
            for report in self._member.remembered(directive):
                self._reports.relay(report)
            if self._member.hear(directive) is not None:
                self._take_up(next(item.schedule for item in message.assignments
                                   if item.schedule.robot == self.robot))

    def _hear_errand(self, message: ErrandMessage) -> None:
        try:
            errand = exchange.errand_from_message(message)
        except InvalidInput as error:
            rospy.logerr("the errand was not taken: %s", error)
            return
        with self._lock:
            if message.number < self._errand:
                return
            self._errand, self._member.errand = message.number, errand
            if errand is None and self._tracker.schedule is not None and not self._tracker.arrived:
                # At once: the fleet makes a schedule of that only after an exchange.
                self._member.bound = min(self._member.bound, self._tracker.stopping_arc_length())

    def _hear_progress(self, message: Progress) -> None:
        if message.robot != self.robot:
            with self._lock:
                self._member.hear_report(exchange.report_from_progress(message, self._clock))

    def _hear_odom(self, message: Odometry) -> None:
        with self._lock:
            self._heard_odom = rospy.get_time()
            self._base = conversions.frame_name(message.child_frame_id)
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
        now = self._clock.seconds(stamp)
        measured_at = None if measured is None else self._clock.seconds(measured)
        reference = self._tracker.reference or pose  # of this moment: the step moves it on
        view = self._eyes.view(now, pose, self._base, self._tracker, self._member.others)
        self._member.obstacles, self._member.cleared = self._eyes.obstacles, self._eyes.cleared
        if not self._directed:
            self._member.greet(now)
        command = self._member.step(now, pose, pose_stamp=measured_at, horizon=view.horizon, ahead=view.ahead)
        self._cmd_vel.publish(conversions.twist_to_message(command.speed, command.turn_rate))
        self._reports.step(stamp, pose, reference, self._eyes.reason)
        self._health.note(now, measured_at)

    def _stop(self) -> None:
        """Leave the robot standing, and its topics to rospy, which closes them next."""
        with self._lock:
            self._stopped = True
            self._cmd_vel.publish(Twist())


def _body(config: TrajectoryTrackerParameters) -> Body:
    limits = MotionLimits(config.max_speed, config.max_acceleration, config.max_turn_rate,
                          config.max_turn_acceleration)
    return Body(config.radius, limits, config.weight)


def _motion(message: Schedule) -> Tuple:
    """What two schedules of one version have to share."""
    return message.header.stamp, message.path.poses, message.arc_lengths, message.times
