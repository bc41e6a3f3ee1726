"""Fleet files: the one that is shipped, and what is refused by file and field."""

from pathlib import Path

import pytest

pytest.importorskip("rospy", reason="needs ROS")

from repository import ROOT  # noqa: E402
from social_fleet.errors import InvalidParameter  # noqa: E402
from social_fleet.ros.fleet_file import load_fleet  # noqa: E402

GOLD = "map: /m.yaml\ndefaults: {radius: 0.3}\nrobots:\n  gold: {start: [1, 2]}\n"


def test_the_shipped_fleet() -> None:
    fleet = load_fleet(ROOT / "config" / "fleet.yaml")
    assert Path(fleet.map).resolve() == ROOT / "maps" / "office_floor.yaml"
    assert {name: robot.max_speed for name, robot in fleet.robots.items()} == {"gold": 0.7, "blue": 0.5}
    assert {robot.localization for robot in fleet.robots.values()} == {"amcl"}


def test_defaults_hold_where_a_robot_says_nothing(tmp_path: Path) -> None:
    file = tmp_path / "fleet.yaml"
    file.write_text(GOLD)
    gold = load_fleet(file).robots["gold"]
    assert (gold.start, gold.radius, gold.navigation) == ((1.0, 2.0, 0.0), 0.3, "navigator")


@pytest.mark.parametrize("old, new, field", [
    ("start: [1, 2]", "start: [1]", "robots.gold.start"), ("start: [1, 2]", "radius: 1", "robots.gold.start"),
    ("radius: 0.3", "radius: -1", "robots.gold.radius"), ("radius: 0.3", "size: 1", "robots.gold.size"),
    ("radius: 0.3", "localization: gps", "robots.gold.localization"), ("map: /m.yaml", "other: 1", "map"),
    ("gold: {start: [1, 2]}", "gold: 3", "robots.gold"), ("defaults: {radius: 0.3}", "defaults: 3", "defaults"),
])
def test_what_is_wrong_is_named(tmp_path: Path, old: str, new: str, field: str) -> None:
    file = tmp_path / "fleet.yaml"
    file.write_text(GOLD.replace(old, new))
    with pytest.raises(InvalidParameter) as caught:
        load_fleet(file)
    assert caught.value.field == field and caught.value.source == str(file)
