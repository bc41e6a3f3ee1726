#!/usr/bin/env python3
"""demo.launch, headless: Figure 9's robots arrive on time, the report and the pictures are there, nothing is left."""

import json
import os
import signal
import socket
import subprocess
import tempfile
import unittest

import rosunit

_LIMIT = 140.0  # [s] of wall time


def free_port() -> int:
    """A TCP port that nothing listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class DemoTest(unittest.TestCase):
    """One run, with the figures that it has to show."""

    def test_demo(self) -> None:
        mark = f"SOCIAL_FLEET_DEMO_TEST={os.getpid()}"
        with tempfile.TemporaryDirectory() as out:
            port = free_port()
            environment = {**os.environ, "ROS_MASTER_URI": f"http://localhost:{port}",
                           **dict([mark.split("=")])}
            launch = subprocess.Popen(["roslaunch", "--port", str(port), "social_fleet", "demo.launch", f"out:={out}"],
                                      env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            try:
                output, _ = launch.communicate(timeout=_LIMIT)
            except subprocess.TimeoutExpired:
                launch.send_signal(signal.SIGINT)
                output, _ = launch.communicate()
            self.assertIn("report.json", os.listdir(out), output)
            self.assertLessEqual({"fleet.png", "space_time.png", "fleet.gif"}, set(os.listdir(out)))
            with open(os.path.join(out, "report.json"), encoding="utf-8") as stream:
                self.judge(json.load(stream), output)
        self.assertEqual(carriers(mark), [])

    def judge(self, report: dict, output: str) -> None:
        self.assertTrue(report["passed"], report["failures"])
        self.assertEqual((len(report["robots"]), report["collisions"]), (4, []))
        self.assertGreater(report["min_clearance"], 0.0)
        for robot in report["robots"]:
            self.assertLess(abs(robot["arrival_time"] - robot["scheduled_time"]), 2.0)
            self.assertLess(robot["max_tracking_error"], 0.1)
        self.assertNotIn("src/social_fleet", output)  # a traceback of ours; rospy prints some of its own


def carriers(mark: str) -> list:
    """Ids of the processes whose environment holds `mark`."""
    found = []
    for name in os.listdir("/proc"):
        try:
            with open(f"/proc/{name}/environ", "rb") as stream:
                if mark.encode() in stream.read().split(b"\0"):
                    found.append(name)
        except OSError:
            continue
    return found


if __name__ == "__main__":
    rosunit.unitrun("social_fleet", "demo", DemoTest)
