"""Better orders for fleets that take turns: single orders turned round where they delay somebody, annealed.

Late arrivals have chains of causes (`event_graph.spread`). An order on such a chain is turned round; where that closes
a cycle, orders on it are turned as well, until the times exist again. What costs more is kept, too, with a chance that
falls (simulated annealing). One try costs a pass through the events, where a dive of `order_search` prices every
contested window: with thousands of windows a hundredth.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from social_fleet.coordination import order_kernels
from social_fleet.coordination.event_graph import SPREAD, spread
from social_fleet.coordination.order_state import OrderState

_REPAIRS = 12  # further orders that are turned for one, at most
_WHOLE_PAIRS = 3  # one try in so many turns all orders of the two robots that were alike


class Pairs(NamedTuple):
    """The pair of robots of every window, and the windows of every pair: those of pair p from starts[p] on."""

    of: np.ndarray
    windows: np.ndarray
    starts: np.ndarray


class OrderAnnealing:
    """Orders of all windows, and the best of them so far.

    Parameters
    ----------
    state : OrderState
        Whose events, rows and weights these are.
    sides : (W,) array
        Orders to begin with, possible together, of every window: 0 where r goes first, 1 where s does.

    Attributes
    ----------
    best : (W,) array
    cost : float
        Of `best`, as `OrderState.cost` counts.
    """

    def __init__(self, state: OrderState, sides: np.ndarray) -> None:
        self._state = state
        self._sides = sides.copy()
        self._unavoidable = state.arrivals().copy()
        self._least = state.cost()
        edges = state.graph.edges
        self._incoming = np.argsort(edges.heads, kind="stable")
        self._in_starts = np.searchsorted(edges.heads[self._incoming], np.arange(len(state.times) + 1))
        ends = np.sort(state.robots[np.stack((edges.tails, edges.heads), axis=1)], axis=1)
        names = np.zeros(len(sides), dtype=np.int64)
        names[edges.owners] = ends[:, 0] * len(state.goals) + ends[:, 1]
        pair_of = np.unique(names, return_inverse=True)[1]
        by_pair = np.argsort(pair_of, kind="stable")
        self._pairs = Pairs(pair_of, by_pair, np.searchsorted(pair_of[by_pair], np.arange(len(sides) + 1)))
        self.best = sides.copy()
        self.cost = float("inf")

    def run(self, tries: int, temperature: float, seed: int) -> None:
        """Turn orders round so many times.

        Parameters
        ----------
        tries : int
            Passes through the events.
        temperature : float
            By how much a worse cost still has a fair chance, as a share of what orders cost.
        seed : int
        """
        state, graph = self._state, self._state.graph
        cost, best = _anneal(
            seed, tries, temperature, graph.events, graph.edges, graph.margin, self._incoming, self._in_starts,
            state.goals, self._unavoidable, self._least, state.weights, state.longest, state.possible, self._pairs,
            self._sides)
        if cost < self.cost:
            self.cost, self.best = float(cost), best


@njit(cache=True, nogil=True)
def _anneal(seed, tries, temperature, events, edges, margin, incoming, in_starts,  # type: ignore[no-untyped-def]
            goals, unavoidable, least, weights, longest, possible, pairs, sides):
    """The lowest cost that was met, and its sides; `sides` are where it ends."""
    np.random.seed(seed)
    count = len(events.floors)
    times, causes = np.empty(count), np.empty(count, np.int64)
    new_times, new_causes = np.empty(count), np.empty(count, np.int64)
    degrees, queue, found = np.empty(count, np.int64), np.empty(count, np.int64), np.empty(count, np.int64)
    turned = np.zeros(len(sides), np.bool_)
    lowest, best = np.inf, sides.copy()
    if spread(events, edges, sides, margin, times, causes, degrees, queue) != SPREAD:
        return lowest, best
    cost = order_kernels.cost(times, goals, weights, longest)
    lowest = cost
    while tries > 0:
        tries -= 1
        robot = _late_robot(times, goals, unavoidable, weights, longest)
        length = 0 if robot < 0 else _chain(goals[robot], events, edges, causes, found)
        if length == 0:
            break
        trial = sides.copy()
        turned[:] = False
        _turn(found[np.random.randint(length)], trial, possible, turned, pairs)
        if not turned.any():
            continue
        stuck = spread(events, edges, trial, margin, new_times, new_causes, degrees, queue)
        for _ in range(_REPAIRS):
            if stuck == SPREAD:
                break
            if stuck < count:
                length = _chain(stuck, events, edges, new_causes, found)
            else:
                length = _cycle(events, edges, incoming, in_starts, trial, degrees, found)
            if not _turn_one(found[:length], trial, possible, turned):
                break
            tries -= 1
            stuck = spread(events, edges, trial, margin, new_times, new_causes, degrees, queue)
        if stuck != SPREAD:
            continue
        new_cost = order_kernels.cost(new_times, goals, weights, longest)
        heat = max(temperature * (cost - least), 1e-9)
        if new_cost <= cost or np.random.random() < np.exp((cost - new_cost) / heat):
            cost = new_cost
            sides[:] = trial
            times, new_times = new_times, times
            causes, new_causes = new_causes, causes
            if cost < lowest:
                lowest = cost
                best[:] = sides
    return lowest, best


@njit(cache=True)
def _late_robot(times, goals, unavoidable, weights, longest):  # type: ignore[no-untyped-def]
    """One that orders delay, in proportion to what that costs, or the last of all; -1 where none is late."""
    robot, total = -1, 0.0
    for index in range(len(goals)):
        delay = weights[index] * (times[goals[index]] - unavoidable[index])
        if delay <= 0.0:
            continue
        if longest:
            if robot < 0 or times[goals[index]] > times[goals[robot]]:
                robot = index
        else:
            total += delay
            if np.random.random() * total < delay:
                robot = index
    return robot


@njit(cache=True)
def _chain(event, events, edges, causes, found):  # type: ignore[no-untyped-def]
    """The windows that an event's time comes from, put into `found`; how many."""
    length = 0
    while True:
        cause = causes[event]
        if cause >= 0:
            found[length] = edges.owners[cause]
            length += 1
            event = edges.tails[cause]
        elif events.first[event]:
            return length
        else:
            event -= 1


@njit(cache=True)
def _cycle(events, edges, incoming, in_starts, sides, degrees, found):  # type: ignore[no-untyped-def]
    """The windows of one cycle of waits, put into `found`; how many. Events on or behind one have `degrees` left."""
    count = len(degrees)
    seen, path = np.full(count, -1, np.int64), np.empty(count, np.int64)
    event, steps = 0, 0
    while degrees[event] == 0:
        event += 1
    while seen[event] < 0:
        seen[event] = steps
        window, before = -1, event - 1
        if events.first[event] or degrees[event - 1] == 0:
            for place in range(in_starts[event], in_starts[event + 1]):
                edge = incoming[place]
                if sides[edges.owners[edge]] == edges.chosen[edge] and degrees[edges.tails[edge]] > 0:
                    window, before = edges.owners[edge], edges.tails[edge]
                    break
        path[steps] = window
        steps += 1
        event = before
    length = 0
    for step in range(seen[event], steps):
        if path[step] >= 0:
            found[length] = path[step]
            length += 1
    return length


@njit(cache=True)
def _turn(window, sides, possible, turned, pairs):  # type: ignore[no-untyped-def]
    """Turn a window's order round, and perhaps all orders alike of the same two robots."""
    side = sides[window]
    if not possible[window, 1 - side]:
        return
    sides[window], turned[window] = 1 - side, True
    if np.random.randint(_WHOLE_PAIRS) == 0:
        pair = pairs.of[window]
        for place in range(pairs.starts[pair], pairs.starts[pair + 1]):
            other = pairs.windows[place]
            if sides[other] == side and possible[other, 1 - side]:
                sides[other], turned[other] = 1 - side, True


@njit(cache=True)
def _turn_one(windows, sides, possible, turned):  # type: ignore[no-untyped-def]
    """Turn the order of one of some windows that was not turned yet; False where there is none."""
    if len(windows) == 0:
        return False
    begin = np.random.randint(len(windows))
    for step in range(len(windows)):
        window = windows[(begin + step) % len(windows)]
        if not turned[window] and possible[window, 1 - sides[window]]:
            sides[window], turned[window] = 1 - sides[window], True
            return True
    return False
