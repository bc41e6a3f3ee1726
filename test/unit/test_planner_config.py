"""The planner's parameters and their manual."""

import dataclasses
import math

import pytest
import yaml
from repository import ROOT

from social_fleet.errors import InvalidParameter
from social_fleet.planning.config import PlannerConfig


def test_the_manual_gives_the_defaults():
    text = (ROOT / "config" / "planner.yaml").read_text(encoding="utf-8")
    values = yaml.safe_load(text)
    assert PlannerConfig.from_mapping(values) == PlannerConfig()
    for field in dataclasses.fields(PlannerConfig):
        assert field.name in values or f"# {field.name}: " in text, field.name


def test_derived_defaults_follow_the_radius():
    config = PlannerConfig(robot_radius=0.3)
    assert config.lane_standoff == pytest.approx(0.4)
    assert config.fade_widths == pytest.approx((1.3, 1.5))
    assert PlannerConfig(standoff=0.0).lane_standoff == 0.0


@pytest.mark.parametrize("name, value", [
    ("robot_radius", 0.0), ("robot_radius", "wide"), ("robot_radius", math.nan), ("robot_radius", None),
    ("side", "middle"), ("side", 3), ("w_right", -1.0), ("w_const", math.inf), ("epsilon", -0.1), ("open_area", 0),
    ("standoff", -0.1), ("two_lane_width", 0.5), ("min_component", 2.5), ("min_component", True),
    ("w_right", 1e37), ("w_buf", 1e9), ("wall_stretch", 1e300), ("corner_radius", 1e300), ("epsilon", 1e6),
])
def test_wrong_values_are_refused_by_name(name, value):
    for build in (lambda: PlannerConfig(**{name: value}), lambda: PlannerConfig.from_mapping({name: value})):
        with pytest.raises(InvalidParameter) as caught:
            build()
        assert caught.value.field == name


def test_unknown_keys_are_refused_with_their_source():
    with pytest.raises(InvalidParameter) as caught:
        PlannerConfig.from_mapping({"speed": 1.0}, source="planner.yaml")
    assert (caught.value.source, caught.value.field) == ("planner.yaml", "speed")


def test_whole_numbers_do_for_lengths():
    assert PlannerConfig.from_mapping({"open_area": 10}).open_area == 10.0
