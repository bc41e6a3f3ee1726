#!/usr/bin/env python3
"""Wrong parameters, files that are not there: one logged line that names the parameter, exit code 2, no traceback."""

import subprocess
import unittest

import rosunit
from roslib.packages import find_node

CASES = (
    ("map_publisher", (), "map_file"),
    ("map_publisher", ("_map_file:=nowhere.yaml",), "nowhere.yaml"),
    ("social_planner", ("_robot_radius:=-1.0",), "robot_radius"),
    ("social_planner", ("_robot_radios:=0.3",), "robot_radios"),
    ("social_planner", ("_learn_every:=often",), "learn_every"),
    ("fleet_coordinator", ("_formulation:=fast",), "formulation"),
    ("fleet_coordinator", ("_formulation:=paper",), "formulation"),
    ("trajectory_tracker", ("_robot:=gold", "_progress_rate:=0"), "progress_rate"),
    ("trajectory_tracker", (), "robot"),
    ("trajectory_tracker", ("_robot:=gold", "_lidar/margin:=0"), "lidar/margin"),
    ("trajectory_tracker", ("_robot:=gold", "_recovery/gone:=1.0"), "recovery/gone"),
    ("navigator", (), "robot"),
    ("navigator", ("_robot:=gold", "_retry_period:=0"), "retry_period"),
    ("fleet_coordinator", ("_recovery/late:=-1",), "recovery/late"),
    ("faulty_fleet", ("_scenario:=nowhere.yaml",), "nowhere.yaml"),
    ("fake_robots", (), "robots"),
    ("fake_robots", ("_period:=.nan",), "period"),
    ("robot_launcher", ("_scenario:=nowhere.yaml",), "nowhere.yaml"),
    ("scenario_runner", ("_patience:=true",), "patience"),
    ("fleet_markers", ("_rate:=-2.0",), "rate"),
)


class BadParametersTest(unittest.TestCase):
    """One process per case, all at once."""

    def test_every_case(self) -> None:
        running = [subprocess.Popen([find_node("social_fleet", node)[0], f"__name:=case_{number}", *arguments],
                                    stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
                   for number, (node, arguments, _) in enumerate(CASES)]
        wrong = []
        try:
            for (node, arguments, word), process in zip(CASES, running):
                output, _ = process.communicate(timeout=60)
                said = [line for line in output.splitlines() if "FATAL" in line]
                if (process.returncode, len(said)) != (2, 1) or word not in said[0] or "Traceback" in output:
                    wrong.append(f"{node} {' '.join(arguments)} left with {process.returncode}:\n{output}")
        finally:
            for process in running:
                process.kill()
        self.assertFalse(wrong, "\n".join(wrong))


if __name__ == "__main__":
    rosunit.unitrun("social_fleet", "bad_parameters", BadParametersTest)
