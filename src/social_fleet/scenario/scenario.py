"""What a scenario is: robots with their tasks, what will go wrong, and what is expected of the fleet."""

import math
import os
from dataclasses import dataclass, field
from typing import Any, Dict, Mapping, Optional, Sequence, Tuple

from social_fleet.coordination.robot import safety_distance
from social_fleet.errors import InvalidScenario
from social_fleet.simulation.config import SimulationConfig
from social_fleet.simulation.faults import CircleObstacle, Fault
from social_fleet.simulation.network import NetworkConfig


@dataclass(frozen=True)
class RobotSpec:
    """One robot's task.

    Attributes
    ----------
    start, goal : tuple of float
        (x, y) [m] or (x, y, yaw) [m, m, rad] in the map frame; without a yaw any heading will do.
    max_speed, radius : float
        [m/s], [m].
    depart : float
        Earliest time of motion [s].
    weight : float
        Priority: what a second of its delay costs, against 1 for others.
    max_acceleration, max_turn_rate, max_turn_acceleration : float, optional
        [m/s^2], [rad/s], [rad/s^2]; None for the defaults of `Robot`.
    """

    name: str
    start: Tuple[float, ...]
    goal: Tuple[float, ...]
    max_speed: float = 0.7
    radius: float = 0.25
    depart: float = 0.0
    weight: float = 1.0
    max_acceleration: Optional[float] = None
    max_turn_rate: Optional[float] = None
    max_turn_acceleration: Optional[float] = None


@dataclass(frozen=True)
class Coordination:
    """Options of `coordinate`; times in [s], `tracking_tolerance` in [m] per robot."""

    mode: str = "simultaneous"
    formulation: str = "exact"
    objective: str = "sum_of_completion"
    time_margin: float = 1.0
    time_limit: float = 30.0
    tracking_tolerance: float = 0.1


@dataclass(frozen=True)
class Expect:
    """What makes a run of the scenario pass.

    Attributes
    ----------
    arrived : tuple of str, optional
        The robots that must arrive; None for all.
    collisions : int
        The most that may happen.
    max_lateness, max_tracking_error : float, optional
        Bounds for every robot [s], [m]; arriving early counts like arriving late.
    """

    arrived: Optional[Tuple[str, ...]] = None
    collisions: int = 0
    max_lateness: Optional[float] = None
    max_tracking_error: Optional[float] = None


@dataclass(frozen=True)
class Scenario:
    """A scenario file's content.

    Attributes
    ----------
    map : str
        As written in the file.
    map_path : str
        Absolute path of the map's YAML file.
    planner : mapping
        Overrides of `PlannerConfig`.
    network : NetworkConfig
        How messages fare.
    simulation : mapping
        Overrides of `SimulationConfig`.
    source : str
        The file it came from; empty when made in memory.
    """

    map: str
    map_path: str
    robots: Tuple[RobotSpec, ...]
    planner: Mapping[str, Any] = field(default_factory=dict)
    coordination: Coordination = Coordination()
    obstacles: Tuple[CircleObstacle, ...] = ()
    faults: Tuple[Fault, ...] = ()
    expect: Expect = Expect()
    network: NetworkConfig = NetworkConfig()
    simulation: Mapping[str, Any] = field(default_factory=dict)
    source: str = ""

    def __post_init__(self) -> None:
        _check_names(self.robots, self.source)
        for end in ("start", "goal"):
            _check_apart(self.robots, end, self.coordination.tracking_tolerance, self.source)

    @property
    def is_undisturbed(self) -> bool:
        """Whether nothing is to go wrong."""
        return not (self.faults or self.obstacles) and self.network == NetworkConfig()

    @property
    def simulation_config(self) -> SimulationConfig:
        """Of the simulated robots."""
        return SimulationConfig.from_mapping(self.simulation)

    @property
    def name(self) -> str:
        """The file's name without folder and extension."""
        return os.path.splitext(os.path.basename(self.source))[0] or "scenario"


def _check_names(robots: Sequence[RobotSpec], source: str) -> None:
    first: Dict[str, int] = {}
    for index, robot in enumerate(robots):
        if robot.name in first:
            raise InvalidScenario(f"robots[{first[robot.name]}] has the name {robot.name} too; names must differ",
                                  source=source, field=f"robots[{index}].name")
        first[robot.name] = index


def _check_apart(robots: Sequence[RobotSpec], end: str, tolerance: float, source: str) -> None:
    """Robots stand at their starts before they depart and at their goals for ever: no two may touch there."""
    for index, robot in enumerate(robots):
        for other in robots[:index]:
            here, there = getattr(robot, end), getattr(other, end)
            distance = math.hypot(here[0] - there[0], here[1] - there[1])
            needed = safety_distance(robot.radius, other.radius, tolerance)
            if distance < needed:
                raise InvalidScenario(
                    f"robot {robot.name} would stand {distance:.2f} m from the {end} of robot {other.name}; "
                    f"their centres need {needed:.2f} m (both radii and tracking tolerances)",
                    source=source, field=f"robots[{index}].{end}")
