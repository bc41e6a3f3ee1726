#!/usr/bin/env python3
"""A faulty run: nobody touches anything, and all arrive where they were sent last."""

import os
import sys
import unittest

import rospy
import rostest
from roslib.packages import find_node

from social_fleet.ros.faulty_fleet import FaultyFleet


class FaultyFleetTest(unittest.TestCase):
    """One run."""

    def test_all_arrive_and_none_touch(self) -> None:
        # Programs are started beside the executable: here, beside the package's.
        sys.argv[0] = os.path.join(os.path.dirname(find_node("social_fleet", "faulty_fleet")[0]), "faulty_fleet")
        verdict = FaultyFleet().run()
        self.assertTrue(verdict.passed, verdict.failures)
        self.assertEqual(len(verdict.arrived), 4)
        self.assertGreater(verdict.min_clearance, 0.0)


if __name__ == "__main__":
    rospy.init_node("faulty_fleet_test")
    rostest.rosrun("social_fleet", "faulty_fleet", FaultyFleetTest)
