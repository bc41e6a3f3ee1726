#!/usr/bin/env python3
"""Programs that are killed under way and start anew: the robots stand meanwhile, and arrive."""

import math
import unittest
from typing import Dict, Tuple

import actionlib
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseArray
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from support import Listener, kill, stamped, wait_until

from social_fleet.msg import RobotReport

ARRIVAL = 100.0  # [s] of wall time, for what is compiled before the first drive, too
DIAMETER = 0.5  # of the robots [m]
WEST, EAST, SOUTH, NORTH = (1.5, 8.0), (14.5, 8.0), (8.0, 1.5), (8.0, 14.5)


class RestartsTest(unittest.TestCase):
    """Blue drives from west to east and back, gold from south to north and back. Tests run in order of names."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.clients = {name: actionlib.SimpleActionClient(f"{name}/move_base", MoveBaseAction)
                       for name in ("blue", "gold")}
        cls.truth = Listener("fleet/ground_truth", PoseArray)
        cls.reports = {name: Listener(f"{name}/report", RobotReport) for name in cls.clients}
        for client in cls.clients.values():
            assert client.wait_for_server(rospy.Duration(60.0)), "the action server did not come up"
        wait_until(lambda: all(listener.messages for listener in cls.reports.values()), "the trackers")

    def send(self, **goals: Tuple[float, float]) -> None:
        """Both at the same time."""
        for name, goal in goals.items():
            self.clients[name].send_goal(MoveBaseGoal(stamped(*goal)))

    def await_arrival(self, **goals: Tuple[float, float]) -> None:
        for name in goals:
            wait_until(lambda: self.clients[name].get_state() not in (GoalStatus.PENDING, GoalStatus.ACTIVE),
                       f"{name} to arrive", ARRIVAL)
            self.assertEqual(self.clients[name].get_state(), GoalStatus.SUCCEEDED,
                             self.clients[name].get_goal_status_text())
        where: Dict[str, Tuple[float, float]] = {name: self.place(name) for name in goals}
        for name, goal in goals.items():
            self.assertLess(math.dist(where[name], goal), 0.1)
        self.assertGreater(self.clearance(), 0.0)

    def place(self, name: str) -> Tuple[float, float]:
        pose = self.reports[name].messages[-1].pose
        return pose.x, pose.y

    def clearance(self) -> float:
        """The smallest so far, of the true poses [m]."""
        pairs = ([(pose.position.x, pose.position.y) for pose in message.poses] for message in self.truth.messages)
        return min(math.dist(*pair) for pair in pairs) - DIAMETER

    def await_driving(self, name: str) -> None:
        wait_until(lambda: self.reports[name].messages[-1].speed > 0.2, f"{name} to drive", ARRIVAL)

    def test_1_two_goals_at_the_same_time(self) -> None:
        self.send(blue=EAST, gold=NORTH)
        self.await_arrival(blue=EAST, gold=NORTH)

    def test_2_a_tracker_is_killed_under_way(self) -> None:
        session = self.reports["blue"].messages[-1].session
        self.send(blue=WEST, gold=SOUTH)
        self.await_driving("blue")
        kill("/blue/trajectory_tracker")
        wait_until(lambda: self.reports["blue"].messages[-1].session > session, "a new tracker", ARRIVAL)
        self.await_arrival(blue=WEST, gold=SOUTH)

    def test_3_the_coordinator_is_killed_under_way(self) -> None:
        self.send(blue=EAST, gold=NORTH)
        self.await_driving("gold")
        version = self.reports["gold"].messages[-1].schedule_version
        kill("/fleet_coordinator")
        self.send(blue=WEST)
        self.await_arrival(blue=WEST, gold=NORTH)
        self.assertGreater(self.reports["gold"].messages[-1].schedule_version, version)

    def test_4_the_coordinator_is_killed_before_goals_come(self) -> None:
        kill("/fleet_coordinator")
        self.send(blue=EAST, gold=SOUTH)
        self.await_arrival(blue=EAST, gold=SOUTH)


if __name__ == "__main__":
    rospy.init_node("restarts_test")
    rostest.rosrun("social_fleet", "restarts", RestartsTest)
