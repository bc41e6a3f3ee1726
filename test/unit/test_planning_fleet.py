"""What the planner node plans with: parameters, radii, tolerance, learning from the fleet's paths."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from social_fleet.errors import InvalidGoal, InvalidInput, InvalidParameter, NoPath
from social_fleet.geometry import Pose
from social_fleet.planning.config import PlannerConfig
from social_fleet.ros.planning_fleet import PlanningFleet, RobotEntry, read_config
from worlds import grid_from_text

ROOMS = grid_from_text("""
    ##############
    #......#.....#
    #............#
    #......#.....#
    ##############
""")
WEST, EAST = Pose(2.5, 2.5), Pose(10.5, 2.5)


def test_parameters_become_a_configuration_and_robots() -> None:
    config, robots = read_config({"side": "left", "robots": {"gold": {"radius": 0.4}}}, "", "/planner/")
    assert config == PlannerConfig(side="left")
    assert robots == {"gold": RobotEntry(radius=0.4)}


@pytest.mark.parametrize("given, name", [
    ({"side": "up"}, "/planner/side"), ({"sides": "left"}, "/planner/sides"), ({"robots": [1]}, "/planner/robots"),
    ({"robots": {"gold": {"radius": -1.0}}}, "/planner/robots/gold/radius"),
])
def test_a_wrong_parameter_is_refused_by_its_full_name(given: Any, name: str) -> None:
    with pytest.raises(InvalidParameter) as caught:
        read_config(given, "", "/planner/")
    assert caught.value.field == name


def test_a_scenario_goes_before_the_parameters(tmp_path: Path) -> None:
    scenario = tmp_path / "one.yaml"
    scenario.write_text("map: package://social_fleet/maps/crossing.yaml\nplanner: {side: left}\n"
                        "robots: [{name: gold, start: [1.5, 8.0], goal: [14.5, 8.0], radius: 0.3}]\n")
    config, robots = read_config({"side": "none", "w_right": 0.5, "robots": {"gold": {}}}, str(scenario), "/planner/")
    assert (config.side, config.w_right, robots["gold"].radius) == ("left", 0.5, 0.3)


def test_every_radius_has_its_planner() -> None:
    fleet = PlanningFleet(ROOMS, PlannerConfig(robot_radius=0.3))
    assert fleet.plan(0.3, WEST, EAST).robot_radius == 0.3
    with pytest.raises(NoPath):
        fleet.plan(0.8, WEST, EAST)


def test_a_blocked_goal_moves_within_the_tolerance() -> None:
    fleet = PlanningFleet(ROOMS, PlannerConfig(robot_radius=0.3))
    blocked = Pose(7.5, 1.5, 1.0)
    with pytest.raises(InvalidGoal):
        fleet.plan(0.3, WEST, blocked)
    with pytest.raises(InvalidGoal):
        fleet.plan(0.3, WEST, blocked, tolerance=0.5)
    plan = fleet.plan(0.3, WEST, blocked, tolerance=1.2)
    assert np.hypot(*(plan.points[-1] - blocked[:2])) <= 1.2
    assert plan.goal_yaw == 1.0


@pytest.mark.parametrize("tolerance", [-1.0, np.nan, np.inf])
def test_a_tolerance_that_is_none_is_refused(tolerance: float) -> None:
    with pytest.raises(InvalidInput, match="tolerance"):
        PlanningFleet(ROOMS, PlannerConfig()).plan(0.25, WEST, EAST, tolerance=tolerance)


def test_cells_of_a_path_are_neighbours() -> None:
    cells = PlanningFleet(ROOMS, PlannerConfig()).cells_of(np.array([(2.5, 1.5), (10.5, 3.4)]))
    steps = np.abs(np.diff(cells, axis=0)).max(axis=1)
    assert (steps == 1).all()
    assert (cells[0].tolist(), cells[-1].tolist()) == ([1, 2], [3, 10])


def test_the_graph_is_learnt_from_what_was_counted() -> None:
    fleet = PlanningFleet(ROOMS, PlannerConfig(heatmap_threshold=1, min_component=2))
    plan = fleet.plan(0.25, WEST, EAST)
    for _ in range(2):
        fleet.count(plan.cells)
    fleet.learn()
    assert fleet.counted == 2
    assert fleet.graph is not None and fleet.graph.edge_count == len(plan.cells) - 1
    assert fleet.planner(0.25).graph is fleet.graph


def test_a_graph_of_another_map_is_left_aside(tmp_path: Path, caplog: Any) -> None:
    other = PlanningFleet(grid_from_text("####\n#..#\n####"), PlannerConfig())
    other.learn()
    assert other.graph is not None
    other.graph.save(tmp_path / "other.graph")
    fleet = PlanningFleet(ROOMS, PlannerConfig(), str(tmp_path / "other.graph"))
    assert fleet.graph is None
    assert "another map" in caplog.text
