"""The node robot_launcher: tracker and navigator of every robot of a scenario, which no launch file can list."""

from dataclasses import dataclass
from typing import Any, Dict, Tuple

import rospy

from social_fleet.errors import InvalidParameter
from social_fleet.parameters import parameter
from social_fleet.ros import parameters
from social_fleet.ros.paths import resolve_path
from social_fleet.ros.robot_programs import RobotPrograms, body_parameters
from social_fleet.scenario.files import load_scenario


@dataclass(frozen=True)
class RobotLauncherParameters:
    """Parameters of the node; `tracker` and `navigator` beside them are mappings of parameters for all of these."""

    scenario: str = ""  # a scenario file whose robots get trackers
    robots: Tuple[str, ...] = ()  # names of further robots
    navigators: bool = False  # start a navigator for each, too
    respawn_delay: float = parameter(0.0, minimum=0.0)  # a process that ends is started anew after so long; 0: not [s]


class RobotLauncher:
    """Starts trackers and navigators in the robots' namespaces below its own, and ends them with itself.

    Parameters
        `RobotLauncherParameters`.
    """

    def __init__(self) -> None:
        config, others = parameters.split_private(RobotLauncherParameters)
        prefix = parameters.private_prefix()
        tracker, navigator = others.pop("tracker", {}), others.pop("navigator", {})
        if others:
            raise InvalidParameter("there is no such parameter", field=prefix + sorted(others)[0])
        robots: Dict[str, Dict[str, Any]] = {name: {} for name in config.robots}
        if config.scenario:
            scenario = load_scenario(resolve_path(config.scenario))
            robots.update((spec.name, body_parameters(spec)) for spec in scenario.robots)
        if not robots:
            raise InvalidParameter("names no robot; name robots or a scenario file", field=f"{prefix}robots")
        self._programs = RobotPrograms(respawn_delay=config.respawn_delay)
        for name, body in robots.items():
            self._programs.start(name, "trajectory_tracker", {**tracker, **body})
            if config.navigators:
                self._programs.start(name, "navigator", navigator)

    def spin(self) -> int:
        """Watch the processes until shutdown."""
        while not rospy.is_shutdown():
            self._programs.watch()
            rospy.rostime.wallsleep(0.2)
        return 0
