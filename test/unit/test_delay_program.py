"""The master program: what cuts make of its bound, by hand."""

import numpy as np
import pytest

from social_fleet.coordination.delay_program import DelayProgram, Proposal


def solved(program: DelayProgram) -> Proposal:
    found = program.solve(solver=None, time_limit=10.0, gap=0.0, nodes=None)
    assert found is not None
    return found


def crossing(weights: np.ndarray, longest: bool = False) -> DelayProgram:
    """Two robots that arrive after 10 s and 20 s; one waits: the first for 5 s, or the second for 3 s."""
    program = DelayProgram(np.array([10.0, 20.0]), weights, longest)
    program.add_delay(1, 3.0, {(7, 0): 3.0})
    program.add_delay(0, 5.0, {(7, 1): 5.0})
    return program


def test_without_cuts_all_arrive_undelayed() -> None:
    program = DelayProgram(np.array([10.0, 20.0]), np.array([2.0, 1.0]), False)
    assert solved(program).bound == pytest.approx(40.0) and program.windows == []


@pytest.mark.parametrize("weights, longest, bound, side", [
    ((1.0, 1.0), False, 33.0, 0), ((1.0, 4.0), False, 95.0, 1), ((1.0, 1.0), True, 20.0, 1)])
def test_the_cheaper_order_is_proposed(weights: tuple, longest: bool, bound: float, side: int) -> None:
    found = solved(crossing(np.array(weights), longest))
    assert found.bound == pytest.approx(bound) and found.sides == {7: side}


def test_excluded_orders_are_not_proposed() -> None:
    program = crossing(np.ones(2))
    program.exclude(frozenset([(7, 0)]))
    assert solved(program).sides == {7: 1}
    program.exclude(frozenset([(7, 1)]))
    assert program.solve(solver=None, time_limit=10.0, gap=0.0, nodes=None) is None


def test_orders_that_cost_only_together() -> None:
    program = DelayProgram(np.zeros(1), np.ones(1), False)
    program.add_delay(0, 8.0, {(1, 0): 8.0, (2, 1): 8.0})
    assert solved(program).bound == pytest.approx(0.0)
    program.exclude(frozenset([(1, 1)]))
    program.exclude(frozenset([(2, 0)]))
    assert solved(program).bound == pytest.approx(8.0)
