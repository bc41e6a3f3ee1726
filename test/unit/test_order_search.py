"""Orders found quickly, and proven by branch and bound: against every order tried one by one."""

import itertools
import math
from typing import List, Sequence

import numpy as np
import pytest
from fleets import robot, street_fleet

from social_fleet.coordination.encounters import EncounterFinder
from social_fleet.coordination.event_graph import Motion, Sides, Wait
from social_fleet.coordination.order_search import OrderSearch
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.timing import nominal_timing

MARGIN = 1.0
MANY = 100000


def prepared(fleet: Sequence[Robot], most: int) -> OrderSearch:
    """A search over the first windows of a fleet that either robot may pass first."""
    motions = [Motion(nominal_timing(body.path, body.limits), body.depart) for body in fleet]
    windows: List[Sides] = []
    for encounter in EncounterFinder(0.1).find(fleet):
        if encounter.r_first.possible and encounter.s_first.possible and len(windows) < most:
            r_first, s_first = (Wait(order.leader, order.follower, motions[order.follower].timing.last_time(order.at),
                                     motions[order.leader].timing.first_time(order.clear))
                                for order in encounter.orders)
            windows.append((r_first, s_first))
    return OrderSearch(motions, windows, MARGIN)


def least(search: OrderSearch, windows: int) -> float:
    return min(search.delay(np.array(sides)) for sides in itertools.product((0, 1), repeat=windows))


@pytest.mark.parametrize("seed", range(12))
def test_branch_and_bound_finds_the_best_of_all_orders(seed: int) -> None:
    search = prepared(street_fleet(9, seed), most=7)
    windows = len(search.best()[1])
    delay, sides, proven = search.prove(math.inf, np.zeros(windows, dtype=np.int64), nodes=MANY)
    assert proven
    assert delay == pytest.approx(least(search, windows), abs=1e-6)
    assert search.delay(sides) == pytest.approx(delay, abs=1e-6)


@pytest.mark.parametrize("seed", range(12))
def test_the_quick_search_tells_a_delay_that_its_orders_have(seed: int) -> None:
    search = prepared(street_fleet(9, seed), most=7)
    delay, sides = search.best()
    assert delay == pytest.approx(search.delay(sides), abs=1e-9)
    assert delay >= least(search, len(sides)) - 1e-6


def test_without_nodes_nothing_is_proven_and_nothing_lost() -> None:
    search = prepared([robot("a", (-4, 0), (4, 0)), robot("b", (0, -4), (0, 4))], most=1)
    delay, sides = search.best()
    again, same, proven = search.prove(delay, sides, nodes=0)
    assert not proven and again == delay and (same == sides).all()


def test_orders_that_all_end_in_a_cycle_are_told() -> None:
    """Each robot has to clear its second half before the other leaves its first: neither can."""
    motion = Motion(nominal_timing(robot("a", (0, 0), (9, 0)).path, robot("a", (0, 0), (9, 0)).limits), 0.0)
    early, late = np.array([2.0]), np.array([8.0])
    forced: List[Sides] = [(Wait(0, 1, early, late), None), (None, Wait(1, 0, early, late))]
    search = OrderSearch([motion, motion], forced, MARGIN)
    assert search.best()[0] == math.inf
    delay, _, proven = search.prove(math.inf, np.array([0, 1]), nodes=MANY)
    assert proven and delay == math.inf
