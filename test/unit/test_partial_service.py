"""Robots that no schedule can serve: left out by name, and safe from the rest."""

import numpy as np
import pytest
from fleets import robot

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.schedule import Schedule
from social_fleet.coordination.verification import verify
from social_fleet.errors import Infeasible


def test_who_cannot_be_served_is_named_and_the_rest_drive() -> None:
    """b and c have to pass each other in the same lane; a crosses before where they stand."""
    fleet = [robot("a", (-3, 2), (-3, -2)), robot("b", (0, 0), (9, 0)), robot("c", (9, 0), (0, 0))]
    with pytest.raises(Infeasible):
        coordinate(fleet)
    some = coordinate(fleet, partial=True)
    assert [schedule.name for schedule in some.schedules] == ["a"]
    assert [name for name, _ in some.unserved] == ["b", "c"], "the way of either is blocked by the other"
    assert "starts in the way" in dict(some.unserved)["c"]
    aside = coordinate([robot("a", (-3, 2), (-3, -2)), robot("b", (0, 0), (9, 0)), robot("c", (9, 0), (9, 5)),
                        robot("d", (4, 0), (4, 0.1))], partial=True)
    assert [name for name, _ in aside.unserved] == ["b"], "d would be in its way even if it did not move"
    assert [schedule.name for schedule in aside.schedules] == ["a", "c", "d"]
    assert verify(aside).safe


def test_one_by_one_nobody_drives_through_who_is_left_out() -> None:
    """b cannot leave before a comes, whose schedule is settled first; left where it is, it blocks a."""
    a, b = robot("a", (-5, 0), (5, 0)), robot("b", (-2, 0), (-2, 6), depart=30.0)
    c = robot("c", (-5, 3), (5, 3))
    some = coordinate([a, b, c], mode="sequential", partial=True)
    assert [schedule.name for schedule in some.schedules] == ["c"]
    assert [name for name, _ in some.unserved] == ["a", "b"]
    assert "b starts in the way of a" in dict(some.unserved)["a"]
    standing = [Schedule(robot(body.name, body.path.points[0]), np.zeros(1), np.zeros(1)) for body in (a, b)]
    assert verify([*some.schedules, *standing]).safe


def test_who_blocks_a_schedule_under_way_cannot_be_left_out() -> None:
    under_way = coordinate([robot("a", (-5, 0), (5, 0))]).schedules
    with pytest.raises(Infeasible, match="b starts in the way of a"):
        coordinate([robot("b", (-2, 0), (-2, 6), depart=30.0)], fixed=under_way, partial=True)
