"""The node fleet_launcher: launch files once for each robot of a fleet file, in one roslaunch."""

import json
import os
from dataclasses import dataclass
from typing import Any, Dict, List, Tuple

import roslaunch
import rospy

from social_fleet.errors import InvalidParameter
from social_fleet.parameters import parameter
from social_fleet.ros import parameters
from social_fleet.ros.fleet_file import Fleet, FleetRobot, load_fleet
from social_fleet.ros.paths import resolve_path
from social_fleet.scenario.locations import package_folder

LaunchFile = Tuple[str, List[str]]  # a file and its arguments


@dataclass(frozen=True)
class FleetLauncherParameters:
    """Parameters of the node."""

    fleet: str = ""  # the fleet file
    simulated: bool = False  # simulate all robots
    real_time_factor: float = parameter(1.0, minimum=0.0)  # of simulated robots
    true_map: str = "/map"  # topic of the map that simulated lidars see
    simulation_overrides: str = ""  # a file of the simulation's parameters that differ from its configuration


class FleetLauncher:
    """Starts map, planner and coordinator, and every robot; ends them with itself.

    Parameters
        `FleetLauncherParameters`.
    """

    def __init__(self) -> None:
        config = parameters.read_private(FleetLauncherParameters)
        if not config.fleet:
            raise InvalidParameter("is empty; name a fleet file", field=f"{parameters.private_prefix()}fleet")
        fleet = load_fleet(resolve_path(config.fleet))
        files = [_shared(fleet, config), *(_robot(name, robot) for name, robot in fleet.robots.items())]
        self._launch = roslaunch.parent.ROSLaunchParent(rospy.get_param("/run_id"), files, is_core=False,
                                                        show_summary=False)
        self._launch.start()
        rospy.loginfo("started %s", ", ".join(fleet.robots))

    def spin(self) -> int:
        """Watch over the processes until shutdown or until the last of them has ended."""
        while not rospy.is_shutdown() and not self._launch.pm.is_shutdown:
            self._launch.spin_once()
            rospy.rostime.wallsleep(0.1)
        self._launch.shutdown()
        return 0


def _shared(fleet: Fleet, config: FleetLauncherParameters) -> LaunchFile:
    """What all robots share."""
    bodies = {name: {"radius": robot.radius, "max_speed": robot.max_speed} for name, robot in fleet.robots.items()}
    localised = {robot.localization == "fake" for robot in fleet.robots.values()}
    config_folder = os.path.join(package_folder(), "config")
    given: Dict[str, Any] = {"map": fleet.map, "graph": fleet.graph, "robots": bodies}
    if config.simulated:
        if len(localised) > 1:
            raise InvalidParameter("must be fake for all robots or for none where they are simulated",
                                   field="robots.*.localization")
        given["simulated"] = {name: {**bodies[name], "start": list(robot.start)}
                              for name, robot in fleet.robots.items()}
        given["localise"] = True in localised
        given["in_step"] = all(robot.navigation in ("navigator", "tracker") for robot in fleet.robots.values())
        given["real_time_factor"] = config.real_time_factor
        given["true_map"] = config.true_map
        given["simulation_overrides"] = config.simulation_overrides
    elif True in localised:
        raise InvalidParameter("must be amcl or external where robots are not simulated",
                               field="robots.*.localization")
    if any(robot.localization == "amcl" for robot in fleet.robots.values()):
        given["planner_overrides"] = os.path.join(config_folder, "amcl_planner.yaml")
        given["coordinator_overrides"] = os.path.join(config_folder, "amcl_coordinator.yaml")
    if any(robot.navigation == "move_base" for robot in fleet.robots.values()):
        given["planner_overrides"] = os.path.join(config_folder, "move_base_planner.yaml")
    return os.path.join(package_folder(), "launch", "fleet_shared.launch"), _arguments(given)


def _robot(name: str, robot: FleetRobot) -> LaunchFile:
    """One robot: localisation and navigation."""
    x, y, yaw = robot.start
    given = {"robot": name, "x": x, "y": y, "yaw": yaw, "radius": robot.radius, "max_speed": robot.max_speed,
             "localization": robot.localization, "navigation": robot.navigation, "simulated": False, "planner": False,
             "coordinator": False}
    return os.path.join(package_folder(), "launch", "robot.launch"), _arguments(given)


def _arguments(given: Dict[str, Any]) -> List[str]:
    """As on roslaunch's command line; YAML reads JSON."""
    return [f"{name}:={value if isinstance(value, str) else json.dumps(value)}" for name, value in given.items()]
