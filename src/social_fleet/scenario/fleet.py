"""From a scenario to a coordinated fleet: one planner per size of robot, one schedule."""

import time
from dataclasses import replace
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.replanning import PlannerReplanner
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.errors import InvalidGoal, InvalidPose, NoPath
from social_fleet.mapping.files import load_map
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.routes.social_graph import SocialGraph
from social_fleet.planning.social_cost.zones import Zone, zones_of_map
from social_fleet.scenario.locations import PACKAGE
from social_fleet.scenario.scenario import RobotSpec, Scenario

_LIMITS = ("max_acceleration", "max_turn_rate", "max_turn_acceleration")


class FleetPlanner:
    """Plans for robots of any size on one map; a planner is built when a radius is first met.

    Parameters
    ----------
    grid
        The map.
    overrides
        Parameters of `PlannerConfig` other than the radius.
    graph
        A social graph that all robots favour.
    planner
        ``social``, ``shortest`` or ``rrt_star``.
    zones
        Parts of the map with norms of their own.
    """

    def __init__(self, grid: OccupancyGrid, overrides: Optional[Mapping[str, Any]] = None, *,
                 graph: Optional[SocialGraph] = None, planner: str = "social", zones: Sequence[Zone] = ()) -> None:
        self.grid = grid
        self._overrides = dict(overrides or {})
        self._graph = graph
        self._planner = planner
        self._zones = zones
        self._by_radius: Dict[float, SocialPlanner] = {}

    def for_radius(self, radius: float) -> SocialPlanner:
        """The planner of robots with `radius` [m]."""
        if radius not in self._by_radius:
            config = PlannerConfig.from_mapping({**self._overrides, "robot_radius": radius})
            self._by_radius[radius] = SocialPlanner(self.grid, config, graph=self._graph, zones=self._zones)
        return self._by_radius[radius]

    def plan(self, spec: RobotSpec) -> Robot:
        """`spec` with its path; raises InvalidStart, InvalidGoal or NoPath."""
        plan = self.for_radius(spec.radius).plan(spec.start, spec.goal, planner=self._planner)
        limits = {name: getattr(spec, name) for name in _LIMITS if getattr(spec, name) is not None}
        return Robot(spec.name, plan, max_speed=spec.max_speed, radius=spec.radius, depart=spec.depart,
                     weight=spec.weight, **limits)


def plan_fleet(scenario: Scenario, grid: OccupancyGrid, *, planners: Optional[FleetPlanner] = None,
               progress: Optional[Callable[[int], None]] = None) -> List[Robot]:
    """A path for every robot of `scenario`, each by itself.

    Parameters
    ----------
    planners
        Planners to reuse; by default new ones with the scenario's overrides.
    progress
        Called with the number of robots planned so far.

    Raises
    ------
    InvalidStart, InvalidGoal
        With the scenario's file as source and, as field, the robot's pose.
    NoPath
        Naming the robot.
    """
    planners = planners or FleetPlanner(grid, scenario.planner, zones=zones_of_map(scenario.map_path))
    robots = []
    for index, spec in enumerate(scenario.robots):
        try:
            robots.append(planners.plan(spec))
        except InvalidPose as error:
            end = "goal" if isinstance(error, InvalidGoal) else "start"
            raise type(error)(f"robot {spec.name}: {error.message}", source=scenario.source,
                              field=f"robots[{index}].{end}") from error
        except NoPath as error:
            raise NoPath(f"robot {spec.name}: {error}") from error
        if progress is not None:
            progress(index + 1)
    return robots


def coordinate_scenario(scenario: Scenario, grid: Optional[OccupancyGrid] = None, *,
                        planners: Optional[FleetPlanner] = None,
                        partial: bool = False, progress: Optional[Callable[[int], None]] = None) -> FleetSchedule:
    """Plan and coordinate the fleet of `scenario`; robots that no schedule fits are led round the contested place.

    With `partial`, those that cannot be served are left out: see `FleetSchedule.unserved`.

    Raises
    ------
    InvalidInput
        A subclass that names file and field, when map or scenario are unusable.
    NoPath, Infeasible, TimedOut, SolverFailed
        When there is no path or no schedule.
    """
    begun = time.perf_counter()
    grid = load_map(scenario.map_path) if grid is None else grid
    planners = planners or FleetPlanner(grid, scenario.planner, zones=zones_of_map(scenario.map_path))
    robots = plan_fleet(scenario, grid, planners=planners, progress=progress)
    planning_time = time.perf_counter() - begun
    options = scenario.coordination
    fleet = coordinate(robots, mode=options.mode, formulation=options.formulation, objective=options.objective,
                       partial=partial, time_margin=options.time_margin,
                       tracking_tolerance=options.tracking_tolerance, time_limit=options.time_limit,
                       replanner=PlannerReplanner(planners.for_radius))
    map_name = scenario.map if scenario.map.startswith(PACKAGE) else scenario.map_path
    return replace(fleet, map=map_name, planning_time=fleet.planning_time + planning_time)
