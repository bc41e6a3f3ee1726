#!/usr/bin/python3
"""Goals sent by hand: one robot drives, another is sent while it does; what cannot be is refused with a reason."""

import math
import sys
import unittest

import rospy
import rostest
from support import Listener, wait_until

from social_fleet.errors import InvalidInput
from social_fleet.geometry import Pose
from social_fleet.msg import NavigationStatus
from social_fleet.ros.fleet_client import Refused
from social_fleet.ros.frames import Frames
from social_fleet.ros.goal_sender import GoalSender

EAST, WEST = Pose(27.0, 3.5, 0.0), Pose(4.0, 4.8, math.pi)


class SendGoal(unittest.TestCase):
    """Blue is sent through the corridor; gold stands at its other end, and then comes against it."""

    def test_two_drive_at_once(self) -> None:
        """Both arrive where they were sent."""
        sender, frames, states = GoalSender(), Frames("map"), Listener("fleet/navigation", NavigationStatus)
        wait_until(lambda: {message.robot for message in states.messages} == {"blue", "gold"}, "the navigators", 60.0)
        with self.assertRaises(InvalidInput) as caught:
            sender.send("nobody", EAST)
        self.assertIn("blue, gold", str(caught.exception))
        with self.assertRaises(Refused):
            sender.send("blue", Pose(15.0, 0.5, 0.0))
        self.assertGreater(sender.send("blue", EAST), 10.0)
        self.assertGreater(sender.send("gold", WEST), 10.0)
        for robot, goal in (("blue", EAST), ("gold", WEST)):
            wait_until(lambda: math.dist(frames.pose_of(f"{robot}/base_link")[:2], goal[:2]) < 0.05,
                       f"{robot} at its goal", 60.0)


if __name__ == "__main__":
    rospy.init_node("send_goal_test")
    rostest.rosrun("social_fleet", "send_goal", SendGoal, sys.argv)
