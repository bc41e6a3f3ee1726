#!/usr/bin/env python3
"""The gate at work: the robot that is second passes only what the first has reported to have left."""

import unittest

import rospy
import rostest
from support import Listener

from social_fleet.msg import Progress, Schedule
from social_fleet.ros.scenario_runner import ScenarioRunner

_SLACK = 0.05  # what a tracker's tolerances allow [m]
_LATE = 0.15  # what a robot drives between two reports [m]


class CrossingTest(unittest.TestCase):
    """One run, judged in three ways."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.schedules = Listener("fleet/schedules", Schedule)
        cls.progress = Listener("fleet/progress", Progress)
        cls.report = ScenarioRunner().run()
        cls.by_robot = {schedule.robot: schedule for schedule in cls.schedules.messages}

    def test_all_arrive_and_none_touch(self) -> None:
        self.assertTrue(self.report.passed, self.report.failures)
        self.assertGreater(self.report.min_clearance, 0.0)

    def test_the_second_waited_for_the_first(self) -> None:
        second, = (schedule for schedule in self.by_robot.values() if schedule.precedences)
        held = [message for message in self.progress.messages if message.state == Progress.HOLDING]
        self.assertEqual({message.robot for message in held}, {second.robot})
        late = {robot.name: robot.arrival_time - robot.scheduled_time for robot in self.report.robots}
        self.assertGreater(min(late.values()), 10.0)

    def test_no_precedence_was_broken(self) -> None:
        reached = {name: 0.0 for name in self.by_robot}
        for message in self.progress.messages:
            for precedence in self.by_robot[message.robot].precedences:
                if message.arc_length > precedence.at + _SLACK:
                    self.assertGreater(reached[precedence.other] + _LATE, precedence.other_at)
            reached[message.robot] = message.arc_length


if __name__ == "__main__":
    rospy.init_node("crossing_test")
    rostest.rosrun("social_fleet", "crossing", CrossingTest)
