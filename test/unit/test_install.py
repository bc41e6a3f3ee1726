"""The install space stands by itself: command line, launch files and nodes run from there, away from the sources."""

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import pytest

from repository import ROOT

CMAKE = ROOT / "build" / "cmake"
LIMIT = 300  # [s]

pytestmark = pytest.mark.skipif(not (CMAKE / "CMakeCache.txt").exists(), reason="needs the workspace of tools/setup")


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The install space, as catkin_make install makes it; away from the sources, whose packages roslaunch searches."""
    staged = tmp_path_factory.mktemp("staged")
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    subprocess.run(("cmake", "--build", str(CMAKE), "--target", "install"), check=True, capture_output=True,
                   timeout=LIMIT, env={**environment, "DESTDIR": str(staged)})
    return next(staged.rglob("setup.bash")).parent


def run(command: str, space: Path, folder: Path) -> "subprocess.CompletedProcess[str]":
    """A command in a shell that knows nothing but the install space."""
    environment = {"PATH": "/usr/bin:/bin", "HOME": str(folder), "LANG": "C.UTF-8", "MPLBACKEND": "Agg",
                   "ROS_HOME": str(folder / "ros"), "ROS_HOSTNAME": "localhost"}
    environment.update((name, os.environ[name]) for name in ("ROS_MASTER_URI", "NUMBA_CACHE_DIR") if name in os.environ)
    script = f'source /opt/ros/noetic/setup.bash 2>/dev/null; source "{space}/setup.bash"; {command}'
    return subprocess.run(("bash", "-c", script), cwd=folder, env=environment, capture_output=True, text=True,
                          timeout=LIMIT)


def test_everything_comes_from_the_install_space(installed: Path, tmp_path: Path) -> None:
    result = run("rospack find social_fleet; /usr/bin/python3 -c 'import social_fleet; print(social_fleet.__file__)'",
                 installed, tmp_path)
    places = [Path(line) for line in result.stdout.splitlines()]
    assert len(places) == 2 and all(installed in place.parents for place in places), result.stderr
    share = installed / "share" / "social_fleet"
    for folder in ("config", "launch", "maps"):
        wanted = {path.name for path in (ROOT / folder).iterdir()}
        assert wanted == {path.name for path in (share / folder).iterdir()}
    assert (share / "nav_core_plugins.xml").exists()


def test_the_command_line_plans(installed: Path, tmp_path: Path) -> None:
    result = run('rosrun social_fleet social_fleet plan --map "$(rospack find social_fleet)/maps/crossing.yaml" '
                 "--start 1.5 8 --goal 14.5 8 --out plan.json", installed, tmp_path)
    assert result.returncode == 0, result.stderr
    assert json.loads((tmp_path / "plan.json").read_text())["status"] == "ok"


@pytest.mark.skipif("ROS_MASTER_URI" not in os.environ, reason="needs ROS")
def test_the_demo_drives(installed: Path, tmp_path: Path) -> None:
    port = os.environ["ROS_MASTER_URI"].rsplit(":", 1)[1]
    result = run(f'roslaunch --port {port} --skip-log-check social_fleet demo.launch "out:={tmp_path}" '
                 "scenario:=package://social_fleet/config/scenarios/crossing.yaml", installed, tmp_path)
    report: Any = json.loads((tmp_path / "report.json").read_text())
    assert report["passed"] is True, result.stdout[-2000:]
