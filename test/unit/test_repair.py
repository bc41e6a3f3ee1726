"""Repair: round a robot that stands in the way, aside to let one pass, and an end where nothing helps."""

import time
from typing import Iterator, List, Optional, Sequence

import numpy as np
import pytest
from fleets import robot
from worlds import grid_from_text

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.replanning import PlannerReplanner, Replanner
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.coordination.verification import verify
from social_fleet.errors import Infeasible
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.overlays.discs import Disc
from social_fleet.planning.planner import SocialPlanner

HALL = "#" * 22 + ("\n#" + "." * 20 + "#") * 5 + "\n" + "#" * 22
CORRIDOR = "#" * 22 + "\n#" + "." * 20 + "#\n" + "#" * 22
ALCOVE = """
    ######################
    #######.##############
    #######.##############
    #....................#
    ######################
"""


def replanner(text: str) -> PlannerReplanner:
    grid = grid_from_text(text, 1.0)
    fine = type(grid)(np.kron(grid.values, np.ones((4, 4), dtype=np.int8)), 0.25, grid.origin)
    planner = SocialPlanner(fine, PlannerConfig(robot_radius=0.25))
    return PlannerReplanner(lambda radius: planner)


def check(fleet: FleetSchedule, text: str) -> None:
    assert verify(fleet).min_clearance >= 0.2 - 1e-6
    space = ConfigurationSpace(grid_from_text(text, 1.0), 0.24)
    assert all(space.is_free_path(schedule.robot.path.points) for schedule in fleet.schedules)


def test_two_that_start_in_each_other_s_way_in_a_wide_hall() -> None:
    pair = [robot("amr_3", (4, 3), (18, 3), goal_yaw=1.0), robot("amr_7", (14, 3), (2, 3))]
    with pytest.raises(Infeasible):
        coordinate(pair)
    fleet = coordinate(pair, replanner=replanner(HALL))
    check(fleet, HALL)
    assert "drives round" in fleet.message and "amr_3" in fleet.message and "amr_7" in fleet.message
    for before, after in zip(pair, fleet.schedules):
        assert after.name == before.name and after.robot.goal == before.goal
        assert np.array_equal(after.robot.path.points[[0, -1]], before.path.points[[0, -1]])
    changed = [after.name for before, after in zip(pair, fleet.schedules) if after.robot is not before]
    assert len(changed) == 1, "one goes round, the other keeps its path"


def test_one_that_stays_where_it_is_is_driven_round() -> None:
    fleet = coordinate([robot("parked", (10, 3)), robot("mover", (2, 3), (18, 3))], replanner=replanner(HALL))
    check(fleet, HALL)
    assert "mover drives round" in fleet.message and fleet["mover"].robot.path.length < 18.0


def test_in_a_single_lane_one_steps_aside() -> None:
    pair = [robot("left", (2.5, 1.5), (18.5, 1.5)), robot("right", (19.5, 1.5), (3.5, 1.5))]
    fleet = coordinate(pair, replanner=replanner(ALCOVE))
    check(fleet, ALCOVE)
    assert "steps aside for" in fleet.message
    aside = max(fleet.schedules, key=lambda schedule: schedule.robot.path.points[:, 1].max())
    assert aside.robot.path.points[:, 1].max() > 2.0 and aside.robot.path.length > 16.5


def test_where_nothing_helps_the_two_are_named_soon() -> None:
    pair = [robot("left", (2.5, 1.5), (18.5, 1.5)), robot("right", (19.5, 1.5), (3.5, 1.5)),
            robot("far", (10.5, 30), (20.5, 30))]
    tool = replanner(CORRIDOR)
    begun = time.monotonic()
    with pytest.raises(Infeasible) as caught:
        coordinate(pair, replanner=tool)
    assert caught.value.robots == ("left", "right")
    assert time.monotonic() - begun < 60.0


def test_a_schedule_under_way_is_not_replanned() -> None:
    tool = replanner(HALL)
    under_way = coordinate([robot("old", (14, 3), (2, 3))]).schedules
    fleet = coordinate([robot("new", (4, 3), (18, 3))], mode="unified", fixed=under_way, replanner=tool)
    assert "new drives round" in fleet.message
    assert verify([*under_way, *fleet.schedules]).min_clearance >= 0.2 - 1e-6


class Recorder(Replanner):
    """Offers a useless path for every wish, and remembers the wishes."""

    def __init__(self) -> None:
        self.wishes: List[str] = []

    def detour(self, robot: Robot, avoid: Sequence[Disc]) -> Optional[Robot]:
        self.wishes.append(f"{robot.name} round {len(avoid)}")
        return robot

    def aside(self, robot: Robot, others: Sequence[Robot], distance: float, avoid: Sequence[Disc]) -> Iterator[Robot]:
        self.wishes.append(f"{robot.name} aside")
        yield robot


def test_every_wish_is_made_once_and_then_it_ends() -> None:
    recorder = Recorder()
    with pytest.raises(Infeasible):
        coordinate([robot("a", (4, 3), (18, 3)), robot("b", (14, 3), (2, 3))], replanner=recorder)
    assert len(recorder.wishes) == 4, "round the start of the other, and aside, for each"
    assert set(recorder.wishes) == {"a round 1", "b round 1", "a aside", "b aside"}


def test_no_repairs_when_none_are_allowed() -> None:
    recorder = Recorder()
    with pytest.raises(Infeasible):
        coordinate([robot("a", (4, 3), (18, 3)), robot("b", (14, 3), (2, 3))], replanner=recorder, repairs=0)
    assert recorder.wishes == []
