"""A map is found relative to its file, absolutely, and by package."""

import os
from pathlib import Path

import pytest
from repository import ROOT

from social_fleet.errors import InvalidScenario
from social_fleet.scenario import locations
from social_fleet.scenario.locations import package_folder, refer, resolve


def test_the_package_is_found_in_the_source_space() -> None:
    assert package_folder() == str(ROOT)


def test_the_package_is_found_in_an_install_space(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    module = tmp_path / "lib/python3/dist-packages/social_fleet/scenario/locations.py"
    share = tmp_path / "share/social_fleet"
    for folder in (module.parent, share / "maps", share / "config"):
        folder.mkdir(parents=True)
    monkeypatch.setattr(locations, "__file__", str(module))
    assert package_folder() == str(share)


def test_without_the_package_the_reason_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(locations, "__file__", str(tmp_path / "locations.py"))
    with pytest.raises(InvalidScenario, match="give the map by its absolute path"):
        package_folder()


@pytest.mark.parametrize("name, expected", [
    ("a.yaml", "/data/scenarios/a.yaml"),
    ("../maps/a.yaml", "/data/maps/a.yaml"),
    ("/maps/a.yaml", "/maps/a.yaml"),
    ("package://social_fleet/maps/a.yaml", str(ROOT / "maps" / "a.yaml")),
])
def test_names_are_resolved(name: str, expected: str) -> None:
    assert resolve(name, "/data/scenarios") == expected


def test_another_package_is_refused() -> None:
    with pytest.raises(InvalidScenario, match="only package://social_fleet/… is understood"):
        resolve("package://other/maps/a.yaml", "/")


def test_refer_is_the_inverse_of_resolve(tmp_path: Path) -> None:
    (tmp_path / "scenarios").mkdir()
    for path in (str(tmp_path / "a.yaml"), str(ROOT / "maps" / "crossing.yaml")):
        name = refer(path, str(tmp_path / "scenarios"))
        assert resolve(name, str(tmp_path / "scenarios")) == path
    assert refer(str(ROOT / "maps" / "crossing.yaml"), os.getcwd()) == "package://social_fleet/maps/crossing.yaml"
    assert refer(str(tmp_path / "a.yaml"), str(tmp_path / "scenarios")) == "../a.yaml"
