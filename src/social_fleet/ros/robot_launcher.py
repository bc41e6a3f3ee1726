"""The node robot_launcher: one trajectory_tracker process per robot of a scenario, which a launch file cannot list."""

import os
import signal
import subprocess
import sys
from dataclasses import dataclass
from typing import Any, Dict, List, Tuple

import rospy

from social_fleet.errors import InvalidParameter
from social_fleet.ros import parameters
from social_fleet.ros.paths import resolve_path
from social_fleet.scenario.files import load_scenario

_GRACE = 5.0  # [s] of wall time that a tracker has to end


@dataclass(frozen=True)
class RobotLauncherParameters:
    """Parameters of the node; `tracker` beside them is a mapping of parameters for every tracker."""

    scenario: str = ""  # a scenario file whose robots get trackers
    robots: Tuple[str, ...] = ()  # names of further robots


class RobotLauncher:
    """Starts trackers in the robots' namespaces below its own, and ends them with itself.

    The processes stay in its process group, so that whatever ends it by force ends them, too.

    Parameters
        `RobotLauncherParameters`.
    """

    def __init__(self) -> None:
        config, others = parameters.split_private(RobotLauncherParameters)
        prefix = parameters.private_prefix()
        tracker = others.pop("tracker", {})
        if others:
            raise InvalidParameter("there is no such parameter", field=prefix + sorted(others)[0])
        names = list(config.robots)
        if config.scenario:
            names += [robot.name for robot in load_scenario(resolve_path(config.scenario)).robots]
        if not names:
            raise InvalidParameter("names no robot; name robots or a scenario file", field=f"{prefix}robots")
        self._processes: Dict[str, subprocess.Popen] = {}
        rospy.on_shutdown(self._end)
        for name in names:
            self._start(name, tracker)

    def _start(self, name: str, tracker: Dict[str, Any]) -> None:
        namespace = rospy.resolve_name(name)
        if tracker:
            rospy.set_param(f"{namespace}/trajectory_tracker", tracker)
        executable = os.path.join(os.path.dirname(os.path.abspath(sys.argv[0])), "trajectory_tracker")
        shared = [f"{topic}:={rospy.resolve_name(target)}" for topic, target in (
            ("schedule", "fleet/schedules"), ("fleet/progress", "fleet/progress"))]
        self._processes[name] = subprocess.Popen(
            [sys.executable, executable, f"__ns:={namespace}", "__name:=trajectory_tracker", *shared])

    def spin(self) -> int:
        """Watch the trackers until shutdown; each that ends before is told of once."""
        gone: List[str] = []
        while not rospy.is_shutdown():
            for name, process in self._processes.items():
                if process.poll() is not None and name not in gone and not rospy.is_shutdown():
                    gone.append(name)
                    rospy.logerr("the tracker of robot %s ended with code %d", name, process.returncode)
            rospy.rostime.wallsleep(0.2)
        return 0

    def _end(self) -> None:
        for process in self._processes.values():
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        for process in self._processes.values():
            try:
                process.wait(_GRACE)
            except subprocess.TimeoutExpired:
                process.kill()
