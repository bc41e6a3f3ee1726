"""Orders given and taken back: times against the longest paths computed anew, and explanations against the times."""

import math
from typing import List, Optional, Sequence, Tuple

import numpy as np
import pytest
from fleets import robot, street_fleet

from social_fleet.coordination.encounters import EncounterFinder
from social_fleet.coordination.event_graph import EventGraph, Motion, Sides, Wait
from social_fleet.coordination.order_state import OrderState
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.timing import nominal_timing
from social_fleet.errors import SolverFailed

MARGIN = 1.0


def prepared(fleet: Sequence[Robot], fixed: int = 0) -> Tuple[EventGraph, OrderState]:
    motions = [Motion(nominal_timing(body.path, body.limits), body.depart, fixed=index >= len(fleet) - fixed)
               for index, body in enumerate(fleet)]
    windows: List[Sides] = []
    for encounter in EncounterFinder(0.1).find(fleet, fixed=fixed):
        r_first, s_first = (wait(motions, order) for order in encounter.orders)
        windows.append((r_first, s_first))
    graph = EventGraph(motions, windows, MARGIN)
    weights = np.array([0.0 if motion.fixed else 1.0 for motion in motions])
    return graph, OrderState(graph, motions, weights, longest=False)


def wait(motions: Sequence[Motion], order: object) -> Optional[Wait]:
    if not order.possible:  # type: ignore[attr-defined]
        return None
    return Wait(order.leader, order.follower, motions[order.follower].timing.last_time(order.at),  # type: ignore
                motions[order.leader].timing.first_time(order.clear))  # type: ignore[attr-defined]


@pytest.mark.parametrize("seed", range(20))
def test_times_are_the_longest_paths_after_every_order(seed: int) -> None:
    rng = np.random.RandomState(seed)
    graph, state = prepared(street_fleet(9, seed))
    before = state.times.copy()
    given = []
    for window in rng.permutation(len(state.sides)):
        sides = np.flatnonzero(state.possible[window])
        if not len(sides):
            continue
        bad = state.give(int(window), int(rng.choice(sides)))
        wanted, delay = graph.least_times(state.sides)
        assert (bad is not None) == math.isinf(delay)
        if bad is not None:
            state.take_back(state.given - 1)
            continue
        given.append(window)
        assert np.abs(state.times - wanted).max() < 1e-6
    assert given, "some orders fit"
    state.take_back(len(given) // 2)
    assert np.abs(state.times - graph.least_times(state.sides)[0]).max() < 1e-6
    state.take_back(0)
    assert (state.times == before).all() and (state.sides == -1).all()


@pytest.mark.parametrize("seed", range(12))
def test_what_explains_a_time_is_enough_for_it(seed: int) -> None:
    rng = np.random.RandomState(seed)
    graph, state = prepared(street_fleet(9, seed))
    for window in rng.permutation(len(state.sides)):
        sides = np.flatnonzero(state.possible[window])
        bad = state.give(int(window), int(rng.choice(sides))) if len(sides) else None
        if bad is not None:
            alone = np.full(len(state.sides), -1, dtype=np.int64)
            for other, side in state.explain(bad):
                alone[other] = side
            assert math.isinf(graph.least_times(alone)[1]), "the cycle alone is impossible"
            state.take_back(state.given - 1)
    for index, goal in enumerate(state.goals):
        reasons = state.explain(int(goal))
        alone = np.full(len(state.sides), -1, dtype=np.int64)
        for window, side in reasons:
            alone[window] = side
        assert graph.least_times(alone)[0][goal] == pytest.approx(state.times[goal], abs=1e-6)


@pytest.mark.parametrize("seed", range(12))
def test_a_dive_orders_everything_and_leaves_the_state_as_it_was(seed: int) -> None:
    graph, state = prepared(street_fleet(7, seed))
    open_ones = np.flatnonzero(state.possible.all(axis=1))
    for window in np.flatnonzero(~state.possible.all(axis=1)):
        if not state.possible[window].any() or state.give(int(window), int(state.possible[window, 1])) is not None:
            pytest.skip("no schedule on these paths")
    before = state.times.copy()
    by_time = np.argsort(state.entries(), kind="stable")
    cost, sides = state.dive(np.full(len(state.sides), -1, dtype=np.int64), by_time, math.inf)
    assert (state.times == before).all()
    if math.isinf(cost):
        return
    times, delay = graph.least_times(sides)
    assert times[state.goals].sum() == pytest.approx(cost, abs=1e-6)
    kept = state.kept(times)
    assert all(kept[window].any() for window in open_ones), "every window shows an order"


def test_a_fixed_robot_does_not_wait() -> None:
    _, state = prepared([robot("a", (-4, 0), (4, 0)), robot("b", (0, -4), (0, 4))], fixed=1)
    assert state.give(0, 1) is None, "the planned one waits"
    state.take_back(0)
    bad = state.give(0, 0)
    assert bad is not None and state.explain(bad) == {(0, 0)}
    assert state.contested().tolist() == []


def test_weights_and_makespan_in_the_cost() -> None:
    graph, state = prepared([robot("a", (-4, 0), (4, 0)), robot("b", (0, -8), (0, 8))])
    state.weights = np.array([3.0, 1.0])
    assert state.cost() == pytest.approx(3.0 * state.arrivals()[0] + state.arrivals()[1])
    state.longest = True
    assert state.cost() == pytest.approx(state.arrivals()[1], abs=1e-3)


def test_more_waits_than_can_be_remembered_are_refused_not_written_elsewhere() -> None:
    """One window of many rows, the first of which raise more times than there is room for."""
    _, state = prepared([robot("a", (0, 0), (40, 0), max_speed=0.2), robot("b", (-2, 0), (38, 0), max_speed=1.0)])
    window = int(np.flatnonzero(state.possible[:, 0])[0])
    assert state.rows.starts[2 * window + 1] - state.rows.starts[2 * window] > 30
    wide = tuple(np.full(1000, 77, dtype=column.dtype) for column in state._trail)
    state._trail = tuple(column[:12] for column in wide)
    with pytest.raises(SolverFailed, match="fewer robots"):
        state.give(window, 0)
    assert all((column[12:] == 77).all() for column in wide)
