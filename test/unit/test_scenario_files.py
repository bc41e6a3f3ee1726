"""Scenario files are read strictly, and written such that they read back."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
from repository import ROOT
from worlds import grid_from_text

from social_fleet.errors import InvalidScenario
from social_fleet.mapping.files import save_map
from social_fleet.scenario.files import load_scenario, save_scenario
from social_fleet.scenario.scenario import Expect, RobotSpec, Scenario
from social_fleet.simulation.faults import CircleObstacle, Fault

GOOD = """\
map: room.yaml
robots:
  - {name: gold, start: [1, 1, 0.5], goal: [7, 1], max_speed: 0.7, radius: 0.25, depart: 2.0}
  - {name: blue, start: [1, 3], goal: [7, 3], max_turn_rate: 2.0}
planner: {side: left}
coordination: {mode: sequential, time_margin: 2}
obstacles: [{shape: circle, center: [4, 2], radius: 0.6, appears: 30.0, disappears: 90.0}]
faults: [{robot: gold, kind: pause, at: 20.0, duration: 15.0}]
expect: {arrived: [gold], collisions: 1, max_lateness: 2.0}
"""


@pytest.fixture(name="folder")
def make_folder(tmp_path: Path) -> Path:
    save_map(grid_from_text("........\n" * 4), str(tmp_path / "room.yaml"))
    return tmp_path


def load(folder: Path, text: str) -> Scenario:
    (folder / "s.yaml").write_text(text)
    return load_scenario(folder / "s.yaml")


def test_every_field_is_read(folder: Path) -> None:
    scenario = load(folder, GOOD)
    assert scenario.map_path == str(folder / "room.yaml") and scenario.name == "s"
    assert scenario.robots == (
        RobotSpec("gold", (1.0, 1.0, 0.5), (7.0, 1.0), 0.7, 0.25, 2.0),
        RobotSpec("blue", (1.0, 3.0), (7.0, 3.0), max_turn_rate=2.0))
    assert (scenario.coordination.mode, scenario.coordination.time_margin) == ("sequential", 2.0)
    assert scenario.planner == {"side": "left"}
    assert scenario.obstacles == (CircleObstacle(4.0, 2.0, 0.6, 30.0, 90.0),)
    assert scenario.faults == (Fault("gold", "pause", 20.0, 15.0),)
    assert scenario.expect == Expect(("gold",), 1, 2.0)


def test_little_is_needed(folder: Path) -> None:
    scenario = load(folder, "map: room.yaml\nrobots: [{name: a, start: [1, 1], goal: [2, 2]}]\n")
    assert scenario.robots[0] == RobotSpec("a", (1.0, 1.0), (2.0, 2.0), 0.7, 0.25, 0.0)
    assert scenario.expect == Expect(None, 0) and scenario.coordination.mode == "simultaneous"


def test_what_is_written_is_read_back(folder: Path) -> None:
    scenario = load(folder, GOOD)
    endless = replace(scenario, obstacles=(CircleObstacle(1.0, 1.0, 0.5),), source=str(folder / "t.yaml"))
    for original in (replace(scenario, source=str(folder / "t.yaml")), endless):
        save_scenario(original, folder / "t.yaml")
        assert load_scenario(folder / "t.yaml") == original
    assert math.isinf(load_scenario(folder / "t.yaml").obstacles[0].disappears)


@pytest.mark.parametrize("old, new, field, message", [
    ("map: room.yaml\n", "", "map", "is missing"),
    ("room.yaml", "none.yaml", "map", "there is no file"),
    ("room.yaml", "package://other/a.yaml", "map", "only package://social_fleet/"),
    ("room.yaml", "3", "map", "must be a text, not 3"),
    ("robots:", "robotts:", "robots", "is missing"),
    ("planner:", "plannner:", "plannner", "did you mean planner"),
    ("name: blue", "name: gold", "robots[1].name", "robots[0] has the name gold too"),
    ("name: blue, ", "", "robots[1].name", "is missing"),
    ("start: [1, 3]", "start: [1]", "robots[1].start", "must be a list [x, y, yaw], not [1]"),
    ("start: [1, 3]", "start: [1, .nan]", "robots[1].start[1]", "must be a finite number, not nan"),
    ("start: [1, 3]", "start: [.inf, 3]", "robots[1].start[0]", "must be a finite number, not inf"),
    ("start: [1, 3]", "start: [1, up]", "robots[1].start[1]", "must be a number, not the text 'up'"),
    ("start: [1, 3]", "start: [1, 1.5]", "robots[1].start",
     "robot blue would stand 0.50 m from the start of robot gold; their centres need 0.70 m"),
    ("goal: [7, 3]", "goal: [7, 1]", "robots[1].goal", "robot blue would stand 0.00 m from the goal of robot gold"),
    ("max_speed: 0.7", "max_speed: 0", "robots[0].max_speed", "must be greater than 0, not 0"),
    ("max_speed: 0.7", "max_speed: -1", "robots[0].max_speed", "must be greater than 0, not -1"),
    ("max_speed: 0.7", "max_speed: .nan", "robots[0].max_speed", "must be a finite number"),
    ("radius: 0.25", "radius: 0", "robots[0].radius", "must be greater than 0"),
    ("radius: 0.25", "radius: wide", "robots[0].radius", "must be a number"),
    ("depart: 2.0", "depart: -2", "robots[0].depart", "must not be less than 0"),
    ("depart", "departs", "robots[0].departs", "did you mean depart"),
    ("{side: left}", "{side: up}", "planner.side", "must be one of right, left, none"),
    ("{side: left}", "{sid: left}", "planner.sid", "parameter"),
    ("{side: left}", "{robot_radius: 0.3}", "planner.robot_radius", "give each robot its radius"),
    ("{side: left}", "[1]", "planner", "must be a mapping"),
    ("mode: sequential", "mode: both", "coordination.mode", "must be simultaneous or sequential or unified"),
    ("time_margin: 2", "time_margin: soon", "coordination.time_margin", "must be a number"),
    ("shape: circle", "shape: square", "obstacles[0].shape", "must be circle"),
    ("disappears: 90.0", "disappears: 9.0", "obstacles[0].disappears", "must be later than appears, which is 30"),
    ("robot: gold", "robot: red", "faults[0].robot", "must be gold or blue or dispatcher, not the text 'red'"),
    ("kind: pause", "kind: explode", "faults[0].kind", "must be pause or slow"),
    ("arrived: [gold]", "arrived: [red]", "expect.arrived", "must be all or a list of robots of this file"),
    ("collisions: 1", "collisions: few", "expect.collisions", "must be a whole number"),
    (GOOD, "- 1\n", "", "must be a mapping of names to values"),
    (GOOD, "map: room.yaml\nrobots: []\n", "robots", "must list at least one robot"),
])
def test_what_is_wrong_is_named(folder: Path, old: str, new: str, field: str, message: str) -> None:
    assert old in GOOD
    with pytest.raises(InvalidScenario) as caught:
        load(folder, GOOD.replace(old, new, 1))
    assert caught.value.field == field
    assert message in caught.value.message
    assert caught.value.source == str(folder / "s.yaml")


@pytest.mark.parametrize("text, message", [
    ("map: [", "line 1, column 7: not valid YAML"),
    ("map: a\nmap: b\n", "line 2, column 1: not valid YAML: the key 'map' is there twice"),
    ("", "must be a mapping of names to values, not empty"),
])
def test_a_file_that_is_not_a_scenario_is_refused(folder: Path, text: str, message: str) -> None:
    with pytest.raises(InvalidScenario) as caught:
        load(folder, text)
    assert message in str(caught.value)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidScenario, match="there is no such file"):
        load_scenario(tmp_path / "none.yaml")


@pytest.mark.parametrize("path", sorted((ROOT / "config" / "scenarios").glob("*.yaml")), ids=lambda path: path.stem)
def test_the_scenarios_of_the_package_load(path: Path) -> None:
    assert load_scenario(path).map.startswith("package://social_fleet/maps/")
