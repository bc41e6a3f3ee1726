"""Obstacles from hits: discs with names that come after a while, and go when the place is seen to be empty."""

import math

import numpy as np
import pytest

from social_fleet.execution.obstacle_watch import ObstacleWatch
from social_fleet.execution.recovery.config import RecoveryConfig
from social_fleet.execution.recovery.messages import Body
from social_fleet.execution.tracker import Tracker
from social_fleet.geometry import Pose
from social_fleet.planning.overlays.shapes import DiscObstacle
from social_fleet.scenario.agent import Agent
from social_fleet.simulation.sight import hits

HERE = Pose(0.0, 0.0, 0.0)
THING = DiscObstacle(1.5, 0.5, 0.3)


def seen(*things: DiscObstacle) -> np.ndarray:
    return hits(0.0, 0.0, np.array([(thing.x, thing.y, thing.radius) for thing in things]).reshape(-1, 3), 4.0)


def watch(points_at, times, known=None, visible=True) -> ObstacleWatch:  # type: ignore[no-untyped-def]
    found = ObstacleWatch("gold", settle=2.0)
    for now in times:
        found.see(now, HERE, points_at(now), known or {}, lambda shape: visible)
    return found


@pytest.mark.parametrize("x, y, radius", [(1.5, 0.5, 0.3), (-1.0, 0.2, 0.2), (0.8, 0.0, 0.4)])
def test_a_thing_that_stands_still_becomes_a_disc_of_its_size(x: float, y: float, radius: float) -> None:
    found = watch(lambda now: seen(DiscObstacle(x, y, radius)), np.arange(0.0, 4.0, 0.25))
    (name, shape), = found.obstacles.items()
    assert name == "gold/1" and math.hypot(shape.x - x, shape.y - y) < 0.05
    assert shape.radius == pytest.approx(radius, abs=0.05)


def test_what_has_not_stood_for_long_or_moves_is_none() -> None:
    assert not watch(lambda now: seen(THING), [0.0, 1.0, 1.9]).obstacles
    assert not watch(lambda now: seen(DiscObstacle(1.5, -2.0 + 0.6 * now, 0.25)), np.arange(0.0, 6.0, 0.25)).obstacles


def test_who_passes_leaves_no_obstacle_behind() -> None:
    assert not watch(lambda now: seen(THING) if now < 1.0 else seen(), np.arange(0.0, 6.0, 0.25)).obstacles


def test_two_things_are_two_obstacles() -> None:
    found = watch(lambda now: seen(THING, DiscObstacle(1.5, -1.0, 0.3)), np.arange(0.0, 3.0, 0.25))
    assert len(found.obstacles) == 2


def test_one_that_another_robot_has_named_gets_no_second_name() -> None:
    assert not watch(lambda now: seen(THING), np.arange(0.0, 4.0, 0.25), known={"blue/1": THING}).obstacles


def test_a_place_that_is_seen_to_be_empty_is_cleared_whoever_named_it() -> None:
    found = watch(lambda now: seen(THING) if now < 3.0 else seen(), np.arange(0.0, 6.0, 0.25),
                  known={"blue/1": DiscObstacle(-1.0, 0.0, 0.2)})
    assert not found.obstacles and set(found.cleared) == {"gold/1", "blue/1"}


def test_what_cannot_be_seen_is_not_cleared() -> None:
    known = {"blue/1": DiscObstacle(-1.0, 0.0, 0.2), "blue/2": DiscObstacle(8.0, 0.0, 0.2)}
    assert not watch(lambda now: seen(), np.arange(0.0, 6.0, 0.25), known=known, visible=False).cleared
    assert watch(lambda now: seen(), np.arange(0.0, 6.0, 0.25), known=known).cleared == ("blue/1",)


def test_what_others_have_cleared_is_forgotten() -> None:
    found = watch(lambda now: seen(THING), np.arange(0.0, 3.0, 0.25))
    found.forget(["gold/1"])
    assert not found.obstacles


def test_a_program_that_starts_anew_gives_other_names() -> None:
    """What was seen to be gone under a name never counts again."""
    names = []
    for session in (3, 4):
        agent = Agent("gold", Body(), Tracker(), session, RecoveryConfig(), None)
        for now in np.arange(0.0, 4.0, 0.25):
            agent.step(now, HERE, HERE, np.array([(0.0, 0.0, 0.25), (1.5, 0.5, 0.3)]), 0)
        names += agent.member.obstacles
    assert len(set(names)) == 2
