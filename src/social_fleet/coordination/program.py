"""The exact formulation: which robot goes first in each window, as a mixed-integer linear program, decomposed.

The objective and Eq. 5 are the paper's. In place of Eq. 6 and 7 stands one rule for windows of every kind: the second
robot may leave an arc length only after the first has passed the one from which it stays clear (`encounters.Order`).
Given orders, the times are longest paths (`event_graph`, `order_state`); `order_search` looks for the orders, and
bounds how good any can be. Windows whose rows the times keep anyway take part in neither. Derivation:
doc/coordination.md.
"""

import math
import time
from dataclasses import dataclass
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np

from social_fleet.coordination.encounters import Encounter, Order
from social_fleet.coordination.event_graph import EventGraph, Motion, Pace, Sides, Wait
from social_fleet.coordination.options import OUT_OF_TIME
from social_fleet.coordination.order_search import Contradiction, OrderSearch
from social_fleet.coordination.order_state import with_kept
from social_fleet.coordination.timing import Timing
from social_fleet.errors import SolverFailed, TimedOut

_AFTER = 1e-7  # from reaching an arc length to leaving it, so that who waits there has already cleared up to it [s]
_TRIES = 100  # neighbourhoods searched between two proofs
_PROOFS = 2  # calls of the master when they have been searched, ...
_NODES = 5  # ... and of its own search in each, while it has more binaries than ...
_FEW = 60  # ... this; with fewer, as many as it takes
_CROWDED = 1000  # windows of robots that have to take turns, from which on nothing is proven, ...
_TURNED_AT_FIRST = 1000  # ... but so many orders are turned round, and then, ...
_WIDE, _MOST_DIVED = 0.2, 4000  # ... where the gap is more than this share, or there are more windows, ...
_TURNED = 8000  # ... so many more; ...
_LONG = 4  # ... else so many times as many neighbourhoods are searched
_EXPLAINED = 200  # calls of the master to see whether some windows have a common order


def _left(timing: Timing, arcs: np.ndarray) -> np.ndarray:
    """The moments [s] at which a robot has left arc lengths [m]."""
    return np.minimum(timing.last_time(arcs) + _AFTER, timing.times[-1])


@dataclass(frozen=True)
class Solution:
    """Times of every robot, the order of every window (positions in `encounters`), and the bound on the objective."""

    paces: Tuple[Pace, ...]
    orders: Tuple[Order, ...]
    objective: float
    bound: float


class ExactProgram:
    """The arrivals minimised over all orders of all windows.

    Parameters
    ----------
    motions : sequence of Motion
        One per robot, in the fleet's order.
    encounters : sequence of Encounter
    margin : float
        Time between the first robot's clearing and the second's entering [s].
    makespan : bool
        Minimise the latest arrival, rather than the weighted sum of all.
    gap : float
        Relative distance to the proven bound at which a schedule is good enough.
    effort : int
        How often search and proof take turns where the gap stays open.
    solver : str, optional
        See `solvers.solve`.
    known : (W,) array, optional
        Orders that are possible together: 0 where r goes first, 1 where s does, -1 where that is not known.
    """

    def __init__(self, motions: Sequence[Motion], encounters: Sequence[Encounter], *, margin: float,
                 makespan: bool = False, gap: float = 0.0, effort: int = 1, solver: Optional[str] = None,
                 known: Optional[np.ndarray] = None) -> None:
        self.motions = motions
        self.encounters = encounters
        self.margin = margin
        self._makespan = makespan
        self._gap = gap
        self._effort = effort
        self._solver = solver
        self._known = known
        self._weights = np.array([0.0 if motion.fixed else motion.weight for motion in motions])
        # solver and search have absolute tolerances, and the latest arrival goes before any weight
        self._scale = 1.0 if makespan else float(self._weights.max(initial=0.0)) or 1.0
        self._relative = ((self._weights > 0.0) / max(np.count_nonzero(self._weights), 1) if makespan else
                          self._weights / self._scale)
        self._waits = self._find_waits()

    def solve(self, *, deadline: float, patience: float = math.inf) -> Solution:
        """Find orders for all windows, and a bound.

        Parameters
        ----------
        deadline : float
            On `time.monotonic`'s clock [s].
        patience : float
            Until some orders are found, or known not to exist [s].

        Raises
        ------
        Contradiction
            When there is no order; none of the windows named can be left out.
        TimedOut, SolverFailed
        """
        for window, waits in enumerate(self._waits):
            if waits == (None, None):
                raise Contradiction([window])
        if time.monotonic() > deadline:
            raise TimedOut(OUT_OF_TIME)
        graph = EventGraph(self.motions, self._waits, self.margin)
        first = min(deadline, time.monotonic() + patience)
        try:
            search = self._search(graph, deadline, first)
        except Contradiction as error:
            raise Contradiction(self._smallest(list(error.windows), first)) from error
        times, delay = graph.least_times(search.sides)
        if not math.isfinite(delay):
            raise SolverFailed("the orders found contradict each other")
        objective = self._objective(times[graph.offsets[1:] - 1])
        return Solution(tuple(graph.paces(times)), tuple(self._orders(search, times)), objective,
                        min(search.bound * self._scale, objective))

    def _search(self, graph: EventGraph, deadline: float, first: float) -> OrderSearch:
        """Look for orders until `deadline`, but for any at all only until `first`."""
        search = OrderSearch(graph, self.motions, self._relative, self._makespan)
        if self._known is not None:
            search.begin(self._known)
        if self._known is not None and len(self.encounters) > _CROWDED:
            self._look_without_proof(search, deadline, first)
        else:
            self._look_and_prove(search, deadline, first)
        if not math.isfinite(search.cost):
            search.prove(1 << 30, gap=self._gap, deadline=first, solver=self._solver)
        if not math.isfinite(search.cost):
            raise TimedOut(OUT_OF_TIME)
        return search

    def _look_and_prove(self, search: OrderSearch, deadline: float, first: float) -> None:
        search.improve(1, gap=self._gap, deadline=deadline)

        def end() -> float:
            return deadline if math.isfinite(search.cost) else first

        for _ in range(self._effort):
            self._prove(search, end(), calls=1)
            if search.gap <= max(self._gap, 1e-9) and math.isfinite(search.cost) or time.monotonic() > end():
                break
            search.improve(_TRIES, gap=self._gap, deadline=end())
            self._prove(search, end(), calls=_PROOFS)

    def _look_without_proof(self, search: OrderSearch, deadline: float, first: float) -> None:
        if not math.isfinite(search.cost):
            search.improve(_TRIES, gap=math.inf, deadline=first)
        if not math.isfinite(search.cost):
            return
        search.anneal(_TURNED_AT_FIRST, gap=self._gap, deadline=deadline)
        if search.gap > _WIDE or len(self.encounters) > _MOST_DIVED:
            search.anneal(self._effort * _TURNED, gap=self._gap, deadline=deadline)
        else:
            search.improve(self._effort * _LONG * _TRIES, gap=self._gap, deadline=deadline)

    def _prove(self, search: OrderSearch, deadline: float, *, calls: int) -> None:
        search.prove(calls, gap=self._gap, deadline=deadline, solver=self._solver, nodes=_NODES)
        if search.size <= _FEW:
            search.prove(_EXPLAINED, gap=self._gap, deadline=deadline, solver=self._solver)

    def _find_waits(self) -> List[Sides]:
        """What either order of each window asks for, in moments of the robots' motions."""
        orders = [order for encounter in self.encounters for order in encounter.orders if order.possible]
        ats = self._moments([(order.follower, order.at) for order in orders], _left)
        clears = self._moments([(order.leader, order.clear) for order in orders], Timing.first_time)
        waits = iter(Wait(order.leader, order.follower, at, clear) for order, at, clear in zip(orders, ats, clears))
        found: List[Sides] = []
        for encounter in self.encounters:
            r_first, s_first = (next(waits) if order.possible else None for order in encounter.orders)
            found.append((r_first, s_first))
        return found

    def _moments(self, places: Sequence[Tuple[int, np.ndarray]],
                 moment_at: Callable[[Timing, np.ndarray], np.ndarray]) -> List[np.ndarray]:
        """For each robot and its arc lengths [m] the moments [s], looked up at once for all of a robot's."""
        by_robot: Dict[int, List[int]] = {}
        for index, (robot, _) in enumerate(places):
            by_robot.setdefault(robot, []).append(index)
        found: List[np.ndarray] = [np.zeros(0)] * len(places)
        for robot, indices in by_robot.items():
            arcs = [places[index][1] for index in indices]
            moments = moment_at(self.motions[robot].timing, np.concatenate(arcs))
            for index, own in zip(indices, np.split(moments, np.cumsum([len(part) for part in arcs])[:-1])):
                found[index] = own
        return found

    def _objective(self, arrivals: np.ndarray) -> float:
        planned = arrivals[self._weights > 0.0]
        return float(planned.max(initial=0.0) if self._makespan else self._weights @ arrivals)

    def _orders(self, search: OrderSearch, times: np.ndarray) -> List[Order]:
        """The order of every window: the one chosen, or the one that the times keep."""
        kept = search.state.kept(times)
        sides = with_kept(search.sides, kept)
        if not kept[np.arange(len(sides)), sides].all():
            raise SolverFailed("the times found do not keep every window")
        return [encounter.orders[side] for encounter, side in zip(self.encounters, sides.tolist())]

    def _smallest(self, windows: List[int], deadline: float) -> List[int]:
        """Windows without a common order from which none can be left out, by halves (QuickXplain)."""
        return self._needed([], windows, deadline, proven=False) if len(windows) > 1 else windows

    def _needed(self, given: List[int], windows: List[int], deadline: float, *, proven: bool) -> List[int]:
        """Those of `windows` that contradict each other and the `given` ones."""
        if proven and self._contradict(given, deadline):
            return []
        if len(windows) == 1:
            return windows
        first, second = windows[:len(windows) // 2], windows[len(windows) // 2:]
        kept = self._needed(given + first, second, deadline, proven=True)
        return self._needed(given + kept, first, deadline, proven=bool(kept)) + kept

    def _contradict(self, windows: Sequence[int], deadline: float) -> bool:
        """Whether some windows surely have no common order."""
        if time.monotonic() > deadline:
            return False
        graph = EventGraph(self.motions, [self._waits[window] for window in windows], self.margin)
        try:
            search = OrderSearch(graph, self.motions, self._relative, self._makespan)
            search.improve(1, gap=math.inf, deadline=deadline)
            if not math.isfinite(search.cost):
                search.prove(_EXPLAINED, gap=math.inf, deadline=deadline, solver=self._solver)
        except Contradiction:
            return True
        return False
