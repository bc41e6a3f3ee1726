"""Lidar in a world that a reader checks by hand."""

import math

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.geometry import Pose
from social_fleet.simulation.config import LidarConfig
from social_fleet.simulation.lidar import Lidar

ROOM = """
    ######
    #....#
    #....#
    #.#..#
    ######
"""
FOUR = LidarConfig(angle_min=-math.pi / 2, angle_max=math.pi, angle_increment=math.pi / 2, range_max=10.0)
NONE = np.zeros((0, 3))


def test_four_beams_meet_the_walls() -> None:
    ranges = Lidar(FOUR).scan(grid_from_text(ROOM), Pose(1.5, 1.5, 0.0), NONE)
    assert ranges.tolist() == pytest.approx([0.5, 0.5, 2.5, 0.5])  # south, east (the block), north, west


def test_beams_turn_with_the_robot() -> None:
    ranges = Lidar(FOUR).scan(grid_from_text(ROOM), Pose(1.5, 2.5, math.pi / 2), NONE)
    assert ranges.tolist() == pytest.approx([3.5, 1.5, 0.5, 1.5])  # east, north, west, south


def test_a_slanted_beam() -> None:
    config = LidarConfig(angle_min=math.pi / 4, angle_max=math.pi / 4 + 0.01, angle_increment=1.0)
    ranges = Lidar(config).scan(grid_from_text(ROOM), Pose(1.25, 1.5, 0.0), NONE)
    assert ranges.tolist() == pytest.approx([2.5 * math.sqrt(2.0)], rel=1e-6)


def test_resolution_and_a_turned_origin() -> None:
    grid = grid_from_text(ROOM, resolution=0.5, origin=(10.0, 20.0, math.pi / 2))
    ranges = Lidar(FOUR).scan(grid, Pose(10.0 - 0.75, 20.0 + 0.75, math.pi / 2), NONE)
    assert ranges.tolist() == pytest.approx([0.25, 0.25, 1.25, 0.25])


def test_discs_are_seen_and_hide_what_is_behind() -> None:
    discs = np.array([(4.0, 2.5, 0.25), (4.5, 2.5, 0.25)])
    ranges = Lidar(FOUR).scan(grid_from_text(ROOM), Pose(1.5, 2.5, 0.0), discs)
    assert ranges.tolist() == pytest.approx([1.5, 2.25, 1.5, 0.5])


def test_out_of_range_is_infinite_and_too_near_is_the_least() -> None:
    config = LidarConfig(angle_min=-math.pi / 2, angle_max=math.pi, angle_increment=math.pi / 2, range_min=0.6,
                         range_max=2.0)
    ranges = Lidar(config).scan(grid_from_text(ROOM), Pose(1.5, 1.5, 0.0), NONE)
    assert ranges.tolist() == pytest.approx([0.6, 0.6, np.inf, 0.6])


def test_noise_comes_from_the_seed() -> None:
    config, grid = LidarConfig(noise=0.02), grid_from_text(ROOM)
    scans = [Lidar(config, seed=seed).scan(grid, Pose(3.5, 2.5, 0.0), NONE) for seed in (1, 1, 2)]
    assert (scans[0] == scans[1]).all() and (scans[0] != scans[2]).any()
    assert len(scans[0]) == 361
