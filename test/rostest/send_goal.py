#!/usr/bin/python3
"""A goal sent by hand: one robot drives while the other stands; what cannot be is refused with a reason."""

import math
import sys
import unittest

import rospy
import rostest
from support import wait_until

from social_fleet.errors import InvalidInput
from social_fleet.geometry import Pose
from social_fleet.ros.fleet_client import Refused
from social_fleet.ros.frames import Frames
from social_fleet.ros.goal_sender import GoalSender

GOAL = Pose(27.0, 3.5, 0.0)


class SendGoal(unittest.TestCase):
    """Blue is sent through the corridor; gold stands at its other end."""

    def test_one_drives_while_the_other_stands(self) -> None:
        """It arrives where it was sent; while it drives, nobody else is sent."""
        sender, frames = GoalSender(), Frames("map")
        with self.assertRaises(InvalidInput):
            sender.send("nobody", GOAL)
        with self.assertRaises(Refused):
            sender.send("blue", Pose(15.0, 0.5, 0.0))
        stood = frames.await_pose_of("gold/base_link", 10.0)
        self.assertGreater(sender.send("blue", GOAL), 10.0)
        with self.assertRaises(InvalidInput):
            sender.send("gold", Pose(2.0, 3.5, 0.0))
        wait_until(lambda: math.dist(frames.pose_of("blue/base_link")[:2], GOAL[:2]) < 0.05, "blue at its goal", 60.0)
        self.assertEqual(stood, frames.pose_of("gold/base_link"))


if __name__ == "__main__":
    rospy.init_node("send_goal_test")
    rostest.rosrun("social_fleet", "send_goal", SendGoal, sys.argv)
