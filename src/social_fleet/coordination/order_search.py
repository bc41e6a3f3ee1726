"""Good orders, and how good the best can be: large neighbourhoods from above, a master program from below.

`improve` keeps a solution and tries it again with the orders of a few robots open, as often as it is told to: equal
input gives equal output, on every machine. `prove` asks the master (`delay_program`) for orders, sees in `order_state`
what they really cost, tells the master why, and stops when the two meet. doc/coordination.md derives both.
"""

import itertools
import math
import time
from typing import Dict, FrozenSet, List, Optional, Sequence, Set, Tuple

import numpy as np

from social_fleet.coordination.delay_program import DelayProgram
from social_fleet.coordination.event_graph import EventGraph, Motion
from social_fleet.coordination.order_annealing import OrderAnnealing
from social_fleet.coordination.order_state import Choice, OrderState, with_kept
from social_fleet.errors import TimedOut

_FULL_CUT = 3  # orders of a cut for which all subsets are priced
_MASTER_GAP = 0.05  # of the delays, to which the master is solved while the two have not met
_BATCH = 500  # orders turned between two looks at the clock, ...
_HEAT = 0.04  # ... at first even where that costs about so much, as a share of what orders cost
_WORTH = 1e-3  # delays that differ by less are the same [s]


class Contradiction(Exception):
    """Some windows have no common order; `windows` are their positions."""

    def __init__(self, windows: Sequence[int]) -> None:
        self.windows = tuple(sorted(windows))
        super().__init__(f"windows {self.windows} have no common order")


class OrderSearch:
    """The search over the orders of a fleet's windows.

    Parameters
    ----------
    graph : EventGraph
    motions : sequence of Motion
    weights : (R,) array
        What a second of delay costs for each robot; 0 for fixed ones.
    longest : bool
        Whether the latest arrival counts, rather than the weighted sum.

    Raises
    ------
    Contradiction
        When what starts and goals demand cannot be.
    """

    def __init__(self, graph: EventGraph, motions: Sequence[Motion], weights: np.ndarray, longest: bool) -> None:
        self.state = OrderState(graph, motions, weights, longest)
        self.sides = self.state.sides.copy()
        self.cost = math.inf
        self._settle()
        self.bound = self.state.cost()
        self._unavoidable = self.state.arrivals().copy()
        self._by_time = np.argsort(self.state.entries(), kind="stable")
        self._root = self.state.given
        self._cuts: Set[FrozenSet[Choice]] = set()
        self._prices: Dict[Tuple[Choice, ...], Optional[np.ndarray]] = {(): np.zeros(len(motions))}
        self._takes_turns = False
        self._rng = np.random.RandomState(0)
        self._chains: Optional[Tuple[np.ndarray, List[np.ndarray]]] = None
        self._excluded: Set[FrozenSet[Choice]] = set()
        self._blamed: Set[int] = set()
        self._master = DelayProgram(self._unavoidable, weights, longest)

    @property
    def gap(self) -> float:
        """How far the best orders can be from the optimum, as a share of their cost."""
        return max(self.cost - self.bound, 0.0) / self.cost if 0.0 < self.cost < math.inf else 0.0

    @property
    def size(self) -> int:
        """How many windows the master knows."""
        return len(self._master.windows)

    def begin(self, sides: np.ndarray) -> None:
        """Take orders of robots that take turns, possible together (-1: open); they may be far from good."""
        self._takes_turns = True
        self._by_time = self._sequence(sides)
        completed, times = self._completed(sides)
        if completed is None:
            self._try(sides)
        else:
            self._take(self.state.cost(times), completed)

    def improve(self, rounds: int, *, gap: float, deadline: float) -> None:
        """Look for better orders, `rounds` times, until within `gap` or the deadline on `time.monotonic`'s clock."""
        rng = self._rng
        for index in range(rounds):
            if (math.isfinite(self.cost) and self.gap <= gap) or time.monotonic() > deadline:
                break
            if math.isfinite(self.cost):
                wanted = self._neighbour(rng)
            elif index == 0:
                wanted = np.full(len(self.sides), -1, dtype=np.int64)
            else:
                wanted = rng.randint(-1, 2, len(self.sides))
            if wanted is None:
                break
            self._try(wanted)

    def anneal(self, tries: int, *, gap: float, deadline: float) -> None:
        """Look for better orders than those found by turning single ones, as long as `improve` would."""
        completed, _ = self._completed(self.sides)
        if completed is None:
            return
        annealing = OrderAnnealing(self.state, completed)
        for begun in range(0, tries, _BATCH):
            if self.gap <= gap or time.monotonic() > deadline:
                break
            annealing.run(min(_BATCH, tries - begun), _HEAT * (1.0 - begun / tries), seed=begun)
            if annealing.cost < self.cost - 1e-9:
                self._take(annealing.cost, annealing.best)

    def prove(self, rounds: int, *, gap: float, deadline: float, solver: Optional[str],
              nodes: Optional[int] = None) -> None:
        """Raise the bound, and lower the cost where the master knows better.

        Parameters
        ----------
        rounds : int
            Greatest number of calls of the master.
        gap : float
            Where the search may end.
        deadline : float
            On `time.monotonic`'s clock [s].
        nodes : int, optional
            Where the master's own search ends, each time.

        Raises
        ------
        Contradiction
            No orders at all.
        """
        fresh = True
        for index in range(rounds):
            if (math.isfinite(self.cost) and self.gap <= max(gap, 1e-9)) or time.monotonic() > deadline:
                return
            if index == 0:
                for window in self.state.contested():
                    for side in (0, 1):
                        self._cut(frozenset([(int(window), side)]))
            exact = not fresh
            try:
                proposal = self._master.solve(solver=solver, time_limit=deadline - time.monotonic(),
                                              gap=0.0 if exact or gap == 0.0 else _MASTER_GAP, nodes=nodes)
            except TimedOut:
                return
            if proposal is None:
                if not math.isfinite(self.cost):
                    raise Contradiction(sorted(self._blamed))
                self.bound = self.cost
                return
            self.bound = min(max(self.bound, proposal.bound), self.cost)
            before = len(self._cuts) + len(self._excluded)
            self._follow(proposal.sides, self._unavoidable + proposal.delays)
            fresh = len(self._cuts) + len(self._excluded) > before
            if not fresh and exact:
                return

    def _settle(self) -> None:
        """Give the orders that starts and goals demand."""
        for window in np.flatnonzero(~self.state.possible.all(axis=1)):
            bad = self.state.give(int(window), int(not self.state.possible[window, 0]))
            if bad is not None:
                raise Contradiction(sorted(self.state.explain_windows(bad)))
        self.state.settle()

    def _neighbour(self, rng: np.random.RandomState) -> Optional[np.ndarray]:
        """The best orders with those of some robots open, and perhaps one of them turned round."""
        wanted = np.where(self.state.sides < 0, self.sides, -1)
        active = np.flatnonzero(wanted >= 0)
        if not len(active):
            return None
        # Good orders are late here and there, and finding out where costs more than it gains; orders of turns are not.
        chain = self._chain(rng) if self._takes_turns and rng.randint(2) else active
        turned = int(chain[rng.randint(len(chain))])
        kind = rng.randint(3)
        if kind == 0:
            robots = rng.choice(len(self._unavoidable), rng.randint(1, 5))
        else:
            robots = self.state.robots_of(turned)
        if kind != 1:
            wanted[[window for robot in robots for window in self.state.windows_of(int(robot))]] = -1
        if kind != 0:
            wanted[turned] = 1 - self.sides[turned]
        return wanted

    def _chain(self, rng: np.random.RandomState) -> np.ndarray:
        """The windows whose orders delay a robot, one that is late the sooner, in the best solution."""
        if self._chains is None:
            self._chains = self._find_chains()
        delays, chains = self._chains
        if not len(delays):
            return np.flatnonzero(self.sides >= 0)
        return chains[int(np.searchsorted(np.cumsum(delays), rng.uniform(0.0, delays.sum())))]

    def _find_chains(self) -> Tuple[np.ndarray, List[np.ndarray]]:
        """What robots are delayed by [s], weighted, and the windows that it is for."""
        state = self.state
        for window in self._by_time:
            if self.sides[window] >= 0 > state.sides[window]:
                state.give(int(window), int(self.sides[window]))
        delays = (state.arrivals() - self._unavoidable) * state.weights
        late = np.flatnonzero(delays > _WORTH)
        chains = [np.array(sorted(window for window, _ in state.explain(int(state.goals[robot])))) for robot in late]
        state.take_back(self._root)
        held = [index for index, chain in enumerate(chains) if len(chain)]
        return delays[late][held], [chains[index] for index in held]

    def _completed(self, sides: np.ndarray) -> Tuple[Optional[np.ndarray], np.ndarray]:
        """Orders of all windows, those left open by what the least times keep, and these; None where they keep none."""
        times, delay = self.state.graph.least_times(sides)
        kept = self.state.kept(times)
        possible = math.isfinite(delay) and bool(((sides >= 0) | kept.any(axis=1)).all())
        return with_kept(sides, kept) if possible else None, times

    def _try(self, wanted: np.ndarray) -> None:
        cost, sides = self.state.dive(wanted, self._by_time, self.cost)
        if cost < self.cost - 1e-9:
            self._take(cost, sides)

    def _take(self, cost: float, sides: np.ndarray) -> None:
        """Keep better orders; from now on, what costs as much counts as impossible."""
        self.cost, self.sides = cost, sides
        self._chains = None
        if self._takes_turns:
            self._by_time = self._sequence(sides)
        state = self.state
        counted = state.weights > 0.0
        if state.longest:
            latest = np.full(int(counted.sum()), cost)
        else:
            spare = cost - float(state.weights @ self._unavoidable)
            latest = self._unavoidable[counted] + spare / state.weights[counted] + _WORTH
        state.latest[counted] = np.minimum(state.latest[counted], latest)

    def _sequence(self, sides: np.ndarray) -> np.ndarray:
        """Windows as they are reached under some orders: given in this sequence, each raises times once, not often."""
        return np.argsort(self.state.entries(self.state.graph.least_times(sides)[0]), kind="stable")

    def _follow(self, proposed: Dict[int, int], arrivals: np.ndarray) -> None:
        """See what proposed orders cost, tell the master why it is more, and complete them to a solution."""
        state = self.state
        given: Dict[int, int] = {}
        complete = True
        for window in self._by_time:
            if window in proposed:
                if self._give(int(window), proposed[window]):
                    given[int(window)] = proposed[window]
                else:
                    complete = False
        known = state.arrivals().copy()
        reasons = [state.explain(int(state.goals[robot]))
                   for robot in np.flatnonzero(known > arrivals + _WORTH)] if complete else []
        for window in state.contested():
            for side in (0, 1):
                if self._give(int(window), side):
                    reasons += [state.explain(int(state.goals[robot]))
                                for robot in np.flatnonzero(state.arrivals() > known + _WORTH)]
                    state.take_back(state.given - 1)
        state.take_back(self._root)
        wanted = np.full(len(self.sides), -1, dtype=np.int64)
        wanted[list(given)] = list(given.values())
        self._try(wanted)
        for reason in reasons:
            self._cut(reason)

    def _give(self, window: int, side: int) -> bool:
        """Give an order; where it cannot be, tell the master why and leave it."""
        bad = self.state.give(window, side)
        if bad is None:
            return True
        self._blamed |= self.state.explain_windows(bad)
        self._exclude(self.state.explain(bad))
        self.state.take_back(self.state.given - 1)
        return False

    def _exclude(self, choices: FrozenSet[Choice]) -> None:
        if choices not in self._excluded:
            self._excluded.add(choices)
            self._master.exclude(choices)

    def _price(self, choices: Tuple[Choice, ...]) -> Optional[np.ndarray]:
        """Delays that some orders cause (R,) [s]; None when they cannot all be."""
        if choices not in self._prices:
            possible = all(self._give(*choice) for choice in choices)
            self._prices[choices] = self.state.arrivals() - self._unavoidable if possible else None
            self.state.take_back(self._root)
        return self._prices[choices]

    def _cut(self, choices: FrozenSet[Choice]) -> None:
        """Tell the master what some orders together cost, robot by robot."""
        if not choices or choices in self._cuts:
            return
        self._cuts.add(choices)
        ordered = tuple(sorted(choices))
        few = len(ordered) <= _FULL_CUT
        subsets = {subset: self._price(subset) for size in range(len(ordered) + 1) if few or size == len(ordered)
                   for subset in itertools.combinations(ordered, size)}
        if any(price is None for price in subsets.values()):
            return
        whole = subsets[ordered]
        assert whole is not None
        for robot in np.flatnonzero(whole > _WORTH):
            shares = _shares(ordered, subsets, int(robot)) if few else dict.fromkeys(ordered, float(whole[robot]))
            if len(ordered) == 1 or min(shares.values()) > _WORTH:
                self._master.add_delay(int(robot), float(whole[robot]), shares)


def _shares(choices: Tuple[Choice, ...], prices: Dict[Tuple[Choice, ...], Optional[np.ndarray]],
            robot: int) -> Dict[Choice, float]:
    """By how much a robot's delay falls at most with each of some orders that is not chosen, for any others chosen."""
    def price(subset: Sequence[Choice]) -> float:
        found = prices[tuple(subset)]
        assert found is not None
        return float(found[robot])

    whole = price(choices)
    shares = {choice: whole - price([other for other in choices if other != choice]) for choice in choices}
    for size in range(len(choices) - 1):
        for subset in itertools.combinations(choices, size):
            absent = [choice for choice in choices if choice not in subset]
            lack = whole - sum(shares[choice] for choice in absent) - price(subset)
            if lack > 0.0:
                for choice in absent:
                    shares[choice] += lack / len(absent)
    return shares
