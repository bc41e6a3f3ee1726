"""Random fleets have room, reach their goals, and are the same for the same seed."""

import math
from itertools import combinations

import pytest
from repository import ROOT
from worlds import grid_from_text

from social_fleet.errors import InvalidScenario
from social_fleet.scenario.files import load_scenario
from social_fleet.scenario.fleet import plan_fleet
from social_fleet.scenario.scenario import Scenario
from social_fleet.scenario.random_fleet import random_scenario

HALL = grid_from_text("#" * 12 + ("\n" + "#" + "." * 10 + "#") * 6 + "\n" + "#" * 12)


def draw(robots: int, seed: int, mixed: bool = False) -> Scenario:
    return random_scenario(HALL, robots, seed=seed, map_name="hall.yaml", map_path="/hall.yaml", mixed=mixed)


def test_starts_and_goals_have_room() -> None:
    scenario = draw(6, seed=1)
    for one, other in combinations(scenario.robots, 2):
        for end in ("start", "goal"):
            here, there = getattr(one, end), getattr(other, end)
            assert math.hypot(here[0] - there[0], here[1] - there[1]) >= 1.0


def test_every_goal_can_be_reached() -> None:
    assert len(plan_fleet(draw(6, seed=2), HALL)) == 6


def test_they_are_held_to_what_the_shipped_scenarios_are_held_to() -> None:
    shipped = load_scenario(ROOT / "config" / "scenarios" / "head_on.yaml")
    assert draw(2, seed=1).expect == shipped.expect


def test_the_seed_decides() -> None:
    assert draw(4, seed=3) == draw(4, seed=3)
    assert draw(4, seed=3) != draw(4, seed=4)


def test_mixed_speeds_lie_between_a_third_and_the_whole() -> None:
    speeds = [robot.max_speed for robot in draw(6, seed=1, mixed=True).robots]
    assert len(set(speeds)) > 1
    assert all(0.7 / 3.0 - 1e-3 <= speed <= 0.7 for speed in speeds)
    assert {robot.max_speed for robot in draw(6, seed=1).robots} == {0.7}


def test_headings_cover_the_circle() -> None:
    yaws = [pose[2] for robot in draw(6, seed=1).robots for pose in (robot.start, robot.goal)]
    assert max(yaws) - min(yaws) > math.pi and len(set(yaws)) == 12


def test_too_many_robots_are_refused() -> None:
    with pytest.raises(InvalidScenario, match="no room for 200 robots"):
        draw(200, seed=1)
