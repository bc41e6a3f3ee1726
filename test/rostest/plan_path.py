#!/usr/bin/env python3
"""PlanPath against a world of two rooms, a closed one and the unknown."""

import math
import unittest
from typing import Any

import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import Point32, TransformStamped
from nav_msgs.msg import OccupancyGrid, Path
from support import Listener, drawn, service, stamped, wait_until

from social_fleet.msg import PlannedPath
from social_fleet.srv import PlanPath, PlanPathRequest, PlanPathResponse

# 0.5 m a cell: the lower room, a door 1 m wide at x = 2.5 to 3.5, the upper room, a closed cell, unknown cells.
WORLD = ("####################",
         "#...........#..#???#",
         "#...........#..#???#",
         "#...........####???#",
         "#..............????#",
         "#..............????#",
         "#####..#############",
         "#..................#",
         "#..................#",
         "#..................#",
         "#..................#",
         "####################")
BELOW, ABOVE, CLOSED, UNKNOWN = (2.0, 1.5), (2.0, 4.0), (6.95, 5.0), (8.5, 4.5)


class PlanPathTest(unittest.TestCase):
    """Tests run in the order of their names: the map comes after the first."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.plan_path = service("social_planner/plan_path", PlanPath)
        cls.map = rospy.Publisher("map", OccupancyGrid, latch=True, queue_size=1)
        cls.plans = Listener("social_planner/plan", Path)
        cls.paths = Listener("fleet/paths", PlannedPath)

    def ask(self, start: Any = BELOW, goal: Any = ABOVE, robot: str = "", **values: Any) -> PlanPathResponse:
        """A request between two positions, or poses given whole."""
        start, goal = (stamped(*end) if isinstance(end, tuple) else end for end in (start, goal))
        return self.plan_path(PlanPathRequest(robot=robot, start=start, goal=goal, **values))

    def expect(self, status: str, *words: str, **request: Any) -> PlanPathResponse:
        """Ask, and find `status` and `words` in the answer."""
        answer = self.ask(**request)
        self.assertEqual(answer.status, getattr(PlanPathResponse, status), answer.message)
        for word in words:
            self.assertIn(word, answer.message)
        self.assertEqual(bool(answer.path.poses), status == "SUCCESS")
        return answer

    def test_0_before_the_map(self) -> None:
        self.expect("NOT_INITIALIZED", "map")
        broken = drawn(WORLD, 0.5)
        broken.info.width += 1
        self.map.publish(broken)
        wait_until(lambda: self.ask().status == PlanPathResponse.MAP_ERROR, "the broken map to be refused")
        self.map.publish(drawn(WORLD, 0.5))
        wait_until(lambda: self.ask().status == PlanPathResponse.SUCCESS, "the map to arrive")

    def test_a_path_and_its_headings(self) -> None:
        answer = self.expect("SUCCESS", goal=stamped(*ABOVE, 2.0))
        poses = [item.pose for item in answer.path.poses]
        self.assertEqual((poses[0].position.x, poses[0].position.y), BELOW)
        self.assertEqual((poses[-1].position.x, poses[-1].position.y), ABOVE)
        for pose, following in zip(poses, poses[1:]):
            ahead = math.atan2(following.position.y - pose.position.y, following.position.x - pose.position.x)
            self.assertAlmostEqual(2.0 * math.atan2(pose.orientation.z, pose.orientation.w), ahead, places=6)
        self.assertAlmostEqual(2.0 * math.atan2(poses[-1].orientation.z, poses[-1].orientation.w), 2.0, places=6)
        self.assertEqual({item.header.frame_id for item in answer.path.poses}, {"map"})
        self.assertGreater(answer.length, 2.5)

    def test_what_is_published(self) -> None:
        plans, paths = len(self.plans.messages), len(self.paths.messages)
        answer = self.expect("SUCCESS", robot="gold")
        self.assertEqual(len(self.plans.wait(plans + 1).poses), len(answer.path.poses))
        self.assertEqual((self.paths.wait(paths + 1).robot, self.paths.messages[-1].radius), ("gold", 0.2))

    def test_frames(self) -> None:
        self.expect("TF_ERROR", "moon", "goal", goal=stamped(*ABOVE, frame="moon"))
        self.expect("TF_ERROR", "start", start=stamped(*BELOW, frame="odom"))
        self.expect("SUCCESS", start=stamped(*BELOW, frame="/map"))

    def test_quaternions(self) -> None:
        for end, status in (("start", "INVALID_START"), ("goal", "INVALID_GOAL")):
            for value in (0.0, 0.5, math.nan):
                pose = stamped(*(BELOW if end == "start" else ABOVE))
                pose.pose.orientation.w = value
                self.expect(status, "quaternion", end, **{end: pose})

    def test_where_no_robot_can_stand(self) -> None:
        for place in (math.nan, 1.0), (-3.0, 1.0), (0.2, 1.0), (0.6, 1.0), UNKNOWN:
            self.expect("INVALID_START", start=place)
            self.expect("INVALID_GOAL", goal=place)

    def test_no_way(self) -> None:
        self.expect("NO_PATH_FOUND", goal=CLOSED)

    def test_robots_have_their_own_radius(self) -> None:
        self.expect("NO_PATH_FOUND", "0.7", robot="wide")

    def test_tolerance(self) -> None:
        self.expect("INVALID_GOAL", goal=(2.0, 3.1))
        path = self.expect("SUCCESS", goal=(2.0, 3.1), tolerance=0.6).path
        end = path.poses[-1].pose.position
        self.assertLessEqual(math.hypot(end.x - 2.0, end.y - 3.1), 0.6)
        self.expect("INVALID_REQUEST", "tolerance", tolerance=-1.0)
        self.expect("INVALID_REQUEST", "tolerance", tolerance=math.nan)

    def test_discs_to_avoid(self) -> None:
        self.expect("SUCCESS", goal=(8.5, 1.5), avoid=[Point32(5.0, 1.5, 0.5)])
        self.expect("NO_PATH_FOUND", avoid=[Point32(3.0, 2.8, 0.5)])

    def test_present_pose(self) -> None:
        self.expect("TF_ERROR", "silver/base_link", robot="silver", start=stamped(*BELOW, frame=""))
        transform = TransformStamped(child_frame_id="gold/base_link")
        transform.header.frame_id, transform.header.stamp = "map", rospy.Time.now()
        transform.transform.translation.x, transform.transform.translation.y = 7.0, 1.5
        transform.transform.rotation.w = 1.0
        broadcaster = tf2_ros.StaticTransformBroadcaster()
        broadcaster.sendTransform(transform)
        here = wait_until(lambda: self.ask(robot="gold", start=stamped(0.0, 0.0, frame="")).path.poses, "tf")[0]
        self.assertEqual((here.pose.position.x, here.pose.position.y), (7.0, 1.5))

    def test_z_a_map_of_another_size(self) -> None:
        self.map.publish(drawn(["########", "#......#", "#......#", "########"], 1.0))
        wait_until(lambda: self.ask(goal=(6.0, 1.5)).status == PlanPathResponse.SUCCESS, "the new map")
        self.expect("INVALID_GOAL", goal=ABOVE)


if __name__ == "__main__":
    rospy.init_node("plan_path_test")
    rostest.rosrun("social_fleet", "plan_path", PlanPathTest)
