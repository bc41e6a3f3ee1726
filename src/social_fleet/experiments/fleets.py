"""Small fleets of an experiment: planned, coordinated, and judged, as values that a cell can keep."""

from typing import Any, Dict, List, NamedTuple, Optional, Sequence

import numpy as np

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.encounters import EncounterFinder
from social_fleet.coordination.files import schedule_from_dict, schedule_to_dict
from social_fleet.coordination.replanning import Replanner
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import EncounterWindow, FleetSchedule
from social_fleet.coordination.verification import verify
from social_fleet.errors import Infeasible
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.random_fleet import random_scenario
from social_fleet.scenario.scenario import Coordination, RobotSpec

TOLERANCE = Coordination.tracking_tolerance  # [m]
NOTICED = 0.5  # [s] later than alone, from which on a robot counts as held up


class Outcome(NamedTuple):
    """What became of a fleet.

    Attributes
    ----------
    fleet : FleetSchedule
        Its schedule; where there is none, each robot's as if it were alone, with the windows that nobody could order.
    feasible : bool
        Whether there is a schedule.
    reason : str
        Why not.
    alone : list of float
        When each robot would arrive without the others [s].
    min_clearance : float, optional
        Between any two robots' surfaces, by the independent judge [m]; None without a schedule.
    """

    fleet: FleetSchedule
    feasible: bool
    reason: str
    alone: List[float]
    min_clearance: Optional[float]

    @property
    def delays(self) -> List[float]:
        """How much later than alone each robot arrives [s]."""
        return [schedule.arrival_time - alone for schedule, alone in zip(self.fleet.schedules, self.alone)]

    @property
    def unhindered(self) -> bool:
        """Whether there is a schedule on which everybody arrives as if alone."""
        return self.feasible and max(self.delays) < NOTICED

    @property
    def contested(self) -> float:
        """Metres of both paths that the two robots of a window cannot drive at once, mean of the two, summed up."""
        return sum(0.5 * (window.r_exit - window.r_enter + window.s_exit - window.s_enter)
                   for window in self.fleet.windows if window.kind != "same_direction")

    def to_value(self) -> Dict[str, Any]:
        """Plain values, for a cell."""
        return {**self._asdict(), "fleet": schedule_to_dict(self.fleet)}

    @classmethod
    def from_value(cls, value: Dict[str, Any]) -> "Outcome":
        """What `to_value` gave."""
        return cls(schedule_from_dict(value["fleet"]), *(value[name] for name in cls._fields[1:]))


def coordinated(robots: Sequence[Robot], *, replanner: Optional[Replanner] = None) -> Outcome:
    """All robots coordinated at once, and each alone."""
    alone = [coordinate([robot]).schedules[0] for robot in robots]
    arrivals = [schedule.arrival_time for schedule in alone]
    try:
        fleet = coordinate(robots, replanner=replanner)
    except Infeasible as error:
        return Outcome(FleetSchedule(tuple(alone), tuple(windows_of(robots))), False, str(error), arrivals, None)
    clearance = verify(fleet).min_clearance
    return Outcome(fleet, True, "", arrivals, clearance if np.isfinite(clearance) else None)


def windows_of(robots: Sequence[Robot]) -> List[EncounterWindow]:
    """Where robots meet, in no order."""
    return [EncounterWindow(robots[found.r].name, robots[found.s].name, found.kind, *found.r_extent, *found.s_extent)
            for found in EncounterFinder(TOLERANCE).find(robots)]


def random_specs(grid: OccupancyGrid, names: Sequence[str], seed: int) -> List[RobotSpec]:
    """Robots of these names at random places of a map, any heading at the goal."""
    drawn = random_scenario(grid, len(names), seed=seed, map_name="", map_path="").robots
    return [RobotSpec(name, spec.start[:2], spec.goal[:2]) for name, spec in zip(names, drawn)]


def seed_of(*numbers: int) -> int:
    """A seed for each tuple of numbers, such as (the user's seed, the trial)."""
    return int(np.random.SeedSequence(numbers).generate_state(1)[0])
