"""Random scenarios in which much goes wrong, the same on every machine for the same seed."""

import math
import random
from dataclasses import replace
from typing import List, Optional, Sequence, Tuple

from social_fleet.errors import InvalidInput, InvalidScenario
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.random_poses import random_pose_pairs
from social_fleet.scenario.random_fleet import random_scenario
from social_fleet.scenario.scenario import Expect, RobotSpec, Scenario
from social_fleet.simulation.faults import DISPATCHER, CircleObstacle, Fault
from social_fleet.simulation.network import NetworkConfig

# What befalls a robot: the share of robots, and what is drawn with it.
_SHARES = {"pause": 0.35, "slow": 0.15, "lost": 0.1, "jump": 0.12, "drift": 0.15, "silent": 0.1, "restart": 0.1,
           "dead": 0.05, "errand": 0.12, "join": 0.08}
_BUSY = 60.0  # faults begin within so long [s]
POSITION_ERROR = 0.03  # bound of localisation's error [m]; doc/execution.md says what is guaranteed up to it
DRIFT = 0.02  # that it may drift beyond that [m]
HEADING_ERROR = 0.02  # [rad]
WALL_MARGIN = 0.14  # half of it, all that there is in tight spots, covers errors of localisation and tracking [m]


def random_faulty_scenario(grid: OccupancyGrid, robots: int, *, seed: int, map_name: str, map_path: str) -> Scenario:
    """A random fleet with random faults, obstacles, localisation errors and a bad network.

    Parameters
    ----------
    grid, robots, seed, map_name, map_path
        See `random_scenario`.

    Raises
    ------
    InvalidScenario
        When so many robots find no room on the map.
    """
    chance = random.Random(seed)
    scenario = random_scenario(grid, robots, seed=seed, map_name=map_name, map_path=map_path, mixed=True,
                               room=0.5 * WALL_MARGIN)
    faults = [fault for robot in scenario.robots for fault in _faults(robot, scenario.robots, grid, chance)]
    if chance.random() < 0.2:
        kind = chance.choice(("restart", "silent"))
        faults.append(Fault(DISPATCHER, kind, _round(chance.uniform(0.0, _BUSY)), _round(chance.uniform(1.0, 20.0))))
    network = NetworkConfig(loss=0.1, latency=0.05, late=0.1, delay=2.0, seed=seed)
    simulation = {"position_error": _round(chance.uniform(0.0, POSITION_ERROR), 3),
                  "heading_error": _round(chance.uniform(0.0, HEADING_ERROR), 3), "seed": seed}
    return replace(scenario, faults=tuple(faults), obstacles=tuple(_obstacles(scenario, grid, chance)),
                   network=network, simulation=simulation, planner={"wall_margin": WALL_MARGIN}, expect=Expect())


def _faults(robot: RobotSpec, fleet: Sequence[RobotSpec], grid: OccupancyGrid, chance: random.Random) -> List[Fault]:
    found: List[Fault] = []
    for kind, share in _SHARES.items():
        if chance.random() >= share:
            continue
        at = _round(chance.uniform(0.0, _BUSY))
        if kind == "pause":
            found.append(Fault(robot.name, kind, at, _round(chance.uniform(1.0, 60.0))))
        elif kind == "slow":
            found.append(Fault(robot.name, kind, at, _round(chance.uniform(5.0, 60.0)),
                               factor=_round(chance.uniform(0.3, 0.9))))
        elif kind in ("lost", "silent", "restart"):
            found.append(Fault(robot.name, kind, at, _round(chance.uniform(0.5, 15.0))))
        elif kind == "jump":
            found.append(Fault(robot.name, kind, at, _round(chance.uniform(0.2, 6.0)),
                               distance=_round(chance.uniform(0.3, 3.0)),
                               direction=_round(chance.uniform(-math.pi, math.pi))))
        elif kind == "drift":
            found.append(Fault(robot.name, kind, at, _round(chance.uniform(10.0, 60.0)),
                               distance=_round(chance.uniform(0.005, DRIFT), 3),
                               direction=_round(chance.uniform(-math.pi, math.pi))))
        elif kind == "errand":
            goal = _other_goal(robot, fleet, grid, chance)
            found += [] if goal is None else [Fault(robot.name, kind, at, goal=goal)]
        elif kind == "dead" or (kind == "join" and at > 1.0 and not found):
            found.append(Fault(robot.name, kind, at))
    return found


def _other_goal(robot: RobotSpec, fleet: Sequence[RobotSpec], grid: OccupancyGrid,
                chance: random.Random) -> Optional[Tuple[float, ...]]:
    """A place apart from all starts and goals; None when none is found at once."""
    space = ConfigurationSpace(grid, robot.radius + 0.5 * WALL_MARGIN)
    try:
        pairs = random_pose_pairs(space, 8, seed=chance.randrange(1 << 30))
    except InvalidInput:
        return None
    taken = [place for other in fleet for place in (other.start, other.goal)]
    for _, (x, y) in pairs:
        if all(math.hypot(x - place[0], y - place[1]) > 1.5 for place in taken):
            return _round(x, 3), _round(y, 3)
    return None


def _obstacles(scenario: Scenario, grid: OccupancyGrid, chance: random.Random) -> List[CircleObstacle]:
    """Discs that come and go, some for good, away from where robots start and end."""
    found: List[CircleObstacle] = []
    space = ConfigurationSpace(grid, 0.25)
    count = chance.randrange(4)
    try:
        pairs = random_pose_pairs(space, max(count, 1) * 3, seed=chance.randrange(1 << 30))
    except (InvalidInput, InvalidScenario):
        return []
    kept = [place[:2] for robot in scenario.robots for place in (robot.start, robot.goal)]
    kept += [fault.goal[:2] for fault in scenario.faults if fault.goal]
    for (x, y), _ in pairs:
        radius = _round(chance.uniform(0.15, 0.4))
        if len(found) == count or any(math.hypot(x - a, y - b) < 1.2 for a, b in kept):
            continue
        appears = _round(chance.uniform(0.0, _BUSY))
        lasts = math.inf if chance.random() < 0.3 else _round(chance.uniform(3.0, 60.0))
        found.append(CircleObstacle(_round(x, 3), _round(y, 3), radius, 0.0 if math.isinf(lasts) else appears,
                                    appears + lasts))
    return found


def _round(value: float, digits: int = 2) -> float:
    return round(float(value), digits)
