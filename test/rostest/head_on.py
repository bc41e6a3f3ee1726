#!/usr/bin/env python3
"""Head-on traffic in a corridor of two lanes: each keeps to its right, and neither waits."""

import unittest

import rospy
import rostest
from support import Listener

from social_fleet.msg import EncounterWindow, Progress
from social_fleet.ros.scenario_runner import ScenarioRunner


class HeadOnTest(unittest.TestCase):
    """One run."""

    def test_both_pass_without_waiting(self) -> None:
        windows, progress = Listener("fleet/windows", EncounterWindow), Listener("fleet/progress", Progress)
        report = ScenarioRunner().run()
        self.assertTrue(report.passed, report.failures)
        self.assertGreater(report.min_clearance, 0.0)
        for robot in report.robots:
            self.assertLess(abs(robot.arrival_time - robot.scheduled_time), 2.0)
            self.assertLess(robot.max_tracking_error, 0.1)
        self.assertEqual([window for window in windows.messages
                          if window.kind == EncounterWindow.OPPOSITE_DIRECTION], [])
        self.assertEqual([message for message in progress.messages if message.state == Progress.HOLDING], [])


if __name__ == "__main__":
    rospy.init_node("head_on_test")
    rostest.rosrun("social_fleet", "head_on", HeadOnTest)
