#!/usr/bin/env python3
"""move_base with SocialGlobalPlanner in a hall: goals, unknown obstacles, make_plan, a planner in trouble."""

import math
import os
import signal
import time
import unittest
from typing import Any, Tuple
from xmlrpc.client import ServerProxy

import actionlib
import numpy as np
import rosgraph
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseArray, PoseStamped
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from nav_msgs.msg import OccupancyGrid, Path
from nav_msgs.srv import GetPlan
from rosgraph_msgs.msg import Log
from support import Listener, drawn, service, stamped, wait_until

from social_fleet.geometry import Polyline
from social_fleet.srv import ClearOverlay, ClearOverlayResponse, PlanPath, PlanPathRequest, PlanPathResponse

PATIENCE = 1.5  # [s] planner_patience, as in move_base.yaml
SLACK = 1.0  # [s] for a busy machine
# 0.05 m a cell: a hall of 14 m by 5 m within its walls, and a wall from east to west that leaves room at either end.
WORLD = (["#" * 284] * 2 + ["##" + "." * 280 + "##"] * 44 + ["##" + "." * 50 + "#" * 180 + "." * 50 + "##"] * 8
         + ["##" + "." * 280 + "##"] * 48 + ["#" * 284] * 2)
WEST, EAST = (2.0, 1.2), (12.0, 1.2)
CART = (7.0, 1.7)
OVERLAY = "costmap of /gold/move_base"


def with_cart(world: OccupancyGrid) -> OccupancyGrid:
    """The same with a cart of 0.6 m."""
    cells = np.array(world.data, dtype=np.int8).reshape(world.info.height, world.info.width)
    column, row = int(CART[0] / 0.05), int(CART[1] / 0.05)
    cells[row - 6:row + 6, column - 6:column + 6] = 100
    world.data = cells.ravel().tolist()
    return world


def pid_of(node: str) -> int:
    """The process of a node."""
    return int(ServerProxy(rosgraph.Master("/move_base_test").lookupNode(node)).getPid("/move_base_test")[2])


class MoveBaseTest(unittest.TestCase):
    """Tests run in the order of their names; the robot is where the one before left it."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.map = rospy.Publisher("map", OccupancyGrid, latch=True, queue_size=1)
        cls.true_map = rospy.Publisher("true_map", OccupancyGrid, latch=True, queue_size=1)
        cls.map.publish(drawn(WORLD, 0.05))
        cls.true_map.publish(drawn(WORLD, 0.05))
        cls.truth = Listener("fleet/ground_truth", PoseArray)
        cls.log = Listener("/rosout", Log)
        cls.plans = Listener("gold/move_base/SocialGlobalPlanner/plan", Path)
        cls.move_base = actionlib.SimpleActionClient("gold/move_base", MoveBaseAction)
        cls.plan_path = service("social_planner/plan_path", PlanPath)
        cls.make_plan = service("gold/move_base/SocialGlobalPlanner/make_plan", GetPlan)
        wait_until(lambda: cls.plan_path(cls.request(WEST, EAST)).status == PlanPathResponse.SUCCESS, "the map")
        wait_until(lambda: cls.make_plan(PoseStamped(), stamped(*EAST), 0.0).plan.poses, "the costmap and the map")
        assert cls.move_base.wait_for_server(rospy.Duration(60.0))

    @staticmethod
    def request(start: Tuple[float, float], goal: Tuple[float, float], **values: Any) -> PlanPathRequest:
        return PlanPathRequest(start=stamped(*start), goal=stamped(*goal), inquiry=True, **values)

    def send(self, x: float, y: float) -> None:
        goal = MoveBaseGoal()
        goal.target_pose = stamped(x, y)
        self.move_base.send_goal(goal)

    def await_goal(self) -> None:
        over = (GoalStatus.SUCCEEDED, GoalStatus.ABORTED, GoalStatus.REJECTED, GoalStatus.PREEMPTED)
        wait_until(lambda: self.move_base.get_state() in over, "the goal", 90.0)
        self.assertEqual(self.move_base.get_state(), GoalStatus.SUCCEEDED, self.move_base.get_goal_status_text())

    def where(self) -> Tuple[float, float]:
        pose = self.truth.messages[-1].poses[0].position
        return pose.x, pose.y

    def logged(self, words: str, since: int) -> bool:
        return any(words in message.msg for message in self.log.messages[since:])

    def test_a_goal_is_reached_on_the_social_path(self) -> None:
        expected = self.plan_path(self.request(WEST, EAST)).path
        self.send(*EAST)
        self.await_goal()
        self.assertLess(math.hypot(self.where()[0] - EAST[0], self.where()[1] - EAST[1]), 0.3)
        poses = self.plans.messages[-1].poses
        path = Polyline(np.array([(item.pose.position.x, item.pose.position.y) for item in expected.poses]))
        steps = np.linspace(0.0, path.length, 500)
        for item in poses:
            gaps = np.hypot(*(path.position(steps) - (item.pose.position.x, item.pose.position.y)).T)
            self.assertLess(gaps.min(), 0.15)
            self.assertAlmostEqual(item.pose.orientation.z ** 2 + item.pose.orientation.w ** 2, 1.0, places=6)
        gaps = [math.hypot(one.pose.position.x - other.pose.position.x, one.pose.position.y - other.pose.position.y)
                for one, other in zip(poses, poses[1:])]
        self.assertLess(max(gaps), 0.1 + 1e-6)

    def test_b_walls_are_no_obstacles_but_a_cart_is(self) -> None:
        clear = service("social_planner/clear_overlay", ClearOverlay)
        self.make_plan(PoseStamped(), stamped(*WEST), 0.0)
        self.assertEqual(clear(OVERLAY).status, ClearOverlayResponse.INVALID_REQUEST)
        self.true_map.publish(with_cart(drawn(WORLD, 0.05)))

        def is_clear() -> bool:
            plan = self.make_plan(PoseStamped(), stamped(*WEST), 0.0).plan.poses
            return bool(plan) and all(math.hypot(item.pose.position.x - CART[0], item.pose.position.y - CART[1]) > 0.5
                                      for item in plan)
        self.send(9.0, 1.2)
        self.await_goal()
        wait_until(is_clear, "plans to go round the cart")
        blind = self.plan_path(self.request(self.where(), WEST)).path.poses
        self.assertLess(min(math.hypot(item.pose.position.x - CART[0], item.pose.position.y - CART[1])
                            for item in blind), 0.6)  # others' plans do not know of it
        self.send(*WEST)
        self.await_goal()

    def test_c_make_plan(self) -> None:
        """As doc/move_base.md has it in its table."""
        self.assertTrue(self.make_plan(PoseStamped(), stamped(*EAST), 0.0).plan.poses)  # from where the robot is
        self.assertEqual(self.make_plan(PoseStamped(), stamped(*EAST), 0.0).plan.header.frame_id, "map")
        in_the_wall = stamped(7.0, 2.6)
        self.assertEqual(self.make_plan(stamped(*WEST), in_the_wall, 0.0).plan.poses, [])
        plan = self.make_plan(stamped(*WEST), in_the_wall, 1.0).plan.poses
        end = plan[-1].pose.position
        self.assertLess(math.hypot(end.x - 7.0, end.y - 2.6), 1.0)
        for refused in (stamped(7.0, 30.0), stamped(*EAST, frame="elsewhere"), PoseStamped()):
            self.assertEqual(self.make_plan(stamped(*WEST), refused, 0.5).plan.poses, [])
        unturned = stamped(*EAST)
        unturned.pose.orientation.w = 0.0
        self.assertEqual(self.make_plan(stamped(*WEST), unturned, 0.0).plan.poses, [])

    def test_d_make_plan_while_driving(self) -> None:
        self.send(*EAST)
        wait_until(lambda: self.where()[0] > WEST[0] + 0.5, "the robot to drive")
        own = service("gold/move_base/make_plan", GetPlan)
        self.assertTrue(self.make_plan(stamped(*WEST), stamped(*EAST), 0.0).plan.poses)
        with self.assertRaises(rospy.ServiceException):
            own(PoseStamped(), stamped(*EAST), 0.0)
        self.move_base.cancel_all_goals()
        wait_until(lambda: self.move_base.get_state() == GoalStatus.PREEMPTED, "the robot to stop")
        self.assertTrue(own(PoseStamped(), stamped(*EAST), 0.0).plan.poses)

    def test_e_a_planner_that_hangs_is_no_hang(self) -> None:
        process, since = pid_of("/social_planner"), len(self.log.messages)
        os.kill(process, signal.SIGSTOP)
        try:
            for _ in range(3):
                begun = time.monotonic()
                self.assertEqual(self.make_plan(stamped(*WEST), stamped(*EAST), 0.0).plan.poses, [])
                self.assertLess(time.monotonic() - begun, PATIENCE + SLACK)
            self.send(*EAST)
            wait_until(lambda: self.logged("no answer within 1.5", since), "the reason to be told")
        finally:
            os.kill(process, signal.SIGCONT)
        self.await_goal()

    def test_f_a_planner_that_dies_and_returns(self) -> None:
        process, since = pid_of("/social_planner"), len(self.log.messages)
        os.kill(process, signal.SIGKILL)
        self.send(*WEST)
        wait_until(lambda: self.logged("is the node social_planner running?", since), "the reason to be told")
        begun = time.monotonic()
        self.assertEqual(self.make_plan(stamped(*WEST), stamped(*EAST), 0.0).plan.poses, [])
        self.assertLess(time.monotonic() - begun, PATIENCE + SLACK)
        wait_until(lambda: self.logged("ready to plan", since), "the planner to be back", 60.0)
        if self.move_base.get_state() not in (GoalStatus.ACTIVE, GoalStatus.SUCCEEDED):
            self.send(*WEST)  # move_base's own patience has ended in the meantime
        wait_until(lambda: self.logged("the social planner answers again", since), "move_base to notice")
        self.await_goal()


if __name__ == "__main__":
    rospy.init_node("move_base_test")
    rostest.rosrun("social_fleet", "move_base", MoveBaseTest)
