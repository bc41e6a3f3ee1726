"""What the planner node plans with: parameters, radii, tolerance, learning from the fleet's paths."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from social_fleet.errors import InvalidGoal, InvalidParameter, InvalidPose, InvalidStart, NoPath
from social_fleet.geometry import Pose
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.overlays.shapes import DiscObstacle
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


def test_a_start_too_near_to_a_wall_is_left_straight() -> None:
    fleet = PlanningFleet(ROOMS, PlannerConfig(robot_radius=0.4))
    start = Pose(1.2, 2.5)
    with pytest.raises(InvalidStart):
        fleet.plan(0.4, start, EAST)
    plan = fleet.plan(0.4, start, EAST, start_tolerance=0.5)
    assert tuple(plan.points[0]) == (1.2, 2.5) and tuple(plan.points[-1]) == (10.5, 2.5)
    assert plan.length == pytest.approx(plan.path.length)
    assert "0.30 m straight" in plan.message
    with pytest.raises(InvalidStart):
        fleet.plan(0.4, Pose(0.5, 2.5), EAST, start_tolerance=2.0)  # in the wall itself


def test_an_obstacle_of_one_robot_is_none_to_others() -> None:
    fleet = PlanningFleet(ROOMS, PlannerConfig(robot_radius=0.4))
    fleet.overlays.add("door", DiscObstacle(7.5, 2.5, 0.4), robot="gold")
    assert fleet.plan(0.4, WEST, EAST, robot="blue").length > 0.0
    with pytest.raises(NoPath):
        fleet.plan(0.4, WEST, EAST, robot="gold")


def test_the_message_says_where_the_path_ends() -> None:
    fleet = PlanningFleet(ROOMS, PlannerConfig(robot_radius=0.3))
    plan = fleet.plan(0.3, WEST, Pose(7.5, 1.5, 1.0), tolerance=1.2)
    assert f"the path ends {plan.goal_shift:.2f} m from it" in plan.message


def test_cells_of_a_path_are_neighbours() -> None:
    cells = PlanningFleet(ROOMS, PlannerConfig()).cells_of(np.array([(2.5, 1.5), (10.5, 3.4)]))
    steps = np.abs(np.diff(cells, axis=0)).max(axis=1)
    assert (steps == 1).all()
    assert (cells[0].tolist(), cells[-1].tolist()) == ([1, 2], [3, 10])


def learning_fleet(grid: OccupancyGrid = ROOMS, **values: Any) -> PlanningFleet:
    return PlanningFleet(grid, PlannerConfig(heatmap_threshold=1, min_component=2, temporary_distance=1.5, **values))


def test_the_graph_is_learnt_from_what_was_counted() -> None:
    fleet = learning_fleet()
    fleet.planner(0.3)
    plan = fleet.plan(0.25, WEST, EAST)
    for counted in (1, 2):
        assert not fleet.has_to_learn(2)
        fleet.count(plan)
        assert fleet.counted == counted
    assert fleet.has_to_learn(2)
    fleet.learn()
    assert not fleet.has_to_learn(1)
    assert fleet.graph is not None and fleet.graph.edge_count == len(plan.cells) - 1
    for radius in (0.25, 0.3, 0.35):
        assert fleet.planner(radius).graph is fleet.graph


def test_paths_of_others_count() -> None:
    fleet = learning_fleet()
    for _ in range(2):
        fleet.count_path(np.array([(2.5, 1.5), (2.5, 3.5)]), temporary=False)
    for beyond in (33.5, 1e12):  # of which the second would be too long to be gone along
        with pytest.raises(InvalidPose):
            fleet.count_path(np.array([(2.5, 1.5), (2.5, beyond)]), temporary=False)
    fleet.learn()
    assert fleet.graph is not None and fleet.graph.edge_count == 2


def test_detours_leave_the_graph_alone_until_the_obstacle_is_permanent(caplog: Any) -> None:
    fleet = learning_fleet(promotion_threshold=2)
    fleet.overlays.add("cart", DiscObstacle(4.0, 3.4, 0.3))
    plan = fleet.plan(0.25, WEST, EAST)
    assert plan.temporary
    fleet.count(plan)
    fleet.count_path(plan.points, temporary=True)
    fleet.count_path(np.array([(10.5, 1.5), (10.5, 3.5)]), temporary=True)  # round what this planner does not know
    assert fleet.counted == 0 and not fleet.has_to_learn(1)
    fleet.learn()
    assert fleet.graph is not None and fleet.graph.edge_count == 0
    fleet.count(plan)
    assert fleet.has_to_learn(100)
    fleet.learn()
    assert fleet.graph.edge_count and "'cart' counts as permanent" in caplog.text
    assert not fleet.plan(0.25, WEST, EAST).temporary


def test_a_graph_of_another_map_is_left_aside_when_nothing_of_it_holds(tmp_path: Path, caplog: Any) -> None:
    other = PlanningFleet(grid_from_text("####\n#..#\n####"), PlannerConfig())
    other.learn()
    assert other.graph is not None
    other.graph.save(tmp_path / "other.graph")
    fleet = PlanningFleet(ROOMS, PlannerConfig(), str(tmp_path / "other.graph"))
    assert fleet.graph is None
    assert "other.graph was learnt on another map: 0 of its edges still hold on this one, 0 are dropped" in caplog.text


def test_a_graph_file_of_another_map_is_adapted(tmp_path: Path, caplog: Any) -> None:
    fleet = learning_fleet()
    for _ in range(2):
        fleet.count(fleet.plan(0.25, WEST, EAST))
    fleet.learn()
    assert fleet.graph is not None
    fleet.graph.save(tmp_path / "rooms.graph")
    wider = OccupancyGrid(np.pad(ROOMS.values, ((0, 0), (0, 3)), constant_values=100), 1.0)
    adapted = PlanningFleet(wider, PlannerConfig(), str(tmp_path / "rooms.graph"))
    assert adapted.graph is not None and adapted.graph.edge_count == fleet.graph.edge_count
    assert adapted.planner(0.25).graph is adapted.graph
    assert f"{fleet.graph.edge_count} of its edges still hold on this one, 0 are dropped" in caplog.text


@pytest.mark.parametrize("content, words", [(b"PK cut short", "cut short"), (None, "No such file")])
def test_a_graph_file_that_cannot_be_used_is_left_aside(tmp_path: Path, caplog: Any, content: Any, words: str) -> None:
    if content is not None:
        (tmp_path / "g").write_bytes(content)
    assert PlanningFleet(ROOMS, PlannerConfig(), str(tmp_path / "g")).graph is None
    assert "left aside" in caplog.text and words in caplog.text


def test_a_new_map_keeps_what_still_holds(caplog: Any) -> None:
    before = learning_fleet()
    before.overlays.add("cart", DiscObstacle(4.0, 1.4, 0.3), expires=9.0)
    before.overlays.add("box", DiscObstacle(12.0, 2.5, 0.3))
    for _ in range(2):
        before.count_path(np.array([(2.5, 2.5), (11.5, 2.5)]), temporary=False)
    before.learn()
    smaller = OccupancyGrid(ROOMS.values[:, :10], 1.0)
    after = PlanningFleet(smaller, PlannerConfig(), "", before)
    assert after.graph is not None and after.graph.edge_count == 7
    assert "7 of its edges still hold on this one, 2 are dropped" in caplog.text
    assert [overlay.name for overlay in after.overlays.all] == ["cart"] and "forgotten: box" in caplog.text
    coarser = PlanningFleet(OccupancyGrid(ROOMS.values, 2.0), PlannerConfig(), "", before)
    assert coarser.graph is None and "cells of 1 m, and the map has cells of 2 m" in caplog.text
