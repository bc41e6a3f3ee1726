"""Who searches which pairs: every pair once, fairly, and the same whoever asks."""

import itertools
import random
from typing import List

import pytest

from social_fleet.coordination.work_sharing import circular_partners, share_pairs
from social_fleet.errors import InvalidParameter, InvalidScenario


def names(count: int, prefix: str = "robot") -> List[str]:
    return [f"{prefix}_{index:02d}" for index in range(count)]


def test_figure_4_by_hand() -> None:
    assert circular_partners(5) == [[1, 2], [2, 3], [3, 4], [4, 0], [0, 1]]
    assert circular_partners(6) == [[1, 2, 3], [2, 3, 4], [3, 4, 5], [4, 5], [5, 0], [0, 1]]


@pytest.mark.parametrize("count", range(65))
def test_every_pair_once_and_loads_as_the_paper_says(count: int) -> None:
    shares = share_pairs(names(count))
    pairs = [pair for share in shares.values() for pair in share]
    assert sorted(pairs) == list(itertools.combinations(names(count), 2))
    n = (count - 1) // 2
    loads = sorted(len(share) for share in shares.values())
    assert loads == [n] * count if count % 2 else loads == [n] * (count // 2) + [n + 1] * (count // 2)
    assert all(name in pair for name, share in shares.items() for pair in share), "each knows its own path already"


@pytest.mark.parametrize("planning, fixed", [(1, 0), (1, 1), (1, 12), (2, 3), (5, 4), (6, 7), (0, 3), (9, 1)])
def test_robots_under_way_search_their_pairs_with_those_that_plan(planning: int, fixed: int) -> None:
    new, moving = names(planning, "new"), names(fixed, "moving")
    shares = share_pairs(new, moving)
    pairs = sorted(pair for share in shares.values() for pair in share)
    assert pairs == sorted([*itertools.combinations(new, 2), *itertools.product(new, moving)])
    assert all(shares[name] == tuple((other, name) for other in new) for name in moving)
    assert {name: shares[name] for name in new} == share_pairs(new)


def test_the_order_of_asking_does_not_matter() -> None:
    new, moving = names(7, "new"), names(4, "moving")
    expected = share_pairs(new, moving)
    for seed in range(20):
        shuffle = random.Random(seed).shuffle
        shuffle(new)
        shuffle(moving)
        assert share_pairs(new, moving) == expected and list(share_pairs(new, moving)) == list(expected)


def test_what_cannot_be_shared_is_refused() -> None:
    with pytest.raises(InvalidScenario, match="two robots are named gold"):
        share_pairs(["gold", "blue"], ["gold"])
    with pytest.raises(InvalidParameter, match="zero or more"):
        circular_partners(-1)
