"""Fleets that no schedule fits on their own paths, and the turns that they could take; judged from the motion alone."""

import math
import time
from typing import Any, Callable, List, Optional, Tuple

import numpy as np
import pytest
from fleets import robot
from worlds import grid_from_text

from social_fleet.coordination import program, turn_taking
from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.encounters import EncounterFinder
from social_fleet.coordination.order_search import OrderSearch
from social_fleet.coordination.program import ExactProgram, Solution
from social_fleet.coordination.replanning import PlannerReplanner
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.turn_taking import TurnTaking
from social_fleet.coordination.turns import Turn, sides_of
from social_fleet.coordination.verification import verify
from social_fleet.errors import TimedOut
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.planner import SocialPlanner

SIDING = """
    ######################
    #.####.######.####.###
    #.####.######.####.###
    #....................#
    ######################
"""
CORRIDOR = """
    ######################
    #....................#
    ######################
"""
DISTANCE = 0.7  # that robots of 0.25 m keep: their radii and twice the tolerance [m]
LINK = 0.1  # that ways keep beyond it from those that stand aside, so that their windows end there [m]


def replanner(text: str) -> PlannerReplanner:
    coarse = grid_from_text(text, 1.0)
    grid = type(coarse)(np.kron(coarse.values, np.ones((4, 4), dtype=np.int8)), 0.25, coarse.origin)
    planner = SocialPlanner(grid, PlannerConfig(robot_radius=0.25))
    return PlannerReplanner(lambda radius: planner)


def lane(*ends: Tuple[float, float]) -> List[Robot]:
    return [robot(f"robot_{index}", (start, 1.5), (goal, 1.5)) for index, (start, goal) in enumerate(ends)]


def turns_of(robots: List[Robot], text: str, *, planned: Optional[int] = None,
             expired: Callable[[], bool] = lambda: False) -> Tuple[Optional[List[Robot]], List[Turn]]:
    search = TurnTaking(robots, len(robots) if planned is None else planned, replanner(text),
                        EncounterFinder(0.1).safety_distance, expired)
    return search.find(), list(search.turns)


def check(before: List[Robot], after: Optional[List[Robot]], turns: List[Turn]) -> None:
    """Drive the turns one after the other: nobody comes near one that stands, and all arrive."""
    assert after is not None
    at = [0.0] * len(after)
    for turn in turns:
        assert turn.low == pytest.approx(at[turn.robot], abs=1e-6)
        way = after[turn.robot].path.position(np.arange(turn.low, turn.high, 0.01))
        for other in range(len(after)):
            if other != turn.robot and len(way):
                gaps = way - after[other].path.position(at[other])
                aside = 1e-6 < at[other] < after[other].path.length - 1e-6
                assert np.hypot(gaps[:, 0], gaps[:, 1]).min() >= DISTANCE + aside * LINK - 1e-3
        at[turn.robot] = turn.high
    assert at == pytest.approx([robot_.path.length for robot_ in after], abs=1e-6)
    for one, other in zip(before, after):
        assert np.array_equal(one.path.points[[0, -1]], other.path.points[[0, -1]])


HEAD_ON = [(2.5, 18.5), (19.5, 3.5)]
REVERSED = [(3.5, 19.5), (5.0, 16.5), (8.5, 14.5), (10.5, 4.0)]
SWAPPED_IN_A_ROW = [(2.5, 8.5), (8.5, 2.5), (12.5, 19.5), (19.5, 12.5)]


@pytest.mark.parametrize("ends", [HEAD_ON, REVERSED, SWAPPED_IN_A_ROW])
def test_turns_in_a_lane_with_sidings(ends: List[Tuple[float, float]]) -> None:
    robots = lane(*ends)
    after, turns = turns_of(robots, SIDING)
    check(robots, after, turns)
    assert after is not None
    encounters = EncounterFinder(0.1).find(after)
    assert len(encounters) and (sides_of(turns, after, encounters) >= 0).all()


def test_who_makes_way_may_need_others_to_make_way(monkeypatch: pytest.MonkeyPatch) -> None:
    robots = lane((13.0, 4.0), (7.0, 16.0), (11.5, 7.0), (14.5, 2.5))
    check(robots, *turns_of(robots, SIDING))
    monkeypatch.setattr(turn_taking, "_DEPTH", 0)
    assert turns_of(robots, SIDING)[0] is None


def test_those_that_have_arrived_may_be_called_back(monkeypatch: pytest.MonkeyPatch) -> None:
    robots = lane((5.5, 10.0), (10.0, 14.5), (8.5, 2.5), (11.5, 7.0))
    check(robots, *turns_of(robots, SIDING))
    monkeypatch.setattr(turn_taking, "_RECALLS", 0)
    assert turns_of(robots, SIDING)[0] is None


def test_those_that_are_in_nobody_s_way_keep_their_paths() -> None:
    robots = lane(*HEAD_ON) + [robot("away", (1.5, 2.5), (1.5, 3.5))]
    after, turns = turns_of(robots, SIDING)
    check(robots, after, turns)
    assert after is not None and after[2] is robots[2]


def test_where_nobody_can_step_aside_there_are_no_turns() -> None:
    assert turns_of(lane(*HEAD_ON), CORRIDOR)[0] is None


def test_one_under_way_does_not_wait_for_others_to_make_way() -> None:
    assert turns_of(lane(*HEAD_ON), SIDING, planned=1)[0] is None
    clear = lane((2.5, 5.0), (16.5, 9.5))
    after, turns = turns_of(clear, SIDING, planned=1)
    check(clear, after, turns)
    assert turns[0].robot == 1, "the one under way comes first"


def test_it_gives_up_when_its_time_is_over() -> None:
    assert turns_of(lane(*HEAD_ON), SIDING, expired=lambda: True)[0] is None


@pytest.mark.parametrize("asked", [1, 5, 10, 20])
def test_once_its_time_is_over_it_soon_ends(asked: int, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: List[bool] = []  # of the clock: whether time was over
    late: List[int] = []
    way = PlannerReplanner.way

    def expired() -> bool:
        calls.append(len(calls) >= asked)
        return calls[-1]

    def counted(*args: Any) -> Any:
        late.append(calls[-1])
        return way(*args)

    monkeypatch.setattr(PlannerReplanner, "way", counted)
    assert turns_of(lane(*REVERSED), SIDING, expired=expired)[0] is None
    assert sum(late) <= 4, "what was begun for one place may end"


def test_ways_lead_round_the_goals_of_those_under_way() -> None:
    """The lane is barred for good: there is no way past, and none is looked for by making way."""
    robots = lane((2.5, 18.5), (14.5, 9.5))
    assert turns_of(robots, SIDING, planned=1)[0] is None
    away = lane((2.5, 18.5)) + [robot("robot_1", (14.5, 1.5), (13.5, 1.5), (13.5, 3.5))]
    after, turns = turns_of(away, SIDING, planned=1)
    check(away, after, turns)
    assert after is not None and after[1] is away[1]


def test_a_fleet_that_one_changed_path_does_not_help_gets_a_schedule() -> None:
    robots = lane(*REVERSED)
    fleet = coordinate(robots, replanner=replanner(SIDING))
    assert verify(fleet).min_clearance >= 0.2 - 1e-6
    assert fleet.message


def test_where_orders_are_not_found_in_time_they_take_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    solve = ExactProgram.solve

    def undecided(exact: ExactProgram, *, deadline: float, patience: float = math.inf) -> Solution:
        if math.isfinite(patience):
            raise TimedOut("not in time")
        return solve(exact, deadline=deadline)

    monkeypatch.setattr(ExactProgram, "solve", undecided)
    fleet = coordinate(lane((2.5, 8.5), (12.5, 18.5)), replanner=replanner(SIDING))
    assert "in turn" in fleet.message
    assert verify(fleet).min_clearance >= 0.2 - 1e-6


@pytest.mark.parametrize("objective", ["sum_of_completion", "makespan"])
def test_orders_of_a_crowd_are_annealed(objective: str, monkeypatch: pytest.MonkeyPatch) -> None:
    deadlines: List[float] = []
    anneal = OrderSearch.anneal

    def watched(search: OrderSearch, tries: int, *, gap: float, deadline: float) -> None:
        deadlines.append(deadline - time.monotonic())
        before = search.cost
        anneal(search, tries, gap=gap, deadline=deadline)
        assert search.cost <= before and search.state.kept(search.state.graph.least_times(search.sides)[0]).any(1).all()

    monkeypatch.setattr(OrderSearch, "anneal", watched)
    monkeypatch.setattr(program, "_CROWDED", 0)
    fleet = coordinate(lane(*REVERSED), replanner=replanner(SIDING), objective=objective, time_limit=20.0)
    assert len(deadlines) in (1, 2) and all(0.0 < left <= 20.0 for left in deadlines)
    assert verify(fleet).min_clearance >= 0.2 - 1e-6 and "in turn" in fleet.message


def test_equal_input_gives_equal_turns() -> None:
    first, second = turns_of(lane(*REVERSED), SIDING), turns_of(lane(*REVERSED), SIDING)
    assert first[1] == second[1]
