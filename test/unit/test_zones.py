"""Zones: their file, what they override, and what that does to costs and paths."""

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.errors import InvalidParameter
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.social_cost.norms import KeepSide, NoNorm
from social_fleet.planning.social_cost.zones import Zone, load_zones, zoned_norms, zones_of_map

HALL = grid_from_text("\n".join(["#" * 100] + ["." * 100] * 15 + ["#" * 100]), 0.2)  # 3 m wide, 20 m long
EAST_HALF = ((10.0, 0.0), (20.0, 0.0), (20.0, 4.0), (10.0, 4.0))
GOOD = """
zones:
  - name: ramp
    polygon: [[10, 0], [20, 0], [20, 4], [10, 4]]
    side: none
    w_right: 0.5
"""


def written(folder, text, name="hall.zones.yaml"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_a_file_is_read(tmp_path):
    zone, = load_zones(written(tmp_path, GOOD))
    assert zone.name == "ramp" and zone.polygon == EAST_HALF
    config = zone.config(PlannerConfig(w_buf=7.0))
    assert (config.side, config.w_right, config.w_buf) == ("none", 0.5, 7.0)


def test_a_side_goes_before_a_norm_that_holds_elsewhere():
    own = PlannerConfig(norm="own_norms.KeepOff")
    assert Zone("east", EAST_HALF, {"side": "left"}).config(own).norm is None
    assert Zone("east", EAST_HALF, {"w_right": 2.0}).config(own).norm == "own_norms.KeepOff"


@pytest.mark.parametrize("text, field", [
    ("[]", "zones"), ("zones: 3", "zones"), ("zones: []\nplaces: []", "places"),
    ("zones: [3]", "zones[0]"), ("zones: [{polygon: [[0, 0], [1, 0], [1, 1]]}]", "zones[0].name"),
    ("zones: [{name: a}]", "zones[0].polygon"),
    ("zones: [{name: '', polygon: [[0, 0], [1, 0], [1, 1]]}]", "zones[0].name"),
    ("zones: [{name: a, polygon: [[0, 0], [1, 1], [1, 0], [0, 1]]}]", "zones[0].polygon"),
    ("zones: [{name: a, polygon: [[0, 0], [1, 1], [x, 0]]}]", "zones[0].polygon[2]"),
    ("zones: [{name: a, polygon: [[0, 0], [1, 0], [1, 1]], side: up}]", "zones[0].side"),
    ("zones: [{name: a, polygon: [[0, 0], [1, 0], [1, 1]], w_right: -1}]", "zones[0].w_right"),
    ("zones: [{name: a, polygon: [[0, 0], [1, 0], [1, 1]], w_right: much}]", "zones[0].w_right"),
    ("zones: [{name: a, polygon: [[0, 0], [1, 0], [1, 1]], norm: own_norms.Missing}]", "zones[0].norm"),
    ("zones: [{name: a, polygon: [[0, 0], [1, 0], [1, 1]], robot_radius: 1.0}]", "zones[0].robot_radius"),
])
def test_what_is_wrong_is_named_by_file_and_field(tmp_path, text, field):
    path = written(tmp_path, text)
    with pytest.raises(InvalidParameter) as error:
        load_zones(path)
    assert (error.value.source, error.value.field) == (str(path), field)


def test_a_file_that_is_no_yaml_is_refused(tmp_path):
    with pytest.raises(InvalidParameter):
        load_zones(written(tmp_path, "zones: ["))


def test_zones_beside_the_map_are_found_unless_others_or_none_are_named(tmp_path):
    map_path = tmp_path / "hall.yaml"
    assert zones_of_map(map_path) == []
    written(tmp_path, GOOD)
    other = written(tmp_path, GOOD.replace("ramp", "canteen"), "other.yaml")
    assert [zone.name for zone in zones_of_map(map_path)] == ["ramp"]
    assert [zone.name for zone in zones_of_map(map_path, str(other))] == ["canteen"]
    assert zones_of_map(map_path, "none") == []
    with pytest.raises(InvalidParameter):
        zones_of_map(map_path, str(tmp_path / "missing.yaml"))


def test_the_last_of_overlapping_zones_holds():
    cells = np.argwhere(~HALL.blocked)
    whole = ((0.0, 0.0), (20.0, 0.0), (20.0, 4.0), (0.0, 4.0))
    zones = [Zone("all", whole, {"side": "left"}), Zone("east", EAST_HALF, {"side": "none"})]
    norms = zoned_norms(HALL, cells, PlannerConfig(), zones)
    assert [type(norm) for _, norm in norms] == [KeepSide, NoNorm]
    assert (HALL.centres(cells[norms[0][0]])[:, 0] < 10.0).all()
    assert len(norms[0][0]) + len(norms[1][0]) == len(cells)
    assert [type(norm) for _, norm in zoned_norms(HALL, cells, PlannerConfig(), zones[::-1])] == [KeepSide]


def test_a_zones_own_norm_that_is_missing_is_named():
    with pytest.raises(InvalidParameter, match="zone east: the module nowhere") as error:
        zoned_norms(HALL, np.array([[5, 80]]), PlannerConfig(), [Zone("east", EAST_HALF, {"norm": "nowhere.Norm"})])
    assert error.value.field == "norm"


def test_robots_change_sides_where_a_zone_says_so():
    zone = Zone("east", EAST_HALF, {"side": "left"})
    plan = SocialPlanner(HALL, PlannerConfig(), zones=[zone]).plan((1.0, 1.7), (19.0, 1.7))
    path = plan.path
    heights = path.position(np.array([0.3, 0.7]) * path.length)[:, 1]
    assert heights[0] < 1.0 and heights[1] > 2.4


def test_without_a_norm_in_a_zone_its_edges_cost_their_length():
    zones = [Zone("east", EAST_HALF, {"side": "none"})]
    planner = SocialPlanner(HALL, PlannerConfig(exemption_radius=0.0), zones=zones)
    assert planner.plan((11.0, 1.7), (19.0, 1.7)).social_cost == pytest.approx(0.0)
    assert SocialPlanner(HALL, PlannerConfig(exemption_radius=0.0)).plan((11.0, 1.7), (19.0, 1.7)).social_cost > 0.0
