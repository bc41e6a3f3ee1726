#!/usr/bin/env python3
"""What was recorded of a run gives the same verdict as the run, and files that say what happened."""

import json
import os
import shutil
import signal
import subprocess
import tempfile
import unittest

import rospy
import rostest
from support import wait_until

from social_fleet.cli.main import main
from social_fleet.ros.scenario_runner import ScenarioRunner


class RecordedRunTest(unittest.TestCase):
    """Gold waits for blue, which is held up on its way to the crossing."""

    def test_the_report_of_a_bag(self) -> None:
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        bag = os.path.join(folder, "run.bag")
        recorder = subprocess.Popen(["roslaunch", "social_fleet", "record.launch", f"out:={bag}"])
        self.addCleanup(recorder.wait, 30.0)
        self.addCleanup(recorder.send_signal, signal.SIGINT)
        wait_until(lambda: os.path.exists(bag + ".active"), "the recorder")
        live = ScenarioRunner().run()
        recorder.send_signal(signal.SIGINT)
        wait_until(lambda: os.path.exists(bag), "the bag")
        out = os.path.join(folder, "report")
        self.assertEqual(main(["report", bag, "--out", out]), 0)
        with open(os.path.join(out, "report.json"), encoding="utf-8") as stream:
            report = json.load(stream)
        self.assertAlmostEqual(report["min_clearance"], live.min_clearance, delta=0.02)
        self.assertEqual([robot["name"] for robot in report["robots"]], ["blue", "gold"])
        self.assertTrue(all(robot["arrived"] for robot in report["robots"]))
        with open(os.path.join(out, "events.txt"), encoding="utf-8") as stream:
            events = stream.read()
        self.assertIn("gold: waits at", events)
        self.assertIn("blue has not passed", events)
        self.assertLessEqual({"map.png", "time.png"}, set(os.listdir(out)))


if __name__ == "__main__":
    rospy.init_node("recorded_run_test")
    rostest.rosrun("social_fleet", "recorded_run", RecordedRunTest)
