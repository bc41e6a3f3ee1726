"""Places to wait in a lane with rooms beside it, and who is cut off from what."""

from typing import Sequence, Tuple

import numpy as np
import pytest
from fleets import robot
from test_turn_taking import CORRIDOR, SIDING, replanner

from social_fleet.coordination import waiting_places
from social_fleet.coordination.crowd import Crowd
from social_fleet.coordination.waiting_places import WaitingPlaces
from social_fleet.geometry import Polyline

DISTANCE = 0.7


def places(text: str, *ends: Tuple[float, float]) -> Tuple[Crowd, WaitingPlaces]:
    robots = [robot(f"robot_{index}", (start, 1.5), (goal, 1.5)) for index, (start, goal) in enumerate(ends)]
    crowd = Crowd(robots, len(robots), np.full((len(robots), len(robots)), DISTANCE))
    return crowd, WaitingPlaces(crowd, replanner(text))


def clearances(way: Polyline, found: Sequence[np.ndarray]) -> np.ndarray:
    points = way.position(np.arange(0.0, way.length, 0.05))
    return np.array([np.hypot(*(points - place).T).min() for place in found])


def test_in_a_lane_the_rooms_beside_it_are_off_the_way() -> None:
    crowd, found = places(SIDING, (8.5, 18.5), (19.5, 2.5))
    for named in (found.within_reach(0, [crowd.ways[1]]), found.beyond_others(0, [crowd.ways[1]])):
        assert len(named) and (clearances(crowd.ways[1], named) >= DISTANCE).all()
        assert any(place[1] > 2.0 for place in named), "in a room"


def test_a_bare_corridor_has_none() -> None:
    crowd, found = places(CORRIDOR, (2.5, 18.5), (20.3, 1.8))
    assert not found.within_reach(0, [crowd.ways[1]]) and not found.beyond_others(0, [crowd.ways[1]])


def test_one_that_stands_ends_the_reach() -> None:
    crowd, found = places(SIDING, (2.5, 18.5), (9.5, 12.5))
    assert all(place[0] < 9.5 for place in found.within_reach(0, [crowd.ways[1]]))
    crowd.move(1, np.array([6.5, 3.5]), aside=True)
    assert any(place[0] > 13.2 for place in found.beyond_others(0, [Polyline(np.array([(1.5, 1.5), (13.0, 1.5)]))]))


def test_places_that_no_other_way_leads_past_are_better(monkeypatch: pytest.MonkeyPatch) -> None:
    crowd, found = places(SIDING, (9.5, 18.5), (19.5, 2.5))
    assert crowd.passing(0, np.array([(6.5, 3.5), (6.5, 1.5)])).tolist() == [0, 1]
    best = found.within_reach(0, [])
    cost = [np.hypot(*(place - crowd.places[0])) + crowd.passing(0, place[None])[0] for place in best]
    assert len(best) == 3 and cost == sorted(cost)
    monkeypatch.setattr(waiting_places, "_PASSING", 100.0)
    off, on = found.within_reach(0, [])[0], best[0]
    assert crowd.passing(0, np.array([off, on])).tolist() == [0, 1], "now the way of the other counts for more"


def test_a_place_from_which_the_goal_is_cut_off_then_is_none() -> None:
    crowd, found = places(SIDING, (2.5, 9.5), (4.0, 19.5))
    assert len(found.within_reach(1, []))
    assert all(place[0] > 9.5 for place in found.within_reach(1, [], arriving=0))
    assert all(place[0] > 9.5 for place in found.beyond_others(1, [], arriving=0))


def test_a_goal_in_a_lane_cuts_off_those_behind() -> None:
    _, found = places(SIDING, (2.5, 9.5), (4.0, 19.5), (16.0, 18.2))
    assert found.shut_out_by(0) == 1
    assert found.shut_out_by(1) is None


def test_the_way_to_a_goal_is_barred_by_one_that_stands() -> None:
    crowd, found = places(SIDING, (2.5, 18.5), (9.5, 12.5))
    assert not found.reaches_goal(0) and found.reaches_goal(1)
    crowd.move(1, np.array([6.5, 3.5]), aside=True)
    assert found.reaches_goal(0)
