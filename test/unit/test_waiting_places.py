"""Places to wait in a lane with rooms beside it: off the ways, or where others can drive round."""

from typing import Sequence, Tuple

import numpy as np
from fleets import robot
from test_turn_taking import CORRIDOR, SIDING, replanner

from social_fleet.coordination.crowd import Crowd
from social_fleet.coordination.waiting_places import WaitingPlaces

HALL = """
    ######################
    #....................#
    #....................#
    #....................#
    ######################
"""
DISTANCE = 0.7


def places(text: str, *ends: Tuple[float, float], y: float = 1.5) -> Tuple[Crowd, WaitingPlaces]:
    robots = [robot(f"robot_{index}", (start, y), (goal, y)) for index, (start, goal) in enumerate(ends)]
    crowd = Crowd(robots, len(robots), np.full((len(robots), len(robots)), DISTANCE))
    return crowd, WaitingPlaces(crowd, replanner(text), 0)


def clearances(crowd: Crowd, found: Sequence[np.ndarray], robot: int) -> np.ndarray:
    others = [crowd.ways[other].position(np.arange(0.0, crowd.ways[other].length, 0.05))
              for other in crowd.others(robot)]
    return np.array([min(np.hypot(*(way - place).T).min() for way in others) for place in found])


def test_in_a_lane_the_rooms_beside_it_are_off_the_way() -> None:
    crowd, found = places(SIDING, (8.5, 18.5), (19.5, 2.5))
    for named in (found.off_ways(0), found.anywhere(0)):
        assert len(named) and (clearances(crowd, named, 0) >= DISTANCE).all()
        assert any(place[1] > 2.0 for place in named), "in a room"


def test_a_bare_corridor_has_none() -> None:
    _, found = places(CORRIDOR, (2.5, 18.5), (19.5, 3.5))
    assert not found.off_ways(0) and not found.anywhere(0)


def test_in_a_hall_one_may_wait_on_ways_that_lead_round_it() -> None:
    crowd, found = places(HALL, (8.5, 18.5), (19.5, 2.5), y=2.5)
    named = found.beside_passages(0)
    assert len(named) and clearances(crowd, named, 0).min() < DISTANCE
    assert all(abs(place[1] - 2.5) > 0.3 for place in named), "in the middle it would cut the hall in two"


def test_a_goal_in_a_lane_cuts_off_those_behind() -> None:
    _, found = places(SIDING, (2.5, 9.5), (4.0, 19.5), (16.0, 18.2))
    assert found.shut_out_by(0) == 1
    assert found.shut_out_by(1) is None


def test_the_way_to_a_goal_is_barred_by_one_that_stands() -> None:
    crowd, found = places(SIDING, (2.5, 18.5), (9.5, 12.5))
    assert not found.reaches_goal(0) and found.reaches_goal(1)
    crowd.move(1, np.array([6.5, 3.5]), aside=True)
    assert found.reaches_goal(0)


def test_home_is_what_leads_to_the_goal_when_all_others_are_occupied() -> None:
    _, found = places(SIDING, (2.5, 18.5), (12.0, 9.5))
    here, there = found.at_home(np.array([(15.5, 1.5), (19.5, 1.5)]), 0).tolist()
    assert here and there
    assert found.part(0, np.array([9.5, 1.5])) == 0
    assert found.part(0, np.array([6.5, 3.5])) != found.part(0, np.array([13.5, 3.5]))
