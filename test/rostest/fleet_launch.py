#!/usr/bin/env python3
"""The robots of a fleet file cross on one schedule, each with the radius and speed that the file gives it."""

import math
import unittest
from typing import Dict

import rospy
import rostest
from geometry_msgs.msg import PoseArray
from support import Listener, planned, service, stamped, wait_until

from social_fleet.msg import PlannedPath, Progress
from social_fleet.srv import Coordinate, CoordinateRequest, CoordinateResponse, PlanPath, PlanPathRequest

GOALS = {"gold": (14.5, 8.0), "blue": (8.0, 14.5)}


class FleetLaunchTest(unittest.TestCase):
    """All nodes come from fleet.launch."""

    def test_the_fleet_crosses(self) -> None:
        news: Dict[str, Progress] = {}
        rospy.Subscriber("fleet/progress", Progress, lambda message: news.update({message.robot: message}))
        announced, truth = Listener("fleet/paths", PlannedPath), Listener("fleet/ground_truth", PoseArray)
        plan = service("social_planner/plan_path", PlanPath)
        coordinate = service("fleet_coordinator/coordinate", Coordinate)
        wait_until(lambda: set(news) == set(GOALS), "both trackers", 60.0)
        wait_until(lambda: all(not plan(PlanPathRequest(robot=name, goal=stamped(*goal), inquiry=True)).status
                               for name, goal in GOALS.items()), "map and tf", 60.0)
        paths = []
        for name, goal in GOALS.items():
            path = plan(PlanPathRequest(robot=name, goal=stamped(*goal))).path
            message = planned(name, [(0.0, 0.0), (1.0, 0.0)])
            message.path = path
            paths.append(message)
        announced.wait(2)
        self.assertEqual({message.robot: (round(message.radius, 3), round(message.max_speed, 3))
                          for message in announced.messages}, {"gold": (0.25, 0.7), "blue": (0.3, 0.5)})
        for message in paths:
            known = next(item for item in announced.messages if item.robot == message.robot)
            message.radius, message.max_speed = known.radius, known.max_speed
        answer = coordinate(CoordinateRequest(planning=paths))
        self.assertEqual(answer.status, CoordinateResponse.SUCCESS, answer.message)
        wait_until(lambda: all(item.state == Progress.ARRIVED for item in news.values()), "both to arrive", 90.0)
        gaps = [math.hypot(one.position.x - other.position.x, one.position.y - other.position.y)
                for one, other in (message.poses for message in truth.messages)]
        self.assertGreater(min(gaps), 0.55)


if __name__ == "__main__":
    rospy.init_node("fleet_launch_test")
    rostest.rosrun("social_fleet", "fleet_launch", FleetLaunchTest)
