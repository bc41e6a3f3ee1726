#!/usr/bin/env python3
"""The robot arrives on the other planner's paths, and the log says whose they are."""

import unittest

import actionlib
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from nav_msgs.msg import Path
from rosgraph_msgs.msg import Log
from support import Listener, stamped, wait_until


class FallbackTest(unittest.TestCase):
    """There is no social_planner at all."""

    def test_the_robot_arrives(self) -> None:
        log, plans = Listener("/rosout", Log), Listener("gold/move_base/SocialGlobalPlanner/plan", Path)
        client = actionlib.SimpleActionClient("gold/move_base", MoveBaseAction)
        self.assertTrue(client.wait_for_server(rospy.Duration(60.0)))
        client.send_goal(MoveBaseGoal(target_pose=stamped(5.0, 8.0)))
        wait_until(lambda: client.get_state() not in (GoalStatus.PENDING, GoalStatus.ACTIVE), "the goal", 80.0)
        self.assertEqual(client.get_state(), GoalStatus.SUCCEEDED, client.get_goal_status_text())
        self.assertTrue(plans.wait().poses)
        self.assertTrue(any("asking navfn/NavfnROS instead" in message.msg for message in log.messages))


if __name__ == "__main__":
    rospy.init_node("fallback_test")
    rostest.rosrun("social_fleet", "fallback", FallbackTest)
