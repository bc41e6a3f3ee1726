"""Ways to get a random fleet to its goals, each with the time that it takes: what Figure 10 compares."""

import time
from dataclasses import replace
from typing import Any, Callable, Dict, List, Sequence

import numpy as np

from social_fleet.coordination.baselines.conflict_based import ConflictBasedSearch
from social_fleet.coordination.baselines.fleet_planner import FleetPlanner as Baseline
from social_fleet.coordination.baselines.prioritized import PrioritizedPlanner
from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.replanning import PlannerReplanner
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.coordination.verification import verify
from social_fleet.errors import Infeasible, NoPath, SolverFailed, TimedOut
from social_fleet.experiments.fleets import random_specs
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.fleet import FleetPlanner
from social_fleet.scenario.scenario import RobotSpec

PAPERS_BLOCK = 0.8  # edge of the block that the paper searches on with CBS and PP [m]
METHODS = {"ours": "ours", "cbs": "CBS", "pp": "PP", "pp_fine": "PP, full resolution"}

Solver = Callable[[Sequence[RobotSpec], float], FleetSchedule]


class FleetMethods:
    """The methods on one map, warmed up.

    Parameters
    ----------
    grid : OccupancyGrid
        The map.
    """

    def __init__(self, grid: OccupancyGrid) -> None:
        self.grid = grid
        self._planners = FleetPlanner(grid)
        blocks = max(int(round(PAPERS_BLOCK / grid.resolution)), 1)
        self._solvers: Dict[str, Solver] = {
            "ours": self._ours,
            "cbs": self._baseline(ConflictBasedSearch(coarsening=blocks)),
            "pp": self._baseline(PrioritizedPlanner(coarsening=blocks)),
            "pp_fine": self._baseline(PrioritizedPlanner(coarsening=1))}
        for method in METHODS:  # so that compilation and what is kept per map are in nobody's time
            self.attempt(method, random_specs(grid, ["a", "b"], 0), 20.0)

    def attempt(self, method: str, specs: Sequence[RobotSpec], limit: float) -> Dict[str, Any]:
        """One fleet by one method within `limit` [s], as plain values.

        ``time`` [s] is all that it takes from starts and goals to the schedule or the failure;
        ``planning_time``, ``windows_time`` and ``solving_time`` [s] are parts of it. Where it failed, ``failure`` says
        how, and no value of the schedule is there.
        """
        begun = time.perf_counter()
        try:
            fleet = self._solvers[method](specs, limit)
        except (Infeasible, NoPath, SolverFailed, TimedOut) as error:
            return {"failure": type(error).__name__, "reason": str(error), "time": time.perf_counter() - begun}
        taken = time.perf_counter() - begun
        return {"failure": None, "reason": fleet.message, "time": taken, "planning_time": fleet.planning_time,
                "windows_time": fleet.encounter_time, "solving_time": fleet.solve_time, "makespan": fleet.makespan,
                "sum_of_completion": fleet.sum_of_completion, "gap": fleet.gap,
                "min_clearance": verify(fleet).min_clearance}

    def alone(self, specs: Sequence[RobotSpec]) -> List[float]:
        """When each robot would arrive by the shortest way at full speed, met by nobody [s]."""
        planner = self._planners.for_radius(specs[0].radius)
        return [planner.plan(spec.start, spec.goal, planner="shortest").length / spec.max_speed for spec in specs]

    def _ours(self, specs: Sequence[RobotSpec], limit: float) -> FleetSchedule:
        begun = time.perf_counter()
        robots = [self._planners.plan(spec) for spec in specs]
        planning = time.perf_counter() - begun
        fleet = coordinate(robots, time_limit=max(limit - planning, 1e-3),
                           replanner=PlannerReplanner(self._planners.for_radius))
        return replace(fleet, planning_time=fleet.planning_time + planning)

    def _baseline(self, planner: Baseline) -> Solver:
        def solve(specs: Sequence[RobotSpec], limit: float) -> FleetSchedule:
            robots = [Robot(spec.name, np.array([spec.start[:2], spec.goal[:2]]), max_speed=spec.max_speed,
                            radius=spec.radius) for spec in specs]
            return planner.plan(self.grid, robots, time_limit=limit)
        return solve
