#!/usr/bin/env python3
"""A robot meets what the map does not hold: it touches nothing, goes round, and waits where there is no room."""

import math
import unittest

import actionlib
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseArray
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from support import Listener, stamped, wait_until

from social_fleet.msg import Directive, NavigationStatus, PlannedPath, RobotReport, Waiting

PATIENCE = 120.0  # [s] of wall time, for what is compiled before the first drive, too
RADIUS = 0.25  # of the robot [m]
LOOSE, CLOSED = ((10.0, 3.2, 0.3),), ((20.0, 3.1, 0.45), (20.0, 3.95, 0.45))  # obstacles [m]


class LidarStopTest(unittest.TestCase):
    """Blue drives through a corridor with an obstacle beside its middle, and a barrier behind that for 150 s."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.client = actionlib.SimpleActionClient("blue/move_base", MoveBaseAction)
        cls.truth, cls.reports = Listener("fleet/ground_truth", PoseArray), Listener("blue/report", RobotReport)
        cls.waits, cls.states = Listener("fleet/waiting", Waiting), Listener("fleet/navigation", NavigationStatus)
        cls.directives, cls.paths = Listener("fleet/directives", Directive), Listener("fleet/paths", PlannedPath)
        assert cls.client.wait_for_server(rospy.Duration(60.0)), "the action server did not come up"
        wait_until(lambda: cls.reports.messages, "the tracker")

    def send(self, x: float, y: float) -> None:
        self.client.send_goal(MoveBaseGoal(stamped(x, y)))

    def await_end(self) -> None:
        wait_until(lambda: self.client.get_state() not in (GoalStatus.PENDING, GoalStatus.ACTIVE), "an end", PATIENCE)

    def closest(self, *obstacles: tuple) -> float:
        """Surface to surface, of all true poses [m]."""
        return min(math.hypot(message.poses[0].position.x - x, message.poses[0].position.y - y) - radius
                   for message in self.truth.messages for x, y, radius in obstacles) - RADIUS

    def obstacles(self) -> list:
        return self.directives.messages[-1].obstacles

    def test_1_it_goes_round_what_leaves_room(self) -> None:
        self.send(15.0, 3.5)
        self.await_end()
        self.assertEqual(self.client.get_state(), GoalStatus.SUCCEEDED, self.client.get_goal_status_text())
        self.assertGreater(self.closest(*LOOSE), 0.0)
        self.assertTrue(self.obstacles())
        self.assertEqual([path.temporary for path in self.paths.messages], [False, True])

    def test_2_it_stops_before_what_does_not_and_says_so(self) -> None:
        self.send(27.0, 3.5)
        wait_until(lambda: self.waits.messages and self.waits.messages[-1].waits
                   and not self.waits.messages[-1].other, "blue to wait", PATIENCE)
        self.assertIn("stands in the way", self.waits.messages[-1].reason)
        wait_until(lambda: self.states.messages[-1].state == NavigationStatus.WAITING, "blue's goal to wait", PATIENCE)
        self.assertGreater(self.closest(*CLOSED), 0.0)
        self.assertLess(self.reports.messages[-1].pose.x, 20.0)

    def test_3_it_goes_on_when_that_is_gone(self) -> None:
        self.await_end()
        self.assertEqual(self.client.get_state(), GoalStatus.SUCCEEDED, self.client.get_goal_status_text())
        self.assertFalse([item for item in self.obstacles() if item.x > 15.0])


if __name__ == "__main__":
    rospy.init_node("lidar_stop_test")
    rostest.rosrun("social_fleet", "lidar_stop", LidarStopTest)
