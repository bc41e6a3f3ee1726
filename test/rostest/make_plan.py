#!/usr/bin/env python3
"""The map from a file, and nav_msgs/GetPlan on it: a path, or an empty one where there is none."""

import unittest
from typing import Any

import rospy
import rostest
from nav_msgs.msg import MapMetaData, OccupancyGrid, Path
from nav_msgs.srv import GetMap, GetPlan
from support import Listener, service, stamped, wait_until
from visualization_msgs.msg import Marker

START, GOAL = (1.5, 8.0), (14.5, 8.0)


class MakePlanTest(unittest.TestCase):
    """GetPlan has no status: what fails gives an empty path, and the next request is served."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.service = service("social_planner/make_plan", GetPlan)
        wait_until(lambda: cls.plan(START, GOAL).poses, "the planner to have its map")

    @classmethod
    def plan(cls, start: Any, goal: Any, tolerance: float = 0.0) -> Path:
        start, goal = (stamped(*end) if isinstance(end, tuple) else end for end in (start, goal))
        return cls.service(start, goal, tolerance).plan

    def test_a_path(self) -> None:
        path = self.plan(START, GOAL)
        self.assertEqual(path.header.frame_id, "map")
        ends = [(item.pose.position.x, item.pose.position.y) for item in (path.poses[0], path.poses[-1])]
        self.assertEqual(ends, [START, GOAL])
        for item in path.poses:
            self.assertAlmostEqual(item.pose.orientation.z ** 2 + item.pose.orientation.w ** 2, 1.0, places=9)

    def test_failures_leave_the_path_empty(self) -> None:
        unturned = stamped(*GOAL)
        unturned.pose.orientation.w = 0.0
        for goal in (-5.0, 8.0), (1.0, 1.0), stamped(*GOAL, frame="elsewhere"), unturned:
            self.assertEqual(self.plan(START, goal).poses, [])
        self.assertTrue(self.plan(START, GOAL).poses)

    def test_tolerance(self) -> None:
        wall = (14.5, 10.1)
        self.assertEqual(self.plan(START, wall).poses, [])
        self.assertTrue(self.plan(START, wall, 1.0).poses)

    def test_the_social_graph(self) -> None:
        graph = Listener("social_planner/social_graph", Marker).wait()
        self.assertEqual((graph.type, graph.header.frame_id), (Marker.LINE_LIST, "map"))
        self.assertEqual(len(graph.points), len(graph.colors))
        self.assertGreater(len(graph.points), 100)

    def test_the_map_itself(self) -> None:
        grid = Listener("map", OccupancyGrid).wait()
        metadata = Listener("map_metadata", MapMetaData).wait()
        self.assertEqual(len(grid.data), grid.info.width * grid.info.height)
        self.assertEqual((metadata.width, metadata.height), (grid.info.width, grid.info.height))
        self.assertEqual(service("static_map", GetMap)().map.data, grid.data)


if __name__ == "__main__":
    rospy.init_node("make_plan_test")
    rostest.rosrun("social_fleet", "make_plan", MakePlanTest)
