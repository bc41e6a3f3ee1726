"""The trackers' and the simulation's parameters, and the files that are their manuals."""

from dataclasses import asdict

import pytest
from repository import ROOT

from social_fleet.coordination.driven_path import CUT
from social_fleet.errors import InvalidParameter
from social_fleet.execution.config import TrackerConfig
from social_fleet.execution.recovery.config import RecoveryConfig
from social_fleet.files import read_yaml
from social_fleet.scenario.scenario import Coordination
from social_fleet.simulation.config import LidarConfig, SimulationConfig


def test_the_manual_of_the_tracker_shows_every_default() -> None:
    shown = read_yaml(ROOT / "config" / "tracker.yaml")
    assert set(asdict(TrackerConfig())) <= set(shown)
    assert {name: shown[name] for name in asdict(TrackerConfig())} == asdict(TrackerConfig())


def test_the_manual_of_recovery_shows_every_default() -> None:
    assert read_yaml(ROOT / "config" / "recovery.yaml") == asdict(RecoveryConfig())


def test_the_manual_of_the_simulation_shows_every_default() -> None:
    shown = read_yaml(ROOT / "config" / "fake_robots.yaml")
    assert LidarConfig.from_mapping(shown["lidar"]) == LidarConfig()
    assert set(shown["lidar"]) == set(asdict(LidarConfig()))
    assert {name: shown[name] for name in asdict(SimulationConfig())} == asdict(SimulationConfig())


def test_the_tracker_stays_within_what_the_coordination_leaves_it() -> None:
    """The budget of doc/execution.md: two robots at their limits, one released too early, do not touch."""
    config = TrackerConfig.from_mapping(read_yaml(ROOT / "config" / "tracker.yaml"))
    spent = config.lateral_limit + 0.5 * config.release_tolerance + CUT
    assert spent <= Coordination().tracking_tolerance + 1e-12


@pytest.mark.parametrize("values, field", [
    ({"period": 0.0}, "period"), ({"lag_begin": 0.2}, "lag_end"), ({"standoff": 0.04}, "release_tolerance"),
    ({"deviation_limit": 0.1}, "deviation_limit"), ({"gain": 1.0}, "gain")])
def test_a_tracker_refuses_what_contradicts_itself(values: dict, field: str) -> None:
    with pytest.raises(InvalidParameter) as caught:
        TrackerConfig.from_mapping(values, prefix="/gold/tracker/")
    assert caught.value.field == f"/gold/tracker/{field}"


def test_a_lidar_without_an_opening_is_refused() -> None:
    with pytest.raises(InvalidParameter, match="greater than angle_min"):
        LidarConfig(angle_min=1.0, angle_max=0.5)
