#!/usr/bin/env python3
"""What simulated robots say: clock, odometry, tf, pose, lidar; and that they keep to their limits."""

import math
import unittest

import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped, Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from support import Listener, wait_until


class FakeRobotsTest(unittest.TestCase):
    """Gold stands three metres behind blue and looks at it."""

    def test_clock_rises_in_steps(self) -> None:
        times = Listener("/clock", Clock)
        times.wait(5)
        steps = [(later.clock - earlier.clock).to_sec() for earlier, later in zip(times.messages, times.messages[1:])]
        self.assertEqual({round(step, 6) for step in steps}, {0.1})

    def test_frames(self) -> None:
        buffer = tf2_ros.Buffer(debug=False)
        tf2_ros.TransformListener(buffer)
        wait_until(lambda: buffer.can_transform("map", "blue/base_link", rospy.Time()), "tf")
        transform = buffer.lookup_transform("map", "blue/base_link", rospy.Time()).transform
        self.assertAlmostEqual(transform.translation.x, 6.0)
        self.assertAlmostEqual(2.0 * math.atan2(transform.rotation.z, transform.rotation.w), 1.5708)

    def test_lidar_sees_walls_and_robots(self) -> None:
        scan = Listener("gold/scan", LaserScan).wait()
        self.assertEqual(scan.header.frame_id, "gold/base_link")
        ahead = round(-scan.angle_min / scan.angle_increment)
        left = round((0.5 * math.pi - scan.angle_min) / scan.angle_increment)
        if Listener("gold/odom", Odometry).wait().pose.pose.position.x == 0.0:
            self.assertAlmostEqual(scan.ranges[ahead], 3.0 - 0.25, places=2)
        self.assertLess(scan.ranges[left], 3.0)

    def test_z_a_commanded_robot_moves_within_its_limits(self) -> None:
        odometry, truth = Listener("gold/odom", Odometry), Listener("fleet/ground_truth", PoseArray)
        commands = rospy.Publisher("gold/cmd_vel", Twist, queue_size=1)
        wait_until(lambda: commands.get_num_connections() > 0, "the simulation to listen")
        command = Twist()
        command.linear.x = 2.0

        def drive() -> bool:
            commands.publish(command)
            return bool(odometry.messages) and odometry.messages[-1].pose.pose.position.x > 1.0
        wait_until(drive, "a metre's drive")
        wait_until(lambda: odometry.messages[-1].twist.twist.linear.x == 0.0, "standstill without further commands")
        speeds = [(message.header.stamp.to_sec(), message.twist.twist.linear.x) for message in odometry.messages]
        self.assertAlmostEqual(max(speed for _, speed in speeds), 0.5)
        for (earlier, before), (later, after) in zip(speeds, speeds[1:]):
            self.assertLessEqual(abs(after - before), 1.0 * (later - earlier) + 1e-6)
        driven = odometry.messages[-1].pose.pose.position.x
        truth.wait(len(truth.messages) + 1)
        self.assertAlmostEqual(truth.messages[-1].poses[0].position.x, 3.0 + driven, places=6)
        pose = Listener("gold/amcl_pose", PoseWithCovarianceStamped).wait()
        self.assertAlmostEqual(pose.pose.pose.position.x, 3.0 + driven, places=6)
        self.assertEqual(pose.header.frame_id, "map")


if __name__ == "__main__":
    rospy.init_node("fake_robots_test")
    rostest.rosrun("social_fleet", "fake_robots", FakeRobotsTest)
