"""Schedules: when each robot is where along its path, and whom it waits for."""

from dataclasses import dataclass, replace
from typing import Dict, Optional, Tuple, Union

import numpy as np

from social_fleet.coordination.robot import Robot
from social_fleet.errors import InvalidSchedule

_OFF_PATH = 1e-3  # by which a knot may lie beyond the ends of the path [m]

KINDS = ("intersection", "opposite_direction", "same_direction")


@dataclass(frozen=True)
class Precedence:
    """Do not pass arc length `at` [m] before robot `other` has passed `other_at` [m] of its path.

    `other_version` is the version of the other's schedule that `other_at` belongs to.
    """

    at: float
    other: str
    other_at: float
    other_version: int = 0


@dataclass(frozen=True)
class EncounterWindow:
    """A stretch where two robots' discs could touch (3.3.1), as arc lengths [m] on either path."""

    robot_r: str
    robot_s: str
    kind: str  # one of KINDS
    r_enter: float
    r_exit: float
    s_enter: float
    s_exit: float
    first: str = ""  # name of the robot that goes first; empty while undecided


@dataclass(frozen=True)
class Schedule:
    """One robot's timed path: linear between its knots, standing before the first and after the last.

    Attributes
    ----------
    arc_lengths, times : (K,) arrays
        Knots: [m], never falling; [s] on the fleet's clock, strictly rising.
    precedences : tuple of Precedence
        What keeps it apart from the others whatever the clock says; ascending in `at`.
    version : int
        Version of the coordination that it comes from.
    peers : tuple of str
        The robots that must have reported this version, or a later one, before this robot passes what it is committed
        to (`Robot.committed`): those that may still follow an older one.
    """

    robot: Robot
    arc_lengths: np.ndarray
    times: np.ndarray
    precedences: Tuple[Precedence, ...] = ()
    version: int = 0
    peers: Tuple[str, ...] = ()

    def __post_init__(self) -> None:
        try:
            arcs, times = np.asarray(self.arc_lengths, dtype=float), np.asarray(self.times, dtype=float)
        except (TypeError, ValueError) as error:
            raise InvalidSchedule(f"robot {self.name}: a knot is no number") from error
        object.__setattr__(self, "arc_lengths", arcs)
        object.__setattr__(self, "times", times)
        if arcs.ndim != 1 or arcs.shape != times.shape or len(arcs) < 1:
            raise InvalidSchedule(f"robot {self.name}: arc_lengths and times must be lists of one length")
        if not (np.isfinite(arcs).all() and np.isfinite(times).all()):
            raise InvalidSchedule(f"robot {self.name}: a knot is not finite")
        if (np.diff(times) <= 0.0).any():
            raise InvalidSchedule(f"robot {self.name}: must rise from knot to knot", field="times")
        if (np.diff(arcs) < 0.0).any():
            raise InvalidSchedule(f"robot {self.name}: must not fall", field="arc_lengths")
        length = self.robot.path.length
        if arcs[0] < -_OFF_PATH or arcs[-1] > length + _OFF_PATH:
            raise InvalidSchedule(f"robot {self.name}: must lie on the path, from 0 to {length:.3f} m",
                                  field="arc_lengths")

    @property
    def name(self) -> str:
        """The robot's name."""
        return self.robot.name

    @property
    def arrival_time(self) -> float:
        """When the robot stands at its goal, turned to its goal heading [s]."""
        return float(self.times[-1])

    def arc_length(self, time: Union[float, np.ndarray]) -> Union[float, np.ndarray]:
        """Scheduled progress [m] at `time` [s]."""
        return np.interp(time, self.times, self.arc_lengths)

    def position(self, time: Union[float, np.ndarray]) -> np.ndarray:
        """Scheduled position(s) [m] at `time` [s]: shape (2,) or (M, 2)."""
        return self.robot.path.position(self.arc_length(time))

    def shifted(self, offset: float) -> "Schedule":
        """The same motion `offset` seconds later."""
        return replace(self, times=self.times + offset)


@dataclass(frozen=True)
class FleetSchedule:
    """The coordinated schedules of a fleet and how they were found.

    Attributes
    ----------
    formulation : str
        ``exact`` or ``paper``.
    objective, gap : float
        Weighted sum of completion times of the planned robots, or their makespan [s]; relative distance to the proven
        bound.
    planning_time, encounter_time, solve_time : float
        Wall times [s] of path planning (repairs included), window search, and the program.
    amended : tuple of Schedule
        Fixed schedules whose precedences changed: the robot now waits for a planned one that goes first, or no longer
        for the past schedule of one that was planned anew. Motion and version are as before; send them to their robots.
    unserved : tuple of (name, reason)
        Robots that were left out (`partial`), and what stands against serving them.
    status, message : str
        ``ok``, and what happened on the way (repairs), for people.
    """

    schedules: Tuple[Schedule, ...]
    windows: Tuple[EncounterWindow, ...] = ()
    formulation: str = "exact"
    objective: float = 0.0
    gap: float = 0.0
    planning_time: float = 0.0
    encounter_time: float = 0.0
    solve_time: float = 0.0
    map: Optional[str] = None
    status: str = "ok"
    message: str = ""
    amended: Tuple[Schedule, ...] = ()
    unserved: Tuple[Tuple[str, str], ...] = ()

    def __getitem__(self, name: str) -> Schedule:
        return self.by_name[name]

    @property
    def by_name(self) -> Dict[str, Schedule]:
        """The schedules by robot name."""
        return {schedule.name: schedule for schedule in self.schedules}

    @property
    def makespan(self) -> float:
        """When the last robot arrives [s]."""
        return max((schedule.arrival_time for schedule in self.schedules), default=0.0)

    @property
    def sum_of_completion(self) -> float:
        """Sum of all arrival times [s]."""
        return sum(schedule.arrival_time for schedule in self.schedules)
