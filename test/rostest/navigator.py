#!/usr/bin/env python3
"""What users of move_base expect: goals by action and by topic, preemption, cancelling, reasons, plans at any time."""

import math
import unittest
from typing import Any

import actionlib
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from move_base_msgs.msg import MoveBaseAction, MoveBaseActionFeedback, MoveBaseGoal
from nav_msgs.srv import GetPlan
from support import Listener, service, stamped, wait_until

from social_fleet.msg import NavigationStatus, Progress, RobotReport

START, FAR, NEAR = (2.0, 3.5), (27.0, 3.5), (9.0, 3.3)
ARRIVAL = 100.0  # [s] of wall time for any drive, and for what is compiled before the first


class NavigatorTest(unittest.TestCase):
    """Blue drives through a corridor at whose other end gold stands. Tests run in order of names."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.client = actionlib.SimpleActionClient("blue/move_base", MoveBaseAction)
        cls.feedback = Listener("blue/move_base/feedback", MoveBaseActionFeedback)
        cls.status, cls.progress = Listener("fleet/navigation", NavigationStatus), Listener("blue/report", RobotReport)
        cls.diagnostics = Listener("/diagnostics", DiagnosticArray)
        assert cls.client.wait_for_server(rospy.Duration(60.0)), "the action server did not come up"
        wait_until(lambda: cls.progress.messages, "the tracker")

    def send(self, x: float, y: float, **values: Any) -> None:
        self.client.send_goal(MoveBaseGoal(stamped(x, y, **values)))

    def await_end(self, state: int, *words: str) -> str:
        wait_until(lambda: self.client.get_state() not in (GoalStatus.PENDING, GoalStatus.ACTIVE), "an end", ARRIVAL)
        text: str = self.client.get_goal_status_text()
        self.assertEqual(self.client.get_state(), state, text)
        for word in words:
            self.assertIn(word, text)
        return text

    def await_driving(self) -> None:
        wait_until(lambda: self.progress.messages[-1].speed > 0.2, "blue to drive", ARRIVAL)

    def await_standing(self) -> None:
        wait_until(lambda: self.progress.messages[-1].speed == 0.0, "blue to stand")

    def assert_at(self, x: float, y: float) -> None:
        pose = self.progress.messages[-1].pose
        self.assertLess(math.hypot(pose.x - x, pose.y - y), 0.06)

    def test_1_a_goal_by_action(self) -> None:
        """Feedback tells where the robot is; plans are served on the way."""
        make_plan = service("blue/navigator/make_plan", GetPlan)
        self.send(*NEAR)
        self.await_driving()
        plan = make_plan(start=PoseStamped(), goal=stamped(*FAR), tolerance=0.0).plan
        self.assertEqual((plan.poses[-1].pose.position.x, plan.poses[-1].pose.position.y), FAR)
        self.assertGreater(plan.poses[0].pose.position.x, START[0])
        self.assertFalse(make_plan(start=PoseStamped(), goal=stamped(15.0, 0.5), tolerance=0.0).plan.poses)
        self.await_end(GoalStatus.SUCCEEDED, "arrived")
        self.assert_at(*NEAR)
        told = [message.feedback.base_position.pose.position.x for message in self.feedback.messages]
        self.assertLess(told[0], 3.0)
        self.assertGreater(max(told), 8.0)

    def test_2_a_goal_by_topic(self) -> None:
        simple = rospy.Publisher("blue/move_base_simple/goal", PoseStamped, queue_size=1)
        current = Listener("blue/current_goal", PoseStamped)
        wait_until(lambda: simple.get_num_connections(), "the navigator to listen")
        simple.publish(stamped(6.0, 3.5))
        wait_until(lambda: [1 for message in current.messages if message.pose.position.x == 6.0], "the current goal")
        wait_until(lambda: self.status.messages[-1].state == NavigationStatus.SUCCEEDED, "blue to arrive", ARRIVAL)
        self.assert_at(6.0, 3.5)

    def test_3_a_goal_takes_the_place_of_another(self) -> None:
        """The first one's client is told so; the robot drives to the second."""
        ends = []
        self.client.send_goal(MoveBaseGoal(stamped(*FAR)), done_cb=lambda state, _: ends.append(state))
        self.await_driving()
        other = actionlib.SimpleActionClient("blue/move_base", MoveBaseAction)
        self.assertTrue(other.wait_for_server(rospy.Duration(30.0)))
        other.send_goal(MoveBaseGoal(stamped(*START)))
        wait_until(lambda: ends == [GoalStatus.PREEMPTED], "the first goal to end")
        wait_until(lambda: other.get_state() == GoalStatus.SUCCEEDED, "blue to arrive", ARRIVAL)
        self.assert_at(*START)

    def test_4_a_goal_is_taken_back(self) -> None:
        self.send(*FAR)
        self.await_driving()
        self.client.cancel_goal()
        self.await_end(GoalStatus.PREEMPTED, "taken back")
        self.await_standing()
        wait_until(lambda: self.progress.messages[-1].state == Progress.ARRIVED, "the fleet to plan round it")
        self.assertLess(self.progress.messages[-1].pose.x, FAR[0])

    def test_5_what_cannot_be_is_told_with_its_reason(self) -> None:
        """And the next goal runs."""
        for goal, word in ((stamped(15.0, 0.5), "goal"), (stamped(5.0, 3.5, frame="nowhere"), "nowhere"),
                           (stamped(math.nan, 3.5), "finite")):
            self.client.send_goal(MoveBaseGoal(goal))
            self.await_end(GoalStatus.ABORTED, word)
        self.send(*NEAR)
        self.await_end(GoalStatus.SUCCEEDED)

    def test_6_states_and_diagnostics_can_be_watched(self) -> None:
        seen = [message.state for message in self.status.messages if message.robot == "blue"]
        for state in ("PLANNING", "COORDINATING", "DRIVING", "SUCCEEDED", "CANCELED", "ABORTED"):
            self.assertIn(getattr(NavigationStatus, state), seen)
        names = {status.name for message in self.diagnostics.messages for status in message.status}
        self.assertLessEqual({"blue/navigator: goal", *(f"blue/trajectory_tracker: {part}" for part in (
            "schedule", "gate", "pose", "control"))}, names)


if __name__ == "__main__":
    rospy.init_node("navigator_test")
    rostest.rosrun("social_fleet", "navigator", NavigatorTest)
