"""The judge of runs with faults, on motion drawn by hand."""

from dataclasses import replace
from typing import Any, Dict, Sequence

import numpy as np
from worlds import grid_from_text

from social_fleet.scenario.recording import Recording
from social_fleet.scenario.scenario import RobotSpec, Scenario
from social_fleet.scenario.verdict import Verdict, judge_faulty_run
from social_fleet.simulation.faults import CircleObstacle, Fault

HALL = grid_from_text("\n".join(["#" * 28, *["#" + "." * 26 + "#"] * 18, "#" * 28]), 0.25)
PERIOD = 0.1
GOLD = RobotSpec("gold", (1.0, 1.0), (4.0, 1.0))
GREEN = RobotSpec("green", (1.0, 3.0), (4.0, 3.0))
SCENARIO = Scenario("hall", "hall", (GOLD, GREEN))


def along(start: Sequence[float], goal: Sequence[float], steps: int, *, rest: int = 20) -> np.ndarray:
    """Poses that speed up and slow down evenly between two places, then rest."""
    share = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, steps))
    way = np.outer(1.0 - share, start[:2]) + np.outer(share, goal[:2])
    way = np.vstack((way, np.repeat(way[-1:], rest, axis=0)))
    return np.hstack((way, np.zeros((len(way), 1))))


def judged(gold: np.ndarray, green: np.ndarray, scenario: Scenario = SCENARIO, *,
           gave_up: Dict[str, str] = {}, commands: Any = None) -> Verdict:  # noqa: B006
    poses = np.stack((gold, green), axis=1)
    if commands is None:
        commands = np.zeros((len(poses) - 1, 2, 2))
    return judge_faulty_run(scenario, Recording(("gold", "green"), PERIOD * np.arange(len(poses)), poses), commands,
                            HALL, gave_up)


THERE, ALSO = along(GOLD.start, GOLD.goal, 80), along(GREEN.start, GREEN.goal, 80)


def test_all_arrive_and_nothing_is_wrong() -> None:
    verdict = judged(THERE, ALSO)
    assert verdict.passed and verdict.arrived == ("gold", "green") and not verdict.failures
    assert verdict.min_clearance is not None and abs(verdict.min_clearance - 1.5) < 1e-9
    assert 6.0 < verdict.arrivals["gold"] < 8.0


def test_one_that_stops_half_way_waits_without_end() -> None:
    verdict = judged(along(GOLD.start, (2.5, 1.0), 80), ALSO)
    assert verdict.stranded == ("gold",) and verdict.failures == ("robot gold waits without end",)


def test_giving_up_is_right_only_without_a_way() -> None:
    half = along(GOLD.start, (2.5, 1.0), 80)
    assert "gave up though there is a way" in judged(half, ALSO, gave_up={"gold": "tired"}).failures[0]
    wall = tuple(CircleObstacle(3.4, 0.4 + 0.5 * number, 0.3) for number in range(8))
    behind = along(GREEN.start, (1.5, 3.0), 40, rest=60)
    blocked = replace(SCENARIO, obstacles=wall, faults=(Fault("green", "dead", 3.0),))
    verdict = judged(half, behind, blocked, gave_up={"gold": "blocked"})
    assert verdict.passed and set(verdict.excused) == {"gold", "green"}
    assert judged(half, behind, blocked).failures == ("robot gold waits without end",)


def test_the_last_errand_counts() -> None:
    other = replace(SCENARIO, faults=(Fault("gold", "errand", 1.0, goal=(3.0, 1.0)),))
    assert judged(THERE, ALSO, other).stranded == ("gold",)
    assert judged(along(GOLD.start, (3.0, 1.0), 80), ALSO, other).passed


def test_contacts_of_all_kinds() -> None:
    assert "gold and green touch" in judged(along(GOLD.start, GOLD.goal, 80), along((1.0, 1.45), GOLD.goal, 80)
                                            ).failures[0]
    wall = judged(along((1.0, 0.47), GOLD.goal, 80), ALSO)
    assert any("gold and a wall touch" in failure for failure in wall.failures)
    there = replace(SCENARIO, obstacles=(CircleObstacle(2.5, 1.2, 0.2),))
    assert "gold and an obstacle touch" in judged(THERE, ALSO, there).failures[0]


def test_what_falls_on_a_robot_is_not_its_fault() -> None:
    there = replace(SCENARIO, obstacles=(CircleObstacle(*THERE[40, :2], 0.2, 4.0, 5.0),))
    assert judged(THERE, ALSO, there).passed
    later = replace(SCENARIO, obstacles=(CircleObstacle(*THERE[70, :2], 0.2, 4.0, 9.0),))
    assert not judged(THERE, ALSO, later).passed


def test_limits_of_commands_and_of_motion() -> None:
    fast = judged(along(GOLD.start, GOLD.goal, 40, rest=60), ALSO)
    assert any("gold: motion exceed the speed" in text for text in fast.exceeded)
    commands = np.zeros((99, 2, 2))
    commands[10:, 0, 0] = 0.2
    assert judged(THERE, ALSO, commands=commands).exceeded == (
        "robot gold: commands exceed the acceleration of speed",)
    commands[10:20, 0, 0] = 0.1
    assert not judged(THERE, ALSO, commands=commands).exceeded
    commands[50, 1, 1] = np.nan
    assert not judged(THERE, ALSO, commands=commands).exceeded
    commands[60, 1, 0] = -0.05
    assert "robot green is commanded backwards" in judged(THERE, ALSO, commands=commands).exceeded
