"""Orders turned round one by one: against every order tried, from the worst to begin with."""

import itertools
import math
import time
from dataclasses import replace
from typing import Callable, List, Tuple

import numpy as np
import pytest
from fleets import street_fleet
from test_order_search import prepared, soon

from social_fleet.coordination.event_graph import EventGraph, Motion, Wait
from social_fleet.coordination.order_annealing import OrderAnnealing
from social_fleet.coordination.order_state import OrderState
from social_fleet.coordination.timing import Timing

Cost = Callable[[np.ndarray], float]


def tried(graph: EventGraph, windows: int, cost: Cost) -> List[Tuple[float, np.ndarray]]:
    """All orders that are possible together, with what they cost, best first."""
    goals = graph.offsets[1:] - 1
    found = []
    for sides in itertools.product((0, 1), repeat=windows):
        times, delay = graph.least_times(np.array(sides))
        if math.isfinite(delay):
            found.append((cost(times[goals]), np.array(sides)))
    return sorted(found, key=lambda each: each[0])


def annealed(seed: int, *, longest: bool) -> Tuple[float, float]:
    """What the best of all orders cost, and those found from the worst."""
    graph, search = prepared(street_fleet(9, seed), most=7)
    search.state.longest = longest

    def cost(arrivals: np.ndarray) -> float:
        return float(arrivals.max() if longest else arrivals.sum())

    orders = tried(graph, len(search.sides), cost)
    annealing = OrderAnnealing(search.state, orders[-1][1])
    for batch in range(10):
        annealing.run(100, 0.3 * (1.0 - batch / 10.0), seed=batch)
    times, delay = graph.least_times(annealing.best)
    arrivals = times[graph.offsets[1:] - 1]
    assert math.isfinite(delay)
    assert annealing.cost == pytest.approx(cost(arrivals) + longest * 1e-6 * arrivals.sum(), abs=1e-6)
    return orders[0][0], cost(arrivals)


@pytest.mark.parametrize("seed", range(16))
def test_the_best_orders_are_found_from_the_worst(seed: int) -> None:
    best, found = annealed(seed, longest=False)
    assert found == pytest.approx(best, abs=1e-6)


def test_the_last_arrival_is_most_often_the_soonest() -> None:
    """Only the chain of the last robot is looked at, which may end where another order would have to come first."""
    results = [annealed(seed, longest=True) for seed in range(16)]
    assert all(found >= best - 1e-6 for best, found in results)
    assert sum(found <= best + 1e-6 for best, found in results) >= 15


def test_without_heat_it_only_gets_better_and_is_repeatable() -> None:
    found = []
    for _ in range(2):
        graph, search = prepared(street_fleet(14, 0), most=60)
        search.improve(1, gap=0.0, deadline=soon())
        kept = search.state.kept(graph.least_times(search.sides)[0])
        annealing = OrderAnnealing(search.state, np.where(search.sides < 0, np.where(kept[:, 0], 0, 1), search.sides))
        costs = [search.cost]
        for batch in range(4):
            annealing.run(50, 0.0, seed=batch)
            costs.append(float(graph.least_times(annealing.best)[0][graph.offsets[1:] - 1].sum()))
            assert costs[-1] == pytest.approx(annealing.cost, abs=1e-6)
        assert costs == sorted(costs, reverse=True) and costs[-1] < costs[0]
        found.append((costs, annealing.best.tolist()))
    assert found[0] == found[1]


def test_one_under_way_is_never_held_up() -> None:
    """Two orders: the planned robot waits 9 s for the fixed one, or the fixed one would wait."""
    timing = Timing(np.array([0.0, 10.0]), np.array([0.0, 10.0]))
    motions = [Motion(timing, 0.0, fixed=True), Motion(timing, 0.0)]
    windows = [(Wait(0, 1, np.array([2.0]), np.array([9.0])), Wait(1, 0, np.array([2.0]), np.array([9.0])))]
    graph = EventGraph(motions, windows, 1.0)
    annealing = OrderAnnealing(OrderState(graph, motions, np.array([0.0, 1.0]), False), np.array([0]))
    annealing.run(100, 1.0, seed=0)
    assert annealing.best.tolist() == [0] and annealing.cost == pytest.approx(18.0)


def test_an_order_that_must_be_is_not_turned() -> None:
    timing = Timing(np.array([0.0, 10.0]), np.array([0.0, 10.0]))
    motions = [Motion(timing, 0.0), Motion(timing, 0.0)]
    both = Wait(0, 1, np.array([0.0]), np.array([9.0])), Wait(1, 0, np.array([0.0]), np.array([1.0]))
    for windows, cost in (((both[0], None), 30.0), (both, 22.0)):
        graph = EventGraph(motions, [windows], 1.0)
        annealing = OrderAnnealing(OrderState(graph, motions, np.ones(2), False), np.array([0]))
        annealing.run(50, 0.0, seed=0)
        assert annealing.cost == pytest.approx(cost)


def test_a_later_clock_changes_nothing() -> None:
    found = []
    for later in (0.0, 36000.0):
        fleet = [replace(body, depart=body.depart + later) for body in street_fleet(14, 3)]
        _, search = prepared(fleet, most=60)
        search.improve(1, gap=0.0, deadline=soon())
        before = search.cost
        search.anneal(400, gap=0.0, deadline=soon())
        assert search.cost < before - 1.0
        found.append(search.cost - len(fleet) * later)
    assert found[0] == pytest.approx(found[1], abs=1e-3)


def test_unequal_weights_count() -> None:
    """Two that cross: whoever is more urgent goes first, whatever they begin with."""
    timing = Timing(np.array([0.0, 10.0]), np.array([0.0, 10.0]))
    motions = [Motion(timing, 0.0), Motion(timing, 0.0)]
    windows = [(Wait(0, 1, np.array([4.0]), np.array([6.0])), Wait(1, 0, np.array([4.0]), np.array([6.0])))]
    graph = EventGraph(motions, windows, 1.0)
    for weights, best in (((1.0, 0.5), 0), ((0.5, 1.0), 1)):
        annealing = OrderAnnealing(OrderState(graph, motions, np.array(weights), False), np.array([1 - best]))
        annealing.run(20, 0.0, seed=0)
        assert annealing.best.tolist() == [best] and annealing.cost == pytest.approx(10.0 * 1.5 + 3.0 * 0.5)


@pytest.mark.parametrize("seed", [0, 3])
def test_the_search_takes_what_annealing_finds(seed: int) -> None:
    graph, search = prepared(street_fleet(14, seed), most=60)
    search.improve(1, gap=0.0, deadline=soon())
    before = search.cost
    search.anneal(400, gap=0.0, deadline=time.monotonic() - 1.0)
    assert search.cost == before
    search.anneal(400, gap=1.0, deadline=soon())
    assert search.cost == before, "good enough"
    search.anneal(400, gap=0.0, deadline=soon())
    times, delay = graph.least_times(search.sides)
    assert math.isfinite(delay) and search.cost < before - 1.0
    assert float(times[graph.offsets[1:] - 1].sum()) == pytest.approx(search.cost, abs=1e-6)
    assert search.state.kept(times).any(axis=1).all()
