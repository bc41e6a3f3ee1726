#!/usr/bin/env python3
"""A tracker moves only with a schedule of its own, a fresh pose and odometry; of schedules it keeps to the newest."""

import copy
import unittest

import numpy as np
import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import TransformStamped, Twist
from nav_msgs.msg import Odometry
from support import Listener, wait_until

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.robot import Robot
from social_fleet.msg import Precedence, Progress, Schedule
from social_fleet.ros.conversions import schedule_to_message


class TrajectoryTrackerTest(unittest.TestCase):
    """The robot never moves, whatever it is told: its odometry is the test's. Tests run in order of names."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.commands, cls.progress = Listener("gold/cmd_vel", Twist), Listener("fleet/progress", Progress)
        cls.odom = rospy.Publisher("gold/odom", Odometry, queue_size=1)
        cls.schedules = rospy.Publisher("fleet/schedules", Schedule, queue_size=10)
        wait_until(lambda: cls.odom.get_num_connections() and cls.schedules.get_num_connections(), "the tracker")
        cls.tell, cls.frame, cls.ahead, cls.x = True, "gold/odom", 0.0, 0.0
        cls.timer = rospy.Timer(rospy.Duration(0.05), cls.send_odometry)

    @classmethod
    def send_odometry(cls, _event: rospy.timer.TimerEvent) -> None:
        if cls.tell:
            message = Odometry(child_frame_id="gold/base_link")
            message.header.stamp = rospy.Time.now() + rospy.Duration(cls.ahead)
            message.header.frame_id = cls.frame
            message.pose.pose.position.x, message.pose.pose.orientation.w = cls.x, 1.0
            cls.odom.publish(message)

    def send_schedule(self, name: str, version: int) -> Schedule:
        robot = Robot(name, np.array([(0.0, 0.0), (5.0, 0.0)]))
        schedule = coordinate([robot], version=version).schedules[0]
        message = schedule_to_message(schedule, "map", rospy.Time.now())
        self.schedules.publish(message)
        return message

    def latest(self, count: int = 10) -> list:
        """The next `count` commands."""
        del self.commands.messages[:]
        self.commands.wait(count)
        return [message.linear.x for message in self.commands.messages]

    def await_state(self, state: int) -> None:
        del self.progress.messages[:]
        wait_until(lambda: self.progress.messages and self.progress.messages[-1].state == state, f"state {state}")

    def test_0_without_a_schedule(self) -> None:
        self.await_state(Progress.IDLE)
        self.assertEqual(set(self.latest()), {0.0})

    def test_1_with_the_schedule_of_another(self) -> None:
        self.send_schedule("blue", 1)
        self.assertEqual(set(self.latest()), {0.0})

    def test_2_without_a_pose(self) -> None:
        self.send_schedule("gold", 1)
        self.await_state(Progress.STOPPED)
        self.assertEqual(set(self.latest()), {0.0})
        self.assertEqual(self.progress.messages[-1].schedule_version, 1)

    def test_3_with_all_it_needs(self) -> None:
        self.__class__.broadcaster = tf2_ros.StaticTransformBroadcaster()
        self.broadcaster.sendTransform(origin("gold/odom"))
        self.send_schedule("gold", 2)
        wait_until(lambda: max(self.latest(1)) > 0.05, "the tracker to drive")

    def test_4_with_stale_odometry(self) -> None:
        self.send_schedule("gold", 3)
        self.__class__.tell = False
        wait_until(lambda: self.latest(1)[-1] == 0.0, "the tracker to brake")
        self.__class__.tell = True

    def test_5_with_odometry_from_the_future(self) -> None:
        self.send_schedule("gold", 4)
        self.__class__.ahead = 60.0
        wait_until(lambda: max(self.latest(1)) > 0.05, "the tracker to drive")
        self.__class__.tell = False
        wait_until(lambda: self.latest(1)[-1] == 0.0, "the tracker to brake", 5.0)
        self.__class__.tell, self.__class__.ahead = True, 0.0

    def test_6_with_stale_localisation(self) -> None:
        """Odometry goes on; tf from the map to it does not."""
        self.__class__.frame = "gold/localised"
        dynamic = tf2_ros.TransformBroadcaster()
        self.send_schedule("gold", 5)

        def localised() -> bool:
            dynamic.sendTransform(origin(self.frame))
            return bool(self.commands.messages) and self.commands.messages[-1].linear.x > 0.05
        wait_until(localised, "the tracker to drive")
        self.await_state(Progress.STOPPED)
        wait_until(lambda: self.latest(1)[-1] == 0.0, "the tracker to brake")
        self.__class__.frame = "gold/odom"

    def test_7_with_other_precedences(self) -> None:
        """The robot is 8 cm on its way; what it waits for changes, and nothing else."""
        message = self.send_schedule("gold", 6)
        self.await_state(Progress.DRIVING)
        wait_until(lambda: max(self.latest(1)) > 0.05, "the tracker to drive")
        self.__class__.x = 0.08
        wait_until(lambda: self.progress.messages[-1].arc_length > 0.07, "progress")
        amended = copy.deepcopy(message)
        amended.precedences = [Precedence(at=0.3, other="blue", other_at=1.0, other_version=1)]
        self.schedules.publish(amended)
        self.__class__.x = 0.25
        self.await_state(Progress.HOLDING)
        self.schedules.publish(message)
        self.await_state(Progress.DRIVING)
        self.assertEqual({item.schedule_version for item in self.progress.messages}, {6})
        self.assertGreater(min(item.arc_length for item in self.progress.messages), 0.07)

    def test_8_with_what_it_must_not_take_up(self) -> None:
        older, same = self.send_schedule("gold", 2), self.send_schedule("gold", 6)
        broken = Schedule(robot="gold", version=7, arc_lengths=[0.0, 1.0], times=[0.0])
        broken.header.frame_id = broken.path.header.frame_id = "map"
        self.schedules.publish(broken)
        self.latest()
        self.assertEqual((older.version, same.version, self.progress.messages[-1].schedule_version), (2, 6, 6))
        self.assertGreater(self.progress.messages[-1].arc_length, 0.07)


def origin(frame: str) -> TransformStamped:
    """The transform of a frame that is where the map is, now."""
    transform = TransformStamped(child_frame_id=frame)
    transform.header.frame_id, transform.header.stamp = "map", rospy.Time.now()
    transform.transform.rotation.w = 1.0
    return transform


if __name__ == "__main__":
    rospy.init_node("trajectory_tracker_test")
    rostest.rosrun("social_fleet", "trajectory_tracker", TrajectoryTrackerTest)
