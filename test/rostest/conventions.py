#!/usr/bin/env python3
"""What ROS users expect of a planner: turned maps, dynamic_reconfigure that holds at once, nav_core's manner."""

import math
import os
import signal
import time
import unittest
from typing import Any, List, Tuple
from xmlrpc.client import ServerProxy

import dynamic_reconfigure.client
import numpy as np
import rosgraph
import rospy
import rostest
from nav_msgs.msg import OccupancyGrid, Path
from support import Listener, drawn, service, stamped, wait_until

from social_fleet.geometry import Pose
from social_fleet.ros import conversions
from social_fleet.ros.global_planner import SocialGlobalPlanner
from social_fleet.srv import PlanPath, PlanPathRequest, PlanPathResponse

# 0.25 m a cell: a corridor of 24 m by 3 m.
WORLD = ["#" * 100] + ["#" + "." * 98 + "#"] * 12 + ["#" * 100]
TURN = math.radians(30.0)
ORIGIN = Pose(5.0, -2.0, TURN)
WEST, EAST = (2.0, 1.75), (22.0, 1.75)  # along the corridor, from the map's corner


def in_map(place: Tuple[float, float]) -> Tuple[float, float]:
    """A place that is given along the turned corridor."""
    x, y = place
    return (ORIGIN.x + math.cos(TURN) * x - math.sin(TURN) * y, ORIGIN.y + math.sin(TURN) * x + math.cos(TURN) * y)


class ConventionsTest(unittest.TestCase):
    """The corridor is turned by 30 degrees."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.plan_path = service("social_planner/plan_path", PlanPath)
        cls.map = rospy.Publisher("map", OccupancyGrid, latch=True, queue_size=1)
        world = drawn(WORLD, 0.25)
        world.info.origin = conversions.pose_to_message(ORIGIN)
        world.header.frame_id = "/map"
        cls.map.publish(world)
        wait_until(lambda: cls.ask().status == PlanPathResponse.SUCCESS, "the map")
        cls.client = dynamic_reconfigure.client.Client("social_planner", timeout=30.0)

    @classmethod
    def ask(cls, start: Tuple[float, float] = WEST, goal: Tuple[float, float] = EAST,
            **values: Any) -> PlanPathResponse:
        return cls.plan_path(PlanPathRequest(start=stamped(*in_map(start)), goal=stamped(*in_map(goal)), **values))

    def aside(self) -> float:
        """How far the middle of a plan is from the corridor's southern wall [m]."""
        points = np.array([(item.pose.position.x, item.pose.position.y) for item in self.ask().path.poses])
        across = math.cos(TURN) * (points[:, 1] - ORIGIN.y) - math.sin(TURN) * (points[:, 0] - ORIGIN.x)
        along = math.cos(TURN) * (points[:, 0] - ORIGIN.x) + math.sin(TURN) * (points[:, 1] - ORIGIN.y)
        return float(np.interp(12.0, along, across)) - 0.25

    def test_a_turned_map(self) -> None:
        self.assertLess(self.aside(), 0.8)  # on the right going east
        answer = self.ask(goal=(10.0, 0.1))
        self.assertEqual(answer.status, PlanPathResponse.INVALID_GOAL)
        self.assertEqual(self.ask().path.header.frame_id, "map")

    def test_b_a_plan_right_after_a_change_uses_it(self) -> None:
        for side, expected in (("left", (2.2, 3.0)), ("none", (1.3, 1.7)), ("right", (0.0, 0.8))):
            self.client.update_configuration({"side": side})
            self.assertTrue(expected[0] < self.aside() < expected[1], (side, self.aside()))
        self.client.update_configuration({"w_right": 0.0, "w_const": 0.0, "w_buf": 0.0})
        self.assertTrue(1.3 < self.aside() < 1.7)
        self.client.update_configuration({"w_right": 1.0, "w_const": 2.0, "w_buf": 5.0})
        self.assertLess(self.aside(), 0.8)

    def test_c_what_is_wrong_is_not_taken(self) -> None:
        before = self.client.get_configuration()
        after = self.client.update_configuration({"side": "up"})
        self.assertEqual(after["side"], before["side"])
        self.assertEqual(self.client.update_configuration({"w_right": -1.0})["w_right"], 0.0)  # held to the bound
        self.assertEqual(self.client.update_configuration({"w_right": 1.0})["w_right"], 1.0)
        self.assertLess(self.aside(), 0.8)
        self.assertEqual(rospy.get_param("social_planner/w_right"), 1.0)

    def test_d_parameters_are_explained(self) -> None:
        described = {item["name"]: item for item in self.client.get_parameter_descriptions()}
        self.assertIn("side that robots keep to", described["side"]["description"])
        self.assertEqual((described["w_right"]["min"], described["w_right"]["max"]), (0.0, 10000.0))
        self.assertNotIn("robot_radius", described)

    def test_e_in_nav_cores_manner(self) -> None:
        planner, plans = SocialGlobalPlanner(), Listener("~SocialGlobalPlanner/plan", Path)
        planner.initialize("SocialGlobalPlanner")
        wait_until(lambda: plans._subscriber.get_num_connections() > 0, "the plan's topic")
        poses: List[Any] = planner.make_plan(stamped(*in_map(WEST)), stamped(*in_map(EAST)))
        self.assertAlmostEqual(poses[-1].pose.position.x, in_map(EAST)[0], places=6)
        self.assertEqual(len(plans.wait().poses), len(poses))
        beyond = stamped(*in_map((10.0, 0.1)))
        self.assertEqual(planner.make_plan(stamped(*in_map(WEST)), beyond), [])
        self.assertTrue(planner.make_plan(stamped(*in_map(WEST)), beyond, 1.0))

    def test_f_no_answer_is_no_hang(self) -> None:
        planner = SocialGlobalPlanner()
        planner.initialize("SocialGlobalPlanner")
        uri = rosgraph.Master("/conventions_test").lookupNode("/social_planner")
        process = int(ServerProxy(uri).getPid("/conventions_test")[2])
        os.kill(process, signal.SIGSTOP)
        try:
            begun = time.monotonic()
            self.assertEqual(planner.make_plan(stamped(*in_map(WEST)), stamped(*in_map(EAST))), [])
            self.assertLess(time.monotonic() - begun, 2.0)
        finally:
            os.kill(process, signal.SIGCONT)
        self.assertTrue(planner.make_plan(stamped(*in_map(WEST)), stamped(*in_map(EAST))))


if __name__ == "__main__":
    rospy.init_node("conventions_test")
    rostest.rosrun("social_fleet", "conventions", ConventionsTest)
