"""A round is known by everything that its schedules depend on."""

from typing import Any

import pytest

from social_fleet.errors import InvalidScenario
from social_fleet.fleet.messages import Round

ROUND = Round(1, ("b", "a"), ("d", "c"), time_margin=1.0)


def test_names_are_sorted_and_the_key_is_the_same_for_all() -> None:
    assert ROUND.robots == ("a", "b", "c", "d")
    assert Round(1, ("a", "b"), ("c", "d"), time_margin=1).key == ROUND.key


@pytest.mark.parametrize("other", [
    Round(2, ("a", "b"), ("c", "d")), Round(1, ("a", "b", "c"), ("d",)), Round(1, ("a", "b"), ("c",)),
    Round(1, ("a", "b"), ("c", "d"), time_margin=1.5), Round(1, ("a", "b"), ("c", "d"), tracking_tolerance=0.2),
    Round(1, ("a", "b"), ("c", "d"), repairs=0)])
def test_another_round_has_another_key(other: Round) -> None:
    assert other.key != ROUND.key


@pytest.mark.parametrize("values, complaint", [
    ({"planning": ()}, "planning: there is no robot to coordinate"),
    ({"fixed": ("a",)}, "two robots are named a"),
    ({"time_margin": -1.0}, "time_margin: must be zero or more"),
    ({"tracking_tolerance": float("nan")}, "tracking_tolerance"),
    ({"repairs": -1}, "repairs")])
def test_what_makes_no_round_is_refused(values: Any, complaint: str) -> None:
    with pytest.raises(InvalidScenario, match=complaint):
        Round(**{"version": 1, "planning": ("a", "b"), **values})
