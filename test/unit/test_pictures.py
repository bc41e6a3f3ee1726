"""Every picture is written whole, with what it needs to show, for fleets of one to many."""

from pathlib import Path
from typing import Tuple

import numpy as np
import pytest
from PIL import Image
from worlds import grid_from_text

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.errors import InvalidInput
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.plan import Plan
from social_fleet.scenario.pictures.animation import MOST_FRAMES, animate, sample
from social_fleet.scenario.pictures.colours import rgb, robot_colours
from social_fleet.scenario.pictures.map_picture import map_picture
from social_fleet.scenario.pictures.plan_picture import plan_picture
from social_fleet.scenario.pictures.schedule_picture import schedule_picture
from social_fleet.scenario.pictures.space_time import space_time_picture
from social_fleet.simulation.faults import CircleObstacle


def world(robots: int) -> Tuple[OccupancyGrid, FleetSchedule]:
    """A square of 12 m, with robots going east, all crossed by the last, which goes north."""
    grid = grid_from_text("\n".join(["#" * 14, *["#" + "." * 12 + "#"] * 12, "#" * 14]))
    fleet = [Robot(f"robot_{index}", np.array([[1.5, 2.0 + index], [12.5, 2.0 + index]]))
             for index in range(robots - 1)]
    return grid, coordinate(fleet + [Robot("last", np.array([[7.0, 1.5], [7.0, 12.5]]), max_speed=0.4)])


@pytest.mark.parametrize("robots", [1, 2, 9])
def test_pictures_of_a_fleet(tmp_path: Path, robots: int) -> None:
    grid, fleet = world(robots)
    recording = sample(fleet)
    map_picture(grid, fleet, tmp_path / "map.png", recording=recording)
    space_time_picture(fleet, tmp_path / "time.png", recording=recording)
    schedule_picture(grid, fleet, tmp_path / "schedule.png", title="test")
    for name in ("map.png", "time.png", "schedule.png"):
        image = Image.open(tmp_path / name)
        assert min(image.size) > 400 and image.format == "PNG"
    colours = set(map(tuple, np.asarray(Image.open(tmp_path / "map.png").convert("RGB")).reshape(-1, 3)))
    assert {rgb(colour) for colour in robot_colours([s.name for s in fleet.schedules]).values()} <= colours


def test_a_long_map_stands_above_its_diagram(tmp_path: Path) -> None:
    grid = grid_from_text("\n".join(["#" * 40, *["#" + "." * 38 + "#"] * 3, "#" * 40]))
    fleet = coordinate([Robot("a", np.array([[1.5, 2.0], [38.0, 2.0]]))])
    schedule_picture(grid, fleet, tmp_path / "schedule.png")
    width, height = Image.open(tmp_path / "schedule.png").size
    assert height > 0.6 * width


def test_an_animation_runs_from_start_to_goal(tmp_path: Path) -> None:
    grid, fleet = world(3)
    animate(grid, fleet, tmp_path / "fleet.gif", title="test", obstacles=[CircleObstacle(3.0, 10.0, 0.5)])
    image = Image.open(tmp_path / "fleet.gif")
    assert image.format == "GIF" and 10 < image.n_frames <= MOST_FRAMES
    first = np.asarray(image.convert("RGB"), dtype=int)
    image.seek(image.n_frames - 1)
    last = np.asarray(image.convert("RGB"), dtype=int)
    assert first.shape == last.shape and np.abs(first - last).max() > 100


def test_the_scheduled_motion_is_sampled() -> None:
    _, fleet = world(2)
    recording = sample(fleet)
    assert recording.poses.shape == (len(recording.times), 2, 3)
    assert np.allclose(recording.poses[0, :, :2], [[1.5, 2.0], [7.0, 1.5]])
    assert np.allclose(recording.poses[-1, :, :2], [[12.5, 2.0], [7.0, 12.5]])


@pytest.mark.parametrize("count", [1, 3, 30])
def test_pictures_of_plans(tmp_path: Path, count: int) -> None:
    grid, _ = world(1)
    plan = Plan(np.array([[2.0, 2.0], [9.0, 2.0]]), 7.0, 0.0, 7.0, 1, 0.0, "rrt_star", 0.25)
    tasks = [((2.0, 2.0), (9.0, 2.0, 0.0), plan)] * count + [((1.5, 1.5, 0.0), (12.0, 12.0), None)]
    plan_picture(grid, tasks, tmp_path / "plan.png", robot_radius=0.25)
    plan_picture(grid, tasks[-1:], tmp_path / "none.png", robot_radius=0.25)
    assert min(Image.open(tmp_path / "plan.png").size) > 400


def test_an_impossible_place_is_refused(tmp_path: Path) -> None:
    grid, fleet = world(1)
    with pytest.raises(InvalidInput, match="does not exist"):
        map_picture(grid, fleet, tmp_path / "none" / "map.png")
