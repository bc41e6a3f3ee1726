"""The exact formulation: which robot goes first in each window, as a mixed-integer linear program.

The objective and Eq. 5 are the paper's. In place of Eq. 6 and 7 stands one rule for windows of every kind: the second
robot may leave an arc length only after the first has passed the one from which it stays clear (`encounters.Order`).
Windows enter when a solution breaks them. Until none is broken, a quick search orders them (`order_search`); then
branch and bound or, where that takes too long, the program (`group_program`) proves these orders or betters them. It
is a relaxation of the full one, so its bound bounds the full optimum. Derivation: doc/coordination.md.
"""

import logging
import math
import time
from dataclasses import dataclass
from typing import Collection, Dict, FrozenSet, Iterable, List, Optional, Sequence, Tuple

import numpy as np

from social_fleet.coordination.encounters import Encounter, Order
from social_fleet.coordination.event_graph import Motion, Pace, Sides, Wait, earliest
from social_fleet.coordination.group_program import GroupProgram
from social_fleet.coordination.order_search import OrderSearch
from social_fleet.coordination.solvers import solve
from social_fleet.errors import SolverFailed, TimedOut

log = logging.getLogger(__name__)

_SLACK = 1e-6  # rounding that a wait may be missed by [s]
_AFTER = 1e-7  # from reaching an arc length to leaving it, so that who waits there has already cleared up to it [s]
_NODES = 3000  # of branch and bound, before a program is set up
_HEADROOM = 1e-3  # above the best known delay, so that the solver's rounding does not cut it off [s]


class Contradiction(Exception):
    """Some windows have no common order; `windows` are their positions."""

    def __init__(self, windows: Sequence[int]) -> None:
        self.windows = tuple(windows)
        super().__init__(f"windows {self.windows} have no common order")


@dataclass(frozen=True)
class Solution:
    """Times of every robot, the order of every window (positions in `encounters`), and the bound on the objective."""

    paces: Tuple[Pace, ...]
    orders: Tuple[Order, ...]
    objective: float
    bound: float
    rounds: int


@dataclass
class _Group:
    """Windows that share robots: their best known sides (0: r first), delay [s], and the delay proven [s]."""

    search: OrderSearch
    robots: List[int]
    sides: Dict[int, int]
    delay: float
    bound: float = 0.0
    solved: bool = False


class ExactProgram:
    """Sum of completion times minimised over all orders of all windows.

    Parameters
    ----------
    motions : sequence of Motion
        One per robot, in the fleet's order.
    encounters : sequence of Encounter
    margin : float
        Time between the first robot's clearing and the second's entering [s].
    """

    def __init__(self, motions: Sequence[Motion], encounters: Sequence[Encounter], *, margin: float,
                 solver: Optional[str] = None) -> None:
        self.motions = motions
        self.encounters = encounters
        self.margin = margin
        self._solver = solver
        self._waits: List[Sides] = [(self._wait(encounter.r_first), self._wait(encounter.s_first))
                                    for encounter in encounters]
        self._groups: Dict[FrozenSet[int], _Group] = {}

    def solve(self, *, deadline: float) -> Solution:
        """Solve by adding windows until none is broken.

        Parameters
        ----------
        deadline : float
            On `time.monotonic`'s clock [s].

        Raises
        ------
        Contradiction
            When there is no order; the windows named are a smallest such set.
        TimedOut, SolverFailed
        """
        for window, waits in enumerate(self._waits):
            if waits == (None, None):
                raise Contradiction([window])
        added: List[int] = []
        best: Optional[Solution] = None
        rounds = 0
        while True:
            rounds += 1
            try:
                solution, broken, bettered = self._round(added, rounds, deadline)
            except TimedOut:
                if best is None:
                    raise
                return best
            added += broken
            if not broken and (best is None or solution.objective < best.objective + _SLACK):
                best = solution
            if best is not None and not broken and not bettered:
                return best

    def _round(self, added: Sequence[int], rounds: int, deadline: float) -> Tuple[Solution, List[int], bool]:
        """Times for the windows added so far, the windows that they break, and whether better orders are known now."""
        if time.monotonic() > deadline:
            raise TimedOut(f"no schedule within the time limit after {rounds - 1} rounds; allow more time")
        groups = [self._group(windows, deadline) for windows in self._grouped(added)]
        first = {window: side for group in groups for window, side in group.sides.items()}
        chosen = [self._waits[window][side] for window, side in first.items()]
        paces = earliest(self.motions, [wait for wait in chosen if wait is not None], self.margin)
        if paces is None:
            raise SolverFailed("the solver's orders contradict each other")
        orders, broken = self._read_orders(paces, first)
        bettered = not broken and any([self._improve(group, deadline) for group in groups])
        bound = self._nominal(range(len(self.motions))) + sum(group.bound for group in groups)
        return Solution(tuple(paces), tuple(orders), self._objective(paces), bound, rounds), broken, bettered

    def _wait(self, order: Order) -> Optional[Wait]:
        if not order.possible:
            return None
        leader, follower = self.motions[order.leader].timing, self.motions[order.follower].timing
        at = np.minimum(follower.last_time(order.at) + _AFTER, follower.times[-1])
        return Wait(order.leader, order.follower, at, leader.first_time(order.clear))

    def _objective(self, paces: Sequence[Pace]) -> float:
        return sum(float(pace.leave[-1]) for pace, motion in zip(paces, self.motions) if not motion.fixed)

    def _kept(self, wait: Optional[Wait], paces: Sequence[Pace]) -> bool:
        """Whether the times keep a wait at each of its moments."""
        if wait is None:
            return False
        cleared = paces[wait.leader].arrival(wait.clear)
        entered = paces[wait.follower].departure(wait.at)
        return bool((entered >= cleared + self.margin - _SLACK).all())

    def _read_orders(self, paces: Sequence[Pace], chosen: Dict[int, int]) -> Tuple[List[Order], List[int]]:
        """The order that the times show in each window, and the windows where they show none."""
        orders, broken = [], []
        for window, (encounter, waits) in enumerate(zip(self.encounters, self._waits)):
            if window in chosen:
                orders.append(encounter.orders[chosen[window]])
                continue
            sides = [side for side in (0, 1) if self._kept(waits[side], paces)]
            if sides:
                orders.append(encounter.orders[sides[0]])
            else:
                broken.append(window)
        return orders, broken

    def _grouped(self, windows: Sequence[int]) -> List[FrozenSet[int]]:
        """Windows in groups that share no robot still to be planned."""
        parents = list(range(len(self.motions)))

        def root(robot: int) -> int:
            while parents[robot] != robot:
                robot = parents[robot]
            return robot

        for window in windows:
            encounter = self.encounters[window]
            if not self.motions[encounter.s].fixed:
                parents[root(encounter.s)] = root(encounter.r)
        groups: Dict[int, List[int]] = {}
        for window in sorted(windows):
            groups.setdefault(root(self.encounters[window].r), []).append(window)
        return [frozenset(group) for group in groups.values()]

    def _group(self, windows: FrozenSet[int], deadline: float) -> "_Group":
        """Good orders of some windows; the program's, where the quick search finds none."""
        if windows not in self._groups:
            ordered = sorted(windows)
            search = OrderSearch(self.motions, [self._waits[window] for window in ordered], self.margin)
            delay, sides = search.best()
            robots = sorted({robot for window in windows for robot in
                             (self.encounters[window].r, self.encounters[window].s)
                             if not self.motions[robot].fixed})
            self._groups[windows] = _Group(search, robots, dict(zip(ordered, sides.tolist())), delay)
            if not math.isfinite(delay):
                self._improve(self._groups[windows], deadline)
        return self._groups[windows]

    def _improve(self, group: "_Group", deadline: float) -> bool:
        """Prove the group's orders, by branch and bound or by its program; whether that gave better ones."""
        if group.solved:
            return False
        if self._solver is None:
            better = self._branch(group, deadline)
            if better or group.solved:
                return better
        group.solved = True
        known = math.isfinite(group.delay)
        windows = {window: self._waits[window] for window in group.sides}
        program = GroupProgram(self.motions, group.robots, windows, self.margin,
                               group.delay + _HEADROOM if known else self._horizon(windows))
        try:
            bound = solve(program.problem, solver=self._solver, time_limit=deadline - time.monotonic())
        except TimedOut:
            if not known:
                raise
            return False
        if bound is None and known:
            log.warning("the solver calls a program infeasible whose solution is known; its optimum stays unproven")
            return False
        if bound is None:
            raise Contradiction(self._smallest_contradiction(list(windows), group.robots, deadline))
        group.bound = max(bound - self._nominal(group.robots), 0.0)
        delay = program.delay()
        if known and delay > group.delay - _HEADROOM:
            return False
        group.sides, group.delay = program.sides(), delay
        return True

    def _branch(self, group: "_Group", deadline: float) -> bool:
        """Branch and bound over few nodes; whether that gave better orders. At its end the group is solved."""
        before = group.delay
        known = np.array(list(group.sides.values()))
        group.delay, sides, group.solved = group.search.prove(before, known, nodes=_NODES)
        group.sides = dict(zip(group.sides, sides.tolist()))
        if group.solved and not math.isfinite(group.delay):
            raise Contradiction(self._smallest_contradiction(list(group.sides), group.robots, deadline))
        if group.solved:
            group.bound = group.delay
        return group.delay < before

    def _nominal(self, robots: Iterable[int]) -> float:
        """Sum of the arrivals of robots that nobody hinders [s]."""
        motions = [self.motions[robot] for robot in robots]
        return sum(motion.depart + motion.timing.duration for motion in motions if not motion.fixed)

    def _horizon(self, windows: Collection[int]) -> float:
        """Eq. 8, with the margins."""
        longest = sum(max(motion.timing.duration + motion.depart, 0.0) for motion in self.motions)
        return 2.0 * longest + self.margin * len(windows)

    def _smallest_contradiction(self, windows: Sequence[int], robots: Sequence[int], deadline: float) -> List[int]:
        """A set of windows without a common order from which none can be left out (deletion filter)."""
        kept = list(windows)
        for window in windows:
            if time.monotonic() > deadline:
                break
            rest = [other for other in kept if other != window]
            program = GroupProgram(self.motions, robots, {other: self._waits[other] for other in rest},
                                   self.margin, self._horizon(windows))
            if solve(program.problem, solver=self._solver, time_limit=deadline - time.monotonic()) is None:
                kept = rest
        return kept
