"""From a scenario to schedules, with errors that name the robot and the field."""

from pathlib import Path
from typing import Any, List

import pytest
from worlds import grid_from_text

from social_fleet.coordination.verification import verify
from social_fleet.errors import InvalidGoal, InvalidStart, NoPath
from social_fleet.mapping.files import save_map
from social_fleet.scenario.scenario import Coordination, RobotSpec, Scenario
from social_fleet.scenario.fleet import FleetPlanner, coordinate_scenario, plan_fleet

ROOMS = """
    ##########
    #...#....#
    #...#....#
    #...#....#
    #...#....#
    ##########
"""


def scenario(*robots: RobotSpec, **options: Any) -> Scenario:
    return Scenario("room.yaml", "/room.yaml", robots, source="s.yaml", **options)


def test_robots_get_paths_from_start_to_goal() -> None:
    task = scenario(RobotSpec("a", (1.5, 1.5, 0.0), (3.5, 4.5), max_speed=0.5, depart=3.0, max_turn_rate=2.0),
                    RobotSpec("b", (6.5, 1.5), (8.5, 4.5), radius=0.4))
    done: List[int] = []
    robots = plan_fleet(task, grid_from_text(ROOMS), progress=done.append)
    assert done == [1, 2]
    assert [tuple(robot.path.points[0]) for robot in robots] == [(1.5, 1.5), (6.5, 1.5)]
    assert [tuple(robot.path.points[-1]) for robot in robots] == [(3.5, 4.5), (8.5, 4.5)]
    assert (robots[0].max_speed, robots[0].depart, robots[0].max_turn_rate, robots[0].start_yaw) == (0.5, 3.0, 2.0, 0.0)
    assert (robots[1].radius, robots[1].start_yaw) == (0.4, None)


@pytest.mark.parametrize("start, goal, kind, field", [
    ((0.5, 0.5), (3.5, 4.5), InvalidStart, "robots[1].start"),
    ((1.5, 1.5), (33.0, 4.5), InvalidGoal, "robots[1].goal"),
])
def test_an_unusable_pose_is_named(start: Any, goal: Any, kind: Any, field: str) -> None:
    task = scenario(RobotSpec("a", (6.5, 1.5), (8.5, 4.5)), RobotSpec("b", start, goal))
    with pytest.raises(kind, match="robot b") as caught:
        plan_fleet(task, grid_from_text(ROOMS))
    assert (caught.value.source, caught.value.field) == ("s.yaml", field)


def test_no_path_names_the_robot() -> None:
    with pytest.raises(NoPath, match="robot a: "):
        plan_fleet(scenario(RobotSpec("a", (1.5, 1.5), (6.5, 1.5))), grid_from_text(ROOMS))


def test_one_planner_for_each_radius() -> None:
    planners = FleetPlanner(grid_from_text(ROOMS), {"side": "left"})
    assert planners.for_radius(0.25) is planners.for_radius(0.25)
    assert planners.for_radius(0.4).config.robot_radius == 0.4
    assert planners.for_radius(0.4).config.side == "left"


@pytest.mark.parametrize("mode", ["simultaneous", "sequential", "unified"])
def test_a_scenario_becomes_a_safe_schedule(tmp_path: Path, mode: str) -> None:
    grid = grid_from_text("........\n" * 6)
    save_map(grid, str(tmp_path / "room.yaml"))
    task = Scenario("room.yaml", str(tmp_path / "room.yaml"),
                    (RobotSpec("a", (0.5, 2.5), (7.5, 2.5)), RobotSpec("b", (3.5, 0.5), (3.5, 5.5), max_speed=0.5)),
                    coordination=Coordination(mode=mode))
    fleet = coordinate_scenario(task)
    assert verify(fleet).safe
    assert [schedule.name for schedule in fleet.schedules] == ["a", "b"]
    assert fleet.map == str(tmp_path / "room.yaml") and fleet.planning_time > 0.0
