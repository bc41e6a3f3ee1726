"""Eq. 5 and the waits of some windows as a mixed-integer linear program, in PuLP."""

from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np
import pulp

from social_fleet.coordination.event_graph import Motion, Sides, Wait


class GroupProgram:
    """Sum of completion times of some robots, minimised over the orders of some windows.

    Parameters
    ----------
    motions : sequence of Motion
        The whole fleet.
    robots : sequence of int
        The robots whose times are variables.
    windows : dict
        For each window, what r first and what s first ask for; None for an order that is not possible.
    margin : float
        delta [s].
    ceiling : float
        No arrival of the best schedule is later than nominal by more [s]; what big-M constants are made of.
    """

    def __init__(self, motions: Sequence[Motion], robots: Sequence[int],
                 windows: Dict[int, Sides], margin: float, ceiling: float) -> None:
        self.problem = pulp.LpProblem("social_fleet", pulp.LpMinimize)
        self._motions = motions
        self._margin = margin
        self._ceiling = ceiling
        self._windows = windows
        self._events = self._add_events(robots)
        self.problem.setObjective(pulp.lpSum(times[-1] for _, times in self._events.values()))
        self._second = {window: pulp.LpVariable(f"z_{window:05d}", cat=pulp.LpBinary)
                        for window, waits in windows.items() if None not in waits}
        for window, waits in windows.items():
            for side, wait in enumerate(waits):
                if wait is not None:
                    self._add_wait(wait, self._second.get(window), side)

    def delay(self) -> float:
        """By how much the solution delays all arrivals together [s]."""
        return float(sum(times[-1].value() - times[-1].lowBound for _, times in self._events.values()))

    def sides(self) -> Dict[int, int]:
        """Which robot goes first in each window: 0 for r, 1 for s."""
        return {window: int(round(self._second[window].value())) if window in self._second
                else int(waits[0] is None) for window, waits in self._windows.items()}

    def _add_events(self, robots: Sequence[int]) -> Dict[int, Tuple[np.ndarray, List[pulp.LpVariable]]]:
        moments: Dict[int, List[np.ndarray]] = {
            robot: [self._motions[robot].timing.times[[0, -1]]] for robot in robots}
        for waits in self._windows.values():
            for wait in filter(None, waits):
                for robot, own in ((wait.leader, wait.clear), (wait.follower, wait.at)):
                    if robot in moments:
                        moments[robot].append(own)
        events = {}
        for robot in robots:
            own = np.unique(np.concatenate(moments[robot]))
            floors = own + self._motions[robot].depart
            times = [pulp.LpVariable(f"t_{robot:04d}_{event:05d}", floor, floor + self._ceiling)
                     for event, floor in enumerate(floors)]
            for before, after, span in zip(times, times[1:], np.diff(own)):
                self.problem += after - before >= span
            events[robot] = own, times
        return events

    def _time(self, robot: int, moment: float) -> Tuple[Any, float, float]:
        """The time of a robot's event: variable or constant, with its least and greatest value."""
        if robot not in self._events:
            return moment, moment, moment
        own, times = self._events[robot]
        variable = times[int(np.searchsorted(own, moment))]
        return variable, variable.lowBound, variable.upBound

    def _add_wait(self, wait: Wait, second: Optional[pulp.LpVariable], side: int) -> None:
        for at, clear in zip(wait.at, wait.clear):
            entered, earliest_entry, _ = self._time(wait.follower, at)
            cleared, _, latest_clear = self._time(wait.leader, clear)
            if second is None:
                self.problem += pulp.LpAffineExpression(entered - cleared) >= self._margin
                continue
            slack = latest_clear + self._margin - earliest_entry
            if slack > 0.0:
                relaxed = second if side == 0 else 1 - second
                self.problem += pulp.LpAffineExpression(entered - cleared) + slack * relaxed >= self._margin
