"""`import social_fleet` is quick, needs no ROS, and offers what the README shows."""

import os
import subprocess
import sys

import pytest
from repository import ROOT

import social_fleet as sf


def test_every_public_name_is_there() -> None:
    for name in sf.__all__:
        assert getattr(sf, name) is not None
    assert set(sf.__all__) == set(sf._MODULE_OF) and list(sf.__all__) == sorted(sf.__all__)
    assert set(sf.__all__) <= set(dir(sf))


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'plan_it'"):
        sf.plan_it


def test_importing_the_package_imports_nothing_heavy() -> None:
    code = "import sys, social_fleet; print(sorted({'numpy', 'numba', 'yaml', 'rospy'} & set(sys.modules)))"
    environment = dict(os.environ, PYTHONPATH=str(ROOT / "src"))
    shown = subprocess.run([sys.executable, "-c", code], env=environment, stdout=subprocess.PIPE, text=True, check=True)
    assert shown.stdout.strip() == "[]"


def test_from_a_map_to_a_checked_schedule() -> None:
    grid = sf.load_map(str(ROOT / "maps" / "crossing.yaml"))
    planner = sf.SocialPlanner(grid, sf.PlannerConfig(robot_radius=0.25))
    east = planner.plan((1.5, 8.0), (14.5, 8.0))
    north = planner.plan((8.0, 1.5), (8.0, 14.5))
    assert east.points.shape[1] == 2 and east.length >= 13.0 and east.cost >= east.length
    fleet = sf.coordinate([sf.Robot("gold", east, max_speed=0.7), sf.Robot("blue", north)], mode="simultaneous")
    assert sf.verify(fleet).safe
