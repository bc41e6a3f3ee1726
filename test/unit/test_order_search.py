"""Orders found quickly, and proven: against every order tried one by one, and cuts against what they claim."""

import itertools
import math
import time
from typing import List, Sequence, Tuple

import numpy as np
import pytest
from fleets import robot, street_fleet

from social_fleet.coordination import order_state
from social_fleet.coordination.encounters import EncounterFinder
from social_fleet.coordination.event_graph import EventGraph, Motion, Sides, Wait
from social_fleet.coordination.order_search import Contradiction, OrderSearch
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.timing import Timing, nominal_timing

MARGIN = 1.0


def prepared(fleet: Sequence[Robot], most: int) -> Tuple[EventGraph, OrderSearch]:
    """A search over the first windows of a fleet that either robot may pass first."""
    motions = [Motion(nominal_timing(body.path, body.limits), body.depart) for body in fleet]
    windows: List[Sides] = []
    for encounter in EncounterFinder(0.1).find(fleet):
        if encounter.r_first.possible and encounter.s_first.possible and len(windows) < most:
            r_first, s_first = (Wait(order.leader, order.follower, motions[order.follower].timing.last_time(order.at),
                                     motions[order.leader].timing.first_time(order.clear))
                                for order in encounter.orders)
            windows.append((r_first, s_first))
    graph = EventGraph(motions, windows, MARGIN)
    return graph, OrderSearch(graph, motions, np.ones(len(motions)), False)


def least(graph: EventGraph, windows: int) -> float:
    """The least sum of arrivals over all orders."""
    goals = graph.offsets[1:] - 1
    return min(float(times[goals].sum()) for times, delay in (
        graph.least_times(np.array(sides)) for sides in itertools.product((0, 1), repeat=windows))
        if math.isfinite(delay))


def soon() -> float:
    return time.monotonic() + 20.0


@pytest.mark.parametrize("seed", range(16))
def test_search_and_proof_meet_at_the_best_of_all_orders(seed: int) -> None:
    graph, search = prepared(street_fleet(9, seed), most=7)
    best = least(graph, len(search.sides))
    search.improve(1, gap=0.0, deadline=soon())
    assert search.bound - 1e-6 <= best <= search.cost + 1e-6
    search.prove(100, gap=0.0, deadline=soon(), solver=None)
    assert search.cost == pytest.approx(best, abs=1e-6)
    assert search.bound == pytest.approx(best, abs=1e-5)


@pytest.mark.parametrize("seed", range(8))
def test_the_search_never_gets_worse_and_is_repeatable(seed: int) -> None:
    found = []
    for _ in range(2):
        _, search = prepared(street_fleet(12, seed), most=40)
        costs = []
        for rounds in (1, 20, 40):
            search.improve(rounds, gap=0.0, deadline=soon())
            costs.append(search.cost)
        assert costs == sorted(costs, reverse=True)
        found.append((costs, search.sides.tolist()))
    assert found[0] == found[1]


def test_orders_of_turns_are_taken_as_they_are_however_many(monkeypatch: pytest.MonkeyPatch) -> None:
    fleet = street_fleet(12, 3)
    _, search = prepared(fleet, most=40)
    search.improve(1, gap=0.0, deadline=soon())
    known, cost = search.sides.copy(), search.cost
    monkeypatch.setattr(order_state, "_TRAIL", 0)
    monkeypatch.setattr(order_state, "_SHORTEST_TRAIL", 2 * len(fleet) + 8)  # as if there were thousands
    _, search = prepared(fleet, most=40)
    search.improve(1, gap=0.0, deadline=soon())
    assert math.isinf(search.cost)
    search.begin(known)
    assert search.cost == pytest.approx(cost, abs=1e-6)


def test_past_the_deadline_nothing_is_done() -> None:
    _, search = prepared([robot("a", (-4, 0), (4, 0)), robot("b", (0, -4), (0, 4))], most=1)
    search.improve(5, gap=0.0, deadline=time.monotonic() - 1.0)
    search.prove(5, gap=0.0, deadline=time.monotonic() - 1.0, solver=None)
    assert math.isinf(search.cost) and search.gap == 0.0


def test_orders_that_all_end_in_a_cycle_are_told() -> None:
    """Each robot has to clear its second half before the other leaves its first: neither can."""
    body = robot("a", (0, 0), (9, 0))
    motion = Motion(nominal_timing(body.path, body.limits), 0.0)
    early, late = np.array([2.0]), np.array([8.0])
    forced: List[Sides] = [(Wait(0, 1, early, late), None), (None, Wait(1, 0, early, late))]
    with pytest.raises(Contradiction) as caught:
        OrderSearch(EventGraph([motion, motion], forced, MARGIN), [motion, motion], np.ones(2), False)
    assert caught.value.windows == (0, 1)
    either: List[Sides] = [(Wait(0, 1, early, late), Wait(0, 1, early, late)), (None, Wait(1, 0, early, late))]
    search = OrderSearch(EventGraph([motion, motion], either, MARGIN), [motion, motion], np.ones(2), False)
    search.improve(3, gap=0.0, deadline=soon())
    assert math.isinf(search.cost)
    with pytest.raises(Contradiction) as caught:
        search.prove(10, gap=0.0, deadline=soon(), solver=None)
    assert caught.value.windows == (0, 1)


def test_turns_against_the_order_of_arrival_are_taken_however_many() -> None:
    count = 90
    timing = Timing(np.array([0.0, 10.0]), np.array([0.0, 10.0]))
    motions = [Motion(timing, 0.1 * index) for index in range(count)]
    at, clear = np.array([4.0]), np.array([5.0])
    windows = [(Wait(r, s, at, clear), Wait(s, r, at, clear)) for r, s in itertools.combinations(range(count), 2)]
    search = OrderSearch(EventGraph(motions, windows, MARGIN), motions, np.ones(count), False)
    search.begin(np.ones(len(windows), dtype=np.int64))
    # one after the other, the last first, each a metre and the margin after the one before
    waits = np.arange(count) * (1.0 + MARGIN)
    assert search.cost == pytest.approx(float((0.1 * (count - 1) + 10.0 + waits).sum()))
