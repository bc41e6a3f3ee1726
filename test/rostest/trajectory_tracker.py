#!/usr/bin/env python3
"""A tracker moves only with a schedule of its own, a pose and fresh odometry."""

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
from social_fleet.msg import Progress, Schedule
from social_fleet.ros.conversions import schedule_to_message


class TrajectoryTrackerTest(unittest.TestCase):
    """The robot never moves, whatever it is told: its odometry stays at the start. Tests run in order of names."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.commands, cls.progress = Listener("gold/cmd_vel", Twist), Listener("fleet/progress", Progress)
        cls.odom = rospy.Publisher("gold/odom", Odometry, queue_size=1)
        cls.schedules = rospy.Publisher("fleet/schedules", Schedule, queue_size=10)
        wait_until(lambda: cls.odom.get_num_connections() and cls.schedules.get_num_connections(), "the tracker")
        cls.tell = True
        cls.timer = rospy.Timer(rospy.Duration(0.05), cls.send_odometry)

    @classmethod
    def send_odometry(cls, _event: rospy.timer.TimerEvent) -> None:
        if cls.tell:
            message = Odometry(child_frame_id="gold/base_link")
            message.header.stamp, message.header.frame_id = rospy.Time.now(), "gold/odom"
            message.pose.pose.orientation.w = 1.0
            cls.odom.publish(message)

    def send_schedule(self, name: str, version: int) -> None:
        robot = Robot(name, np.array([(0.0, 0.0), (5.0, 0.0)]))
        schedule = coordinate([robot], version=version).schedules[0]
        self.schedules.publish(schedule_to_message(schedule, "map", rospy.Time.now()))

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
        transform = TransformStamped(child_frame_id="gold/odom")
        transform.header.frame_id, transform.header.stamp = "map", rospy.Time.now()
        transform.transform.rotation.w = 1.0
        self.__class__.broadcaster = tf2_ros.StaticTransformBroadcaster()
        self.broadcaster.sendTransform(transform)
        self.send_schedule("gold", 2)
        wait_until(lambda: max(self.latest(1)) > 0.05, "the tracker to drive")

    def test_4_with_stale_odometry(self) -> None:
        self.send_schedule("gold", 3)
        self.__class__.tell = False
        wait_until(lambda: self.latest(1)[-1] == 0.0, "the tracker to brake")
        self.__class__.tell = True

    def test_5_with_a_broken_schedule(self) -> None:
        message = Schedule(robot="gold", version=4, arc_lengths=[0.0, 1.0], times=[0.0])
        message.header.frame_id = message.path.header.frame_id = "map"
        self.schedules.publish(message)
        self.latest()
        self.assertEqual(self.progress.messages[-1].schedule_version, 3)


if __name__ == "__main__":
    rospy.init_node("trajectory_tracker_test")
    rostest.rosrun("social_fleet", "trajectory_tracker", TrajectoryTrackerTest)
