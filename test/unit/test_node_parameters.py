"""config/*.yaml is the manual of the nodes' parameters: each file shows all of them, with their defaults."""

import dataclasses
import sys
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("social_fleet.msg", reason="needs the built workspace's messages; tools/test has them")

from repository import ROOT  # noqa: E402
from social_fleet.errors import InvalidScenario  # noqa: E402
from social_fleet.execution.navigation_state import NavigationConfig  # noqa: E402
from social_fleet.files import read_yaml  # noqa: E402
from social_fleet.parameters import from_mapping  # noqa: E402
from social_fleet.planning.config import PlannerConfig  # noqa: E402
from social_fleet.ros.eyes import EyesParameters  # noqa: E402
from social_fleet.ros.fake_robots import FakeRobotsParameters  # noqa: E402
from social_fleet.ros.fleet_coordinator import FleetCoordinatorParameters, as_scenario  # noqa: E402
from social_fleet.ros.navigator import NavigatorParameters  # noqa: E402
from social_fleet.ros.reconfigure import description  # noqa: E402
from social_fleet.ros.social_planner import SocialPlannerParameters  # noqa: E402
from social_fleet.ros.trajectory_tracker import TrajectoryTrackerParameters  # noqa: E402
from social_fleet.simulation.config import LidarConfig  # noqa: E402

# What launch files set from their arguments is not in the files.
SET_BY_LAUNCH = {"scenario", "graph_file"}
# Parameters of the core that stand in the same file as the node's.
CORE = {NavigatorParameters: NavigationConfig}


@pytest.mark.parametrize("file, kind", [
    ("fake_robots_node.yaml", FakeRobotsParameters), ("fleet_coordinator.yaml", FleetCoordinatorParameters),
    ("social_planner.yaml", SocialPlannerParameters), ("trajectory_tracker.yaml", TrajectoryTrackerParameters),
    ("navigator.yaml", NavigatorParameters),
])
def test_the_file_shows_every_parameter_and_its_default(file: str, kind: Any) -> None:
    shown = read_yaml(ROOT / "config" / file)
    values = {name: value for name, value in shown.items() if name not in ("robots", "lidar")}
    core = CORE.get(kind)
    names = {field.name for part in (kind, core) if part for field in dataclasses.fields(part)}
    assert set(values) == names - SET_BY_LAUNCH
    for part in (kind, core):
        if part:
            own = {field.name for field in dataclasses.fields(part)}
            assert from_mapping(part, {name: value for name, value in values.items() if name in own}) == part()


def test_the_lidar_has_its_defaults() -> None:
    shown = read_yaml(ROOT / "config" / "fake_robots_node.yaml")
    assert LidarConfig.from_mapping(shown["lidar"]) == LidarConfig()
    assert set(shown["lidar"]) == {field.name for field in dataclasses.fields(LidarConfig)}


def test_a_scenario_goes_before_the_coordinators_parameters_unless_its_robots_might_touch(tmp_path: Path) -> None:
    file, text = tmp_path / "one.yaml", (ROOT / "config" / "scenarios" / "crossing.yaml").read_text()
    text = text.replace("../../maps", str(ROOT / "maps")).split("\ncoordination:")[0]
    file.write_text(text + "\ncoordination: {time_margin: 2.5}\n")
    assert as_scenario(FleetCoordinatorParameters(scenario=str(file))).time_margin == 2.5
    file.write_text(text + "\ncoordination: {formulation: paper}\n")
    with pytest.raises(InvalidScenario, match="coordination.formulation: must be exact"):
        as_scenario(FleetCoordinatorParameters(scenario=str(file)))


def test_the_page_of_parameters_is_up_to_date() -> None:
    sys.path.insert(0, str(ROOT / "tools"))
    try:
        from parameter_pages import document
    finally:
        sys.path.pop(0)
    assert (ROOT / "doc" / "parameters.md").read_text(encoding="utf-8") == document(), "run ./tools/document_parameters"


def test_what_can_change_under_way_is_explained_and_bounded() -> None:
    config = PlannerConfig(w_right=1.5)
    described = description(config)
    assert {"side", "w_right", "w_const", "w_buf"} <= set(described.defaults)
    assert not {"robot_radius", "norm", "standoff"} & set(described.defaults)
    for entry in described.config_description["parameters"]:
        assert entry["description"], entry["name"]
        assert entry["default"] == getattr(config, entry["name"])
        assert all(isinstance(entry[bound], type(entry["default"])) for bound in ("min", "max"))


def test_the_trackers_lidar_has_its_defaults() -> None:
    shown = read_yaml(ROOT / "config" / "trajectory_tracker.yaml")
    assert from_mapping(EyesParameters, shown["lidar"]) == EyesParameters()
    assert set(shown["lidar"]) == {field.name for field in dataclasses.fields(EyesParameters)}
