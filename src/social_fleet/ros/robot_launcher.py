"""The node robot_launcher: tracker and navigator of every robot of a scenario, which no launch file can list."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from typing import Any, Dict, List, Tuple

import rospy

from social_fleet.errors import InvalidParameter
from social_fleet.parameters import parameter
from social_fleet.ros import parameters
from social_fleet.ros.paths import resolve_path
from social_fleet.scenario.files import RobotSpec, load_scenario

_GRACE = 5.0  # [s] of wall time that a process has to end
_LIMITS = ("max_acceleration", "max_turn_rate", "max_turn_acceleration")
_SHARED = {
    "trajectory_tracker": (("schedule", "fleet/schedules"), ("fleet/progress", "fleet/progress"),
                           *((name, name) for name in ("fleet/following", "fleet/waiting", "fleet/reports",
                                                       "fleet/directives", "map"))),
    "navigator": (("fleet/navigation", "fleet/navigation"), ("social_planner/plan_path", "social_planner/plan_path")),
}  # what a node calls them, and what is shared by all robots


@dataclass(frozen=True)
class RobotLauncherParameters:
    """Parameters of the node; `tracker` and `navigator` beside them are mappings of parameters for all of these."""

    scenario: str = ""  # a scenario file whose robots get trackers
    robots: Tuple[str, ...] = ()  # names of further robots
    navigators: bool = False  # start a navigator for each, too
    respawn_delay: float = parameter(0.0, minimum=0.0)  # a process that ends is started anew after so long; 0: not [s]


class RobotLauncher:
    """Starts trackers and navigators in the robots' namespaces below its own, and ends them with itself.

    The processes stay in its process group, so that whatever ends it by force ends them, too.

    Parameters
        `RobotLauncherParameters`.
    """

    def __init__(self) -> None:
        config, others = parameters.split_private(RobotLauncherParameters)
        prefix = parameters.private_prefix()
        given = {"trajectory_tracker": others.pop("tracker", {}), "navigator": others.pop("navigator", {})}
        if others:
            raise InvalidParameter("there is no such parameter", field=prefix + sorted(others)[0])
        robots: Dict[str, Dict[str, Any]] = {name: {} for name in config.robots}
        if config.scenario:
            robots.update((spec.name, _body(spec)) for spec in load_scenario(resolve_path(config.scenario)).robots)
        if not robots:
            raise InvalidParameter("names no robot; name robots or a scenario file", field=f"{prefix}robots")
        self._respawn_delay = config.respawn_delay
        self._processes: Dict[Tuple[str, str], subprocess.Popen] = {}
        self._commands: Dict[Tuple[str, str], List[str]] = {}
        self._ended: Dict[Tuple[str, str], float] = {}  # when it was seen to have ended [s, wall time]
        rospy.on_shutdown(self._end)
        for name, body in robots.items():
            self._start(name, "trajectory_tracker", {**given["trajectory_tracker"], **body})
            if config.navigators:
                self._start(name, "navigator", given["navigator"])

    def _start(self, robot: str, node: str, values: Dict[str, Any]) -> None:
        namespace = rospy.resolve_name(robot)
        if values:
            rospy.set_param(f"{namespace}/{node}", values)
        executable = os.path.join(os.path.dirname(os.path.abspath(sys.argv[0])), node)
        shared = [f"{topic}:={rospy.resolve_name(target)}" for topic, target in _SHARED[node]]
        self._commands[robot, node] = [sys.executable, executable, f"__ns:={namespace}", f"__name:={node}", *shared]
        self._processes[robot, node] = subprocess.Popen(self._commands[robot, node])

    def spin(self) -> int:
        """Watch the processes until shutdown; each that ends before is told of once, and started anew where wanted."""
        while not rospy.is_shutdown():
            for key, process in self._processes.items():
                if process.poll() is not None and not rospy.is_shutdown():
                    self._miss(key, process.returncode)
            rospy.rostime.wallsleep(0.2)
        return 0

    def _miss(self, key: Tuple[str, str], code: int) -> None:
        """A process has ended."""
        if key not in self._ended:
            self._ended[key] = time.monotonic()
            rospy.logerr("the %s of robot %s ended with code %d", key[1], key[0], code)
        elif self._respawn_delay and time.monotonic() - self._ended[key] >= self._respawn_delay:
            del self._ended[key]
            self._processes[key] = subprocess.Popen(self._commands[key])

    def _end(self) -> None:
        for process in self._processes.values():
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        for process in self._processes.values():
            try:
                process.wait(_GRACE)
            except subprocess.TimeoutExpired:
                process.kill()


def _body(spec: RobotSpec) -> Dict[str, Any]:
    """What a scenario says of a robot's body."""
    return {"radius": spec.radius, "max_speed": spec.max_speed, "weight": spec.weight,
            **{name: getattr(spec, name) for name in _LIMITS if getattr(spec, name)}}
