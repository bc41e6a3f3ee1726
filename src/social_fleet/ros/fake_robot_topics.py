"""What one simulated robot, and all of them together, say on ROS topics."""

from typing import Any, Callable, Iterable, Optional, Sequence

import genpy
import numpy as np
import rospy
from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped, TransformStamped, Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from social_fleet.geometry import Pose, compose, inverse
from social_fleet.ros import conversions
from social_fleet.simulation.config import LidarConfig
from social_fleet.simulation.robot import DifferentialDriveRobot

_CERTAIN = (1e-4, 1e-4, 1e-4)  # variances of x, y and yaw that amcl_pose claims


class RobotTopics:
    """The topics of one robot, below its name.

    Parameters
    ----------
    robot
        The simulated robot.
    command
        Called with the robot's name, speed [m/s] and turn rate [rad/s] of every command.

    Attributes
    ----------
    estimate : Pose, optional
        What localisation says, None for nothing; the owner keeps it up to date [m, rad, map frame].
    """

    def __init__(self, robot: DifferentialDriveRobot, command: Callable[[str, float, float], None]) -> None:
        self.robot = robot
        self.estimate: Optional[Pose] = robot.pose
        self._command = command
        name = robot.name
        self.odom_frame, self.base_frame = f"{name}/odom", f"{name}/base_link"
        self._odom = rospy.Publisher(f"{name}/odom", Odometry, queue_size=1)
        self._pose = rospy.Publisher(f"{name}/amcl_pose", PoseWithCovarianceStamped, queue_size=1)
        self._scan = rospy.Publisher(f"{name}/scan", LaserScan, queue_size=1)
        self._cmd_vel = rospy.Subscriber(f"{name}/cmd_vel", Twist, self._hear, queue_size=1, tcp_nodelay=True)

    def _hear(self, message: Twist) -> None:
        self._command(self.robot.name, message.linear.x, message.angular.z)

    @property
    def is_commanded(self) -> bool:
        """Whether anybody publishes commands."""
        return self._cmd_vel.get_num_connections() > 0

    def publish_odometry(self, stamp: genpy.Time) -> None:
        """Where dead reckoning has the robot, and how fast it is."""
        message = Odometry(header=Header(stamp=stamp, frame_id=self.odom_frame), child_frame_id=self.base_frame)
        message.pose.pose = conversions.pose_to_message(self.robot.odometry)
        message.twist.twist = conversions.twist_to_message(self.robot.speed, self.robot.turn_rate)
        self._odom.publish(message)

    def publish_pose(self, stamp: genpy.Time, map_frame: str) -> None:
        """Where localisation has the robot; nothing while it does not know."""
        if self.estimate is None:
            return
        message = PoseWithCovarianceStamped(header=Header(stamp=stamp, frame_id=map_frame))
        message.pose.pose = conversions.pose_to_message(self.estimate)
        covariance = np.zeros((6, 6))
        covariance[[0, 1, 5], [0, 1, 5]] = _CERTAIN
        message.pose.covariance = covariance.ravel().tolist()
        self._pose.publish(message)

    @property
    def scan_is_wanted(self) -> bool:
        """Whether anybody listens to the lidar."""
        return self._scan.get_num_connections() > 0

    def publish_scan(self, stamp: genpy.Time, ranges: np.ndarray, config: LidarConfig, period: float) -> None:
        """What the lidar at the robot's centre sees [m]."""
        message = LaserScan(header=Header(stamp=stamp, frame_id=self.base_frame))
        message.angle_min, message.angle_increment = config.angle_min, config.angle_increment
        message.angle_max = config.angle_min + config.angle_increment * (len(ranges) - 1)
        message.range_min, message.range_max, message.scan_time = config.range_min, config.range_max, period
        message.ranges = ranges.tolist()
        self._scan.publish(message)


class FleetTopics:
    """The topics that all simulated robots share."""

    def __init__(self, map_frame: str) -> None:
        self.map_frame = map_frame
        self._tf = rospy.Publisher("/tf", TFMessage, queue_size=10)
        self._truth = rospy.Publisher("fleet/ground_truth", PoseArray, queue_size=100)

    def publish_transforms(self, stamp: genpy.Time, robots: Iterable[RobotTopics]) -> None:
        """odom -> base_link of every robot, and map -> odom where it is localised, in one message."""
        transforms = []
        for topics in robots:
            robot = topics.robot
            # The map first: who looks between the two gets a pose in odom that can be brought into the map.
            if topics.estimate is not None:
                origin = compose(topics.estimate, inverse(robot.odometry))
                transforms.append(_transform(stamp, self.map_frame, topics.odom_frame, origin))
            transforms.append(_transform(stamp, topics.odom_frame, topics.base_frame, robot.odometry))
        self._tf.publish(TFMessage(transforms))

    def publish_truth(self, stamp: genpy.Time, poses: Sequence[Any]) -> None:
        """The true poses, in the robots' order."""
        message = PoseArray(header=Header(stamp=stamp, frame_id=self.map_frame))
        message.poses = [conversions.pose_to_message(Pose(*pose)) for pose in poses]
        self._truth.publish(message)


def _transform(stamp: genpy.Time, parent: str, child: str, pose: Pose) -> TransformStamped:
    message = TransformStamped(header=Header(stamp=stamp, frame_id=parent), child_frame_id=child)
    message.transform.translation.x, message.transform.translation.y = pose.x, pose.y
    message.transform.rotation = conversions.yaw_to_quaternion(pose.yaw)
    return message
