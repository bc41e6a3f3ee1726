"""Open nodes: the least bound, and who comes first among those near it."""

import numpy as np
import pytest

from social_fleet.coordination.baselines.frontier import Frontier


def test_without_leeway_the_least_bound_comes_first_and_of_equals_the_lowest_rank() -> None:
    frontier: Frontier[str] = Frontier(1.0, 1e-6)
    for item, bound, rank in (("c", 2.0, 0), ("b", 1.0, 5), ("a", 1.0 + 1e-9, 3)):
        frontier.push(item, bound, rank)
    assert frontier.bound == 1.0
    assert [frontier.pop() for _ in range(3)] == ["a", "b", "c"]
    assert not frontier


def test_of_equals_the_latest_comes_first() -> None:
    frontier: Frontier[str] = Frontier(1.0, 0.0)
    for item in ("early", "late"):
        frontier.push(item, 1.0, 2)
    assert frontier.pop() == "late"


def test_with_leeway_the_lowest_rank_comes_first_among_the_nearly_best() -> None:
    frontier: Frontier[str] = Frontier(1.5, 0.0)
    for item, bound, rank in (("far", 16.0, 0), ("near", 14.0, 1), ("best", 10.0, 9)):
        frontier.push(item, bound, rank)
    assert frontier.pop() == "near" and frontier.bound == 10.0
    assert frontier.pop() == "best" and frontier.bound == 16.0
    assert frontier.pop() == "far"


@pytest.mark.parametrize("factor", [1.0, 1.2])
def test_nothing_is_lost_and_nothing_is_beyond_the_factor(factor: float) -> None:
    rng = np.random.RandomState(0)
    frontier: Frontier[float] = Frontier(factor, 0.0)
    popped, pushed = [], []
    for _ in range(300):
        if rng.rand() < 0.6 or not frontier:
            bound = float(rng.uniform(1.0, 2.0))
            pushed.append(bound)
            frontier.push(bound, bound, int(rng.randint(5)))
        else:
            limit = factor * frontier.bound
            popped.append(frontier.pop())
            assert popped[-1] <= limit or factor > 1.0  # one that was near stays so while the least bound falls
    while frontier:
        popped.append(frontier.pop())
    assert sorted(popped) == sorted(pushed)
