"""The programs of robots as child processes: started, watched, started anew, and ended with their parent."""

import os
import signal
import subprocess
import sys
import time
from typing import Any, Dict, List, Mapping, Sequence, Tuple

import rospy

from social_fleet.scenario.scenario import RobotSpec

Program = Tuple[str, str]
"""Namespace, which is the robot's name or empty for what all share, and node."""

_GRACE = 5.0  # [s] of wall time that a process has to end
_LIMITS = ("max_acceleration", "max_turn_rate", "max_turn_acceleration")
_SHARED: Mapping[str, Sequence[Tuple[str, str]]] = {
    "trajectory_tracker": (("schedule", "fleet/schedules"), ("fleet/progress", "fleet/progress"),
                           *((name, name) for name in ("fleet/following", "fleet/waiting", "fleet/reports",
                                                       "fleet/directives", "map"))),
    "navigator": (("fleet/navigation", "fleet/navigation"), ("social_planner/plan_path", "social_planner/plan_path")),
}  # what a node calls them, and what is shared by all robots


def body_parameters(spec: RobotSpec) -> Dict[str, Any]:
    """What a scenario says of a robot's body, as a tracker's parameters."""
    return {"radius": spec.radius, "max_speed": spec.max_speed, "weight": spec.weight,
            **{name: getattr(spec, name) for name in _LIMITS if getattr(spec, name)}}


class RobotPrograms:
    """Runs nodes of this package in robots' namespaces below the parent's own.

    The processes stay in its process group, so that whatever ends it by force ends them, too.

    Parameters
    ----------
    respawn_delay
        A program that ends by itself is started anew after so long [s, wall time]; 0: it is not.
    """

    def __init__(self, *, respawn_delay: float = 0.0) -> None:
        self._respawn_delay = respawn_delay
        self._processes: Dict[Program, subprocess.Popen] = {}
        self._commands: Dict[Program, List[str]] = {}
        self._ended: Dict[Program, float] = {}  # when it was seen to have ended [s, wall time]
        rospy.on_shutdown(self._end)

    def start(self, robot: str, node: str, values: Mapping[str, Any]) -> None:
        """Start `node` of `robot` with these private parameters."""
        namespace = rospy.resolve_name(robot) if robot else rospy.get_namespace().rstrip("/")
        if values:
            rospy.set_param(f"{namespace}/{node}", dict(values))
        executable = os.path.join(os.path.dirname(os.path.abspath(sys.argv[0])), node)
        shared = [f"{topic}:={rospy.resolve_name(target)}" for topic, target in _SHARED.get(node, ())]
        self._commands[robot, node] = [sys.executable, executable, f"__ns:={namespace or '/'}", f"__name:={node}",
                                       *shared]
        self.again(robot, node)

    def again(self, robot: str, node: str) -> None:
        """Start a program anew, which must have been started before."""
        self._ended.pop((robot, node), None)
        self._processes[robot, node] = subprocess.Popen(self._commands[robot, node])

    def kill(self, robot: str, node: str) -> None:
        """End a program without a chance to say goodbye, for as long as nobody starts it again."""
        process = self._processes.pop((robot, node), None)
        if process is not None:
            process.kill()
            process.wait()

    def pause(self, robot: str, node: str, paused: bool) -> None:
        """Let a program stand still, or go on."""
        process = self._processes.get((robot, node))
        if process is not None and process.poll() is None:
            process.send_signal(signal.SIGSTOP if paused else signal.SIGCONT)

    def runs(self, robot: str, node: str) -> bool:
        """Whether there is such a process."""
        process = self._processes.get((robot, node))
        return process is not None and process.poll() is None

    def watch(self) -> None:
        """Tell of each program that has ended by itself, once, and start it anew where that is wanted."""
        for (robot, node), process in list(self._processes.items()):
            if process.poll() is None or rospy.is_shutdown():
                continue
            if (robot, node) not in self._ended:
                self._ended[robot, node] = time.monotonic()
                rospy.logerr("the %s of robot %s ended with code %d", node, robot, process.returncode)
            elif self._respawn_delay and time.monotonic() - self._ended[robot, node] >= self._respawn_delay:
                self.again(robot, node)

    def _end(self) -> None:
        for process in self._processes.values():
            if process.poll() is None:
                process.send_signal(signal.SIGCONT)
                process.send_signal(signal.SIGINT)
        for process in self._processes.values():
            try:
                process.wait(_GRACE)
            except subprocess.TimeoutExpired:
                process.kill()
