"""Eq. 5-8 of the paper as printed, for comparison: robots scheduled by it may touch.

The margin delta is a time between entering moments, so slow robots follow closer than their diameter; a wait is spread
over a whole stretch; turning and acceleration take no time. `program` is the formulation to drive by.
"""

import time
from typing import Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np
import pulp

from social_fleet.coordination.encounters import Encounter
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import Schedule
from social_fleet.coordination.solvers import solve
from social_fleet.errors import Infeasible

Event = Tuple[int, float]
"""A robot's position in the fleet and an arc length [m]."""


class PaperSolution(NamedTuple):
    """Knots (arc lengths [m], times [s]) of the planned robots, who goes first (0: r), objective and bound [s]."""

    knots: List[Tuple[np.ndarray, np.ndarray]]
    sides: List[int]
    objective: float
    bound: float


def solve_as_printed(fleet: Sequence[Robot], fixed: Sequence[Schedule], encounters: Sequence[Encounter], *,
                     margin: float, solver: Optional[str], deadline: float) -> PaperSolution:
    """Solve Eq. 5-8; the last robots of `fleet` drive by the `fixed` schedules.

    Raises
    ------
    Infeasible
        The fixed boundary orders, or all orders together, contradict each other.
    """
    model = _Model(fleet, fixed, encounters, margin)
    bound = solve(model.problem, solver=solver, time_limit=deadline - time.monotonic())
    if bound is None:
        raise Infeasible("the paper's constraints have no solution on these paths: its fixed orders at starts and "
                         "goals contradict each other; the exact formulation says where")
    return PaperSolution(model.knots(), model.sides(), float(pulp.value(model.problem.objective)), bound)


class _Model:
    def __init__(self, fleet: Sequence[Robot], fixed: Sequence[Schedule], encounters: Sequence[Encounter],
                 margin: float) -> None:
        self.problem = pulp.LpProblem("as_printed", pulp.LpMinimize)
        self._fleet = fleet
        self._planned = len(fleet) - len(fixed)
        self._fixed = {self._planned + index: schedule for index, schedule in enumerate(fixed)}
        self._encounters = encounters
        self._margin = margin
        self._pairs = self._matching_events()
        self._arcs = self._event_arcs()
        self._horizon = self._big_m()
        self._times = self._add_kinematics()
        self.problem.setObjective(pulp.lpSum(self._times[robot][-1] for robot in range(self._planned)))
        self._second = [self._add_window(window) for window in range(len(encounters))]

    def knots(self) -> List[Tuple[np.ndarray, np.ndarray]]:
        """Event waypoints and arrival times, each strictly after the one before."""
        found = []
        for robot in range(self._planned):
            times = np.array([pulp.value(variable) for variable in self._times[robot]])
            times = np.maximum.accumulate(times)
            kept = np.append(True, np.diff(times) > 1e-9)
            found.append((self._arcs[robot][kept], times[kept]))
        return found

    def sides(self) -> List[int]:
        """Which robot goes first in each window."""
        return [int(round(pulp.value(second))) for second in self._second]

    def _matching_events(self) -> List[List[Tuple[Event, Event]]]:
        """K^rs: in same-direction windows, the events of either robot matched by share of the window's arc."""
        ends: Dict[int, List[float]] = {robot: [] for robot in range(len(self._fleet))}
        for encounter in self._encounters:
            ends[encounter.r] += encounter.r_extent
            ends[encounter.s] += encounter.s_extent
        pairs = []
        for encounter in self._encounters:
            found = []
            if encounter.kind == "same_direction":
                (r_low, r_high), (s_low, s_high) = encounter.r_extent, encounter.s_extent
                shares = {(arc - r_low) / (r_high - r_low) for arc in ends[encounter.r] if r_low <= arc <= r_high}
                shares |= {(arc - s_low) / (s_high - s_low) for arc in ends[encounter.s] if s_low <= arc <= s_high}
                found = [((encounter.r, r_low + share * (r_high - r_low)),
                          (encounter.s, s_low + share * (s_high - s_low))) for share in sorted(shares)]
            pairs.append(found)
        return pairs

    def _event_arcs(self) -> List[np.ndarray]:
        arcs: List[List[float]] = [[0.0, robot.path.length] for robot in self._fleet]
        for encounter, pairs in zip(self._encounters, self._pairs):
            arcs[encounter.r] += encounter.r_extent
            arcs[encounter.s] += encounter.s_extent
            for event in (event for pair in pairs for event in pair):
                arcs[event[0]].append(event[1])
        return [np.unique(own) for own in arcs]

    def _big_m(self) -> float:
        """Eq. 8, and the fixed schedules' ends, past which no planned robot has to wait."""
        latest = max([schedule.arrival_time for schedule in self._fixed.values()], default=0.0)
        departs = max(robot.depart for robot in self._fleet)
        return 2.0 * sum(robot.path.length / robot.max_speed for robot in self._fleet) + latest + departs

    def _add_kinematics(self) -> List[list]:
        """Eq. 5 and its boundary condition; constants for fixed robots."""
        times: List[list] = []
        for robot, (body, arcs) in enumerate(zip(self._fleet, self._arcs)):
            if robot in self._fixed:
                schedule = self._fixed[robot]
                times.append([float(value) for value in np.interp(arcs, schedule.arc_lengths, schedule.times)])
                continue
            own = [pulp.LpVariable(f"t_{robot:04d}_{event:05d}", body.depart) for event in range(len(arcs))]
            self.problem += own[0] == body.depart
            for before, after, span in zip(own, own[1:], np.diff(arcs)):
                self.problem += after - before >= span / body.max_speed
            times.append(own)
        return times

    def _time(self, robot: int, arc: float) -> object:
        return self._times[robot][int(np.argmin(np.abs(self._arcs[robot] - arc)))]

    def _add_window(self, window: int) -> pulp.LpVariable:
        """Eq. 6 or 7 with one binary, fixed where a start or goal decides (special cases of 3.3.2)."""
        encounter = self._encounters[window]
        r, s = encounter.r, encounter.s
        second = pulp.LpVariable(f"z_{window:05d}", cat=pulp.LpBinary)
        if encounter.r_ends[0] or encounter.s_ends[1]:
            self.problem += second == 0
        if encounter.s_ends[0] or encounter.r_ends[1]:
            self.problem += second == 1
        if encounter.kind == "same_direction":
            rows = [(pair, pair) for pair in self._pairs[window]]
        else:
            rows = [(((r, encounter.r_extent[1]), (s, encounter.s_extent[0])),
                     ((r, encounter.r_extent[0]), (s, encounter.s_extent[1])))]
        for (r_first, s_enters), (r_enters, s_first) in rows:
            self.problem += (pulp.LpAffineExpression(self._time(*r_first)) - self._time(*s_enters)
                             - self._horizon * second <= -self._margin)
            self.problem += (pulp.LpAffineExpression(self._time(*s_first)) - self._time(*r_enters)
                             + self._horizon * second <= self._horizon - self._margin)
        return second
