"""Prioritized planning: who goes first, and what comes of it when one finds no way."""

import pytest
from fleets import robot
from test_fleet_planner import LANE, planned
from worlds import grid_from_text

from social_fleet.coordination.baselines.prioritized import PrioritizedPlanner
from social_fleet.errors import Infeasible

CROSS = grid_from_text("""
    ##.####
    ##.####
    .......
    ##.####
    ##.####
""")


def test_the_longer_way_goes_first() -> None:
    fleet = planned(PrioritizedPlanner, CROSS, [robot("short", (2.5, 0.5), (2.5, 4.5), max_speed=1.0, radius=0.3),
                                                robot("long", (0.5, 2.5), (6.5, 2.5), max_speed=1.0, radius=0.3)])
    assert fleet["long"].arrival_time == pytest.approx(6.0) and fleet["short"].arrival_time > 4.5


def test_one_that_finds_no_way_goes_first_the_next_time() -> None:
    # "long" goes first and parks in the lane before "short" is through.
    fleet = [robot("long", (6.5, 1.5), (2.5, 1.5), max_speed=1.0, radius=0.3),
             robot("short", (3.5, 1.5), (1.5, 1.5), max_speed=0.1, radius=0.3)]
    with pytest.raises(Infeasible, match="found no way for short round those planned before it, in 1 orders") as caught:
        PrioritizedPlanner(coarsening=1, restarts=0).plan(LANE, fleet)
    assert caught.value.robots == ("short",)
    schedule = planned(PrioritizedPlanner, LANE, fleet)
    assert schedule["short"].arrival_time == pytest.approx(20.0)


def test_the_gap_is_that_to_what_each_would_need_alone() -> None:
    fleet = planned(PrioritizedPlanner, CROSS, [robot("a", (2.5, 0.5), (2.5, 4.5), max_speed=1.0, radius=0.3),
                                                robot("b", (0.5, 2.5), (6.5, 2.5), max_speed=1.0, radius=0.3)])
    assert fleet.gap == pytest.approx(1.0 - 10.0 / fleet.sum_of_completion)
