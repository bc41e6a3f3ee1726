"""Who is in whose way, as robots move on."""

import numpy as np
import pytest
from fleets import robot

from social_fleet.coordination.crowd import Crowd, gaps
from social_fleet.geometry import Polyline


def crowd(planned: int = 3) -> Crowd:
    robots = [robot("along", (0, 0), (10, 0)), robot("on_the_way", (5, 0.3), (5, 5)), robot("beyond", (9, 3), (8, 0))]
    return Crowd(robots, planned, np.full((3, 3), 0.7))


def test_who_stands_and_who_ends_in_whose_way() -> None:
    found = crowd()
    assert found.blocked().tolist() == [[False, True, False], [False] * 3, [False] * 3]
    assert found.harms().tolist() == [[False, False, True], [False] * 3, [False] * 3]


def test_one_that_moves_frees_the_way_and_bars_another() -> None:
    found = crowd()
    found.move(1, np.array([9.0, 2.0]), aside=True)
    assert not found.blocked()[0].any() and found.blocked()[2, 1]
    assert found.turns == 1 and found.changes == [0, 1, 0] and found.aside.tolist() == [False, True, False]


def test_one_aside_is_kept_off_by_more() -> None:
    found = crowd()
    found.move(1, np.array([5.0, 0.75]))
    assert not found.blocked()[0, 1]
    found.move(1, np.array([5.0, 0.75]), aside=True)
    assert found.blocked()[0, 1]


def test_another_way_counts_instead() -> None:
    found = crowd()
    found.lead(0, Polyline(np.array([(0.0, 0.0), (0.0, -5.0), (10.0, -5.0), (10.0, 0.0)])))
    assert not found.blocked()[0].any() and not found.harms()[0].any()


def test_settled_ones_wait_for_nobody() -> None:
    found = crowd()
    found.waiting.remove(0)
    assert found.settled() == [0] and not found.blocked()[0].any() and not found.harms()[0].any()


def test_one_that_is_called_back_stands_in_the_way_again() -> None:
    found = crowd()
    found.move(0, found.goals[0])
    found.waiting.remove(0)
    found.recall(0)
    assert found.waiting == [0, 1, 2] and found.settled() == []
    assert not found.blocked()[0].any() and found.changes[0] == 2


def test_how_many_ways_lead_past_a_place() -> None:
    found = crowd()
    assert found.passing(2, np.array([(5.0, 0.5), (2.0, 0.5), (2.0, 3.0)])).tolist() == [2, 1, 0]
    assert found.passing(0, np.zeros((0, 2))).tolist() == []


def test_those_under_way_may_be_held_up_by_one_that_waits() -> None:
    robots = crowd().robots[::-1]
    assert Crowd(robots, 2, np.full((3, 3), 0.7)).is_blocked_by(2)
    assert not Crowd(robots, 1, np.full((3, 3), 0.2)).is_blocked_by(1)


def test_gaps_to_a_way_and_to_a_place() -> None:
    places = np.array([(3.0, 4.0), (-3.0, 4.0), (5.0, 0.0)])
    assert gaps(Polyline(np.array([(0.0, 0.0), (10.0, 0.0)])), places) == pytest.approx([4.0, 5.0, 0.0])
    assert gaps(Polyline(np.array([(0.0, 0.0)])), places) == pytest.approx([5.0, 5.0, 5.0])
