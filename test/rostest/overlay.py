#!/usr/bin/env python3
"""Obstacles that come, expire, are cleared or stay, in a hall with room to go round them."""

import math
import unittest
from typing import Any, List, Sequence, Tuple

import rospy
import rostest
from geometry_msgs.msg import Point
from nav_msgs.msg import OccupancyGrid, Path
from rosgraph_msgs.msg import Clock
from support import Listener, drawn, planned, service, stamped, wait_until
from visualization_msgs.msg import Marker

from social_fleet.msg import PlannedPath
from social_fleet.srv import (AddOverlay, AddOverlayRequest, AddOverlayResponse, ClearOverlay, PlanPath,
                              PlanPathRequest, PlanPathResponse)

# 0.25 m a cell: a hall of 12 m by 4 m within its walls.
WORLD = ["#" * 50] + ["#" + "." * 48 + "#"] * 16 + ["#" * 50]
WEST, EAST = (1.5, 0.75), (11.0, 0.75)
IN_THE_WAY = (6.0, 0.9)


class OverlayTest(unittest.TestCase):
    """Tests run in the order of their names: the map comes after the first."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.clock = rospy.Publisher("/clock", Clock, latch=True, queue_size=1)
        cls.clock.publish(Clock(rospy.Time(100)))
        cls.plan_path = service("social_planner/plan_path", PlanPath)
        cls.add_overlay = service("social_planner/add_overlay", AddOverlay)
        cls.clear_overlay = service("social_planner/clear_overlay", ClearOverlay)
        cls.map = rospy.Publisher("map", OccupancyGrid, latch=True, queue_size=1)
        cls.paths = Listener("fleet/paths", PlannedPath)
        cls.graphs = Listener("social_planner/social_graph", Marker)
        cls.others = rospy.Publisher("fleet/paths", PlannedPath, queue_size=10)

    def tearDown(self) -> None:
        self.clear_overlay("")

    def plan(self, goal: Tuple[float, float] = EAST, robot: str = "", **values: Any) -> PlanPathResponse:
        return self.plan_path(PlanPathRequest(robot=robot, start=stamped(*WEST), goal=stamped(*goal), **values))

    def add(self, name: str = "cart", shape: int = AddOverlayRequest.DISC, centre: Sequence[float] = IN_THE_WAY,
            frame: str = "map", points: Sequence[Sequence[float]] = (), lifetime: float = 0.0,
            **values: Any) -> AddOverlayResponse:
        request = AddOverlayRequest(name=name, shape=shape, **{"radius": 0.4, **values})
        request.header.frame_id, request.lifetime = frame, rospy.Duration(lifetime)
        request.pose.position.x, request.pose.position.y = centre
        request.points = [Point(x, y, 0.0) for x, y in points]
        return self.add_overlay(request)

    def put(self, **values: Any) -> None:
        answer = self.add(**values)
        self.assertEqual(answer.status, AddOverlayResponse.SUCCESS, answer.message)

    def refuse(self, status: str, *words: str, **values: Any) -> None:
        answer = self.add(**values)
        self.assertEqual(answer.status, getattr(AddOverlayResponse, status), answer.message)
        for word in words:
            self.assertIn(word, answer.message)

    def at(self, seconds: float) -> None:
        """Let the time be so many seconds, for the node, too."""
        self.clock.publish(Clock(rospy.Time.from_sec(seconds)))

    def test_0_before_the_map(self) -> None:
        self.refuse("NOT_INITIALIZED", "map")
        self.assertEqual(self.clear_overlay("").status, AddOverlayResponse.NOT_INITIALIZED)
        self.map.publish(drawn(WORLD, 0.25))
        wait_until(lambda: self.plan().status == PlanPathResponse.SUCCESS, "the map")

    def test_a_what_is_no_obstacle(self) -> None:
        self.refuse("INVALID_REQUEST", "shape", "17", shape=17)
        self.refuse("INVALID_REQUEST", "name", name="")
        self.refuse("INVALID_REQUEST", "radius", "positive", radius=-1.0)
        self.refuse("INVALID_REQUEST", "x", "finite", centre=(math.nan, 1.0))
        self.refuse("INVALID_REQUEST", "off the map", centre=(50.0, 1.0))
        self.refuse("INVALID_REQUEST", "lifetime", lifetime=-1.0)
        self.refuse("INVALID_REQUEST", "width", shape=AddOverlayRequest.RECTANGLE)
        self.refuse("INVALID_REQUEST", "vertices", shape=AddOverlayRequest.POLYGON, points=[(1, 1), (2, 1)])
        self.refuse("INVALID_REQUEST", "cross", shape=AddOverlayRequest.POLYGON,
                    points=[(1, 1), (2, 2), (2, 1), (1, 2)])
        self.refuse("INVALID_REQUEST", "points", shape=AddOverlayRequest.CELLS)
        self.refuse("TF_ERROR", "odom", "cart", frame="odom")
        answer = self.clear_overlay("cart")
        self.assertEqual((answer.status, list(answer.cleared)), (AddOverlayResponse.INVALID_REQUEST, []))
        self.assertIn("no obstacle 'cart'", answer.message)

    def test_b_a_detour_is_temporary_and_the_old_route_comes_back(self) -> None:
        before = self.plan()
        self.assertFalse(before.temporary)
        for shape in ({}, {"shape": AddOverlayRequest.RECTANGLE, "width": 0.6, "height": 0.8},
                      {"shape": AddOverlayRequest.POLYGON, "points": [(5.7, 0.5), (6.3, 0.5), (6.0, 1.3)]},
                      {"shape": AddOverlayRequest.CELLS, "points": [(6.1, 0.6), (6.1, 0.8), (6.1, 1.1)]}):
            self.put(**shape)
            count = len(self.paths.messages)
            detour = self.plan(robot="gold")
            self.assertTrue(detour.temporary)
            self.assertNotEqual(detour.path.poses, before.path.poses)
            self.assertTrue(self.paths.wait(count + 1).temporary)
            answer = self.clear_overlay("cart")
            self.assertEqual((answer.status, list(answer.cleared)), (AddOverlayResponse.SUCCESS, ["cart"]))
            after = self.plan()
            self.assertFalse(after.temporary)
            self.assertEqual(points(after.path), points(before.path))

    def test_c_far_from_an_obstacle_nothing_is_temporary(self) -> None:
        self.put(centre=(11.0, 3.5))
        self.assertFalse(self.plan(goal=(4.0, 0.75)).temporary)

    def test_d_obstacles_expire_by_ros_time(self) -> None:
        self.at(200.0)
        wait_until(lambda: self.plan().path.header.stamp.to_sec() == 200.0, "the time to reach the node")
        self.put(lifetime=5.0)
        self.put(name="far", centre=(11.0, 3.5))
        self.at(204.9)
        self.assertTrue(self.plan().temporary)
        self.at(205.1)
        wait_until(lambda: not self.plan().temporary, "the obstacle to expire")
        self.assertEqual(list(self.clear_overlay("").cleared), ["far"])

    def test_e_a_goal_in_an_obstacle(self) -> None:
        self.put()
        answer = self.plan(goal=IN_THE_WAY)
        self.assertEqual(answer.status, PlanPathResponse.INVALID_GOAL)
        self.assertIn("obstacle 'cart'", answer.message)
        answer = self.plan(goal=IN_THE_WAY, tolerance=1.0)
        self.assertEqual(answer.status, PlanPathResponse.SUCCESS)
        end = answer.path.poses[-1].pose.position
        gap = math.hypot(end.x - IN_THE_WAY[0], end.y - IN_THE_WAY[1])
        self.assertGreaterEqual(gap, 0.6)
        self.assertIn(f"the path ends {gap:.2f} m from it at ({end.x:.2f}, {end.y:.2f})", answer.message)

    def test_f_detours_leave_the_graph_alone_until_the_obstacle_stays(self) -> None:
        for _ in range(4):
            self.plan(robot="gold")
        learnt = wait_until(lambda: self.graphs.messages and self.graphs.messages[-1].points, "a social graph")
        # what others plan counts, too, and what comes back from the node itself does not
        for _ in range(4):
            self.others.publish(planned("blue", [(1.5, 3.0), (6.0, 3.0)]))
        wait_until(lambda: len(self.graphs.messages[-1].points) > len(learnt), "the others' routes")
        before = self.graphs.messages[-1].points
        self.put()
        for _ in range(3):
            self.assertTrue(self.plan(robot="gold").temporary)
        self.assertEqual(self.graphs.messages[-1].points, before)
        # two more than 3 make more than 4: one of this node and one of another
        self.others.publish(self.detour())
        self.assertTrue(self.plan(robot="gold").temporary)
        wait_until(lambda: self.graphs.messages[-1].points != before, "the obstacle to count as permanent")
        wait_until(lambda: not self.plan().temporary, "plans round the obstacle to be routes")
        inside = [point for point in self.graphs.messages[-1].points
                  if math.hypot(point.x - IN_THE_WAY[0], point.y - IN_THE_WAY[1]) < 0.4 + 0.2]
        self.assertEqual(inside, [])

    def detour(self) -> PlannedPath:
        """The last path round the obstacle, as another robot tells it."""
        message = self.paths.messages[-1]
        return planned("blue", points(message.path), temporary=True)


def points(path: Path) -> List[Tuple[float, float]]:
    return [(item.pose.position.x, item.pose.position.y) for item in path.poses]


if __name__ == "__main__":
    rospy.init_node("overlay_test")
    rostest.rosrun("social_fleet", "overlay", OverlayTest)
