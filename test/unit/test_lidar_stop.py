"""The lidar's stop: nothing in the braking path, and a way out for who came too near."""

import math

import numpy as np
import pytest

from social_fleet.errors import InvalidParameter
from social_fleet.execution.lidar_stop import LidarStop, points_of_scan
from social_fleet.geometry import Polyline, Pose

PATH = Polyline([(0.0, 0.0), (5.0, 0.0), (5.0, 5.0)])


def eyes() -> LidarStop:
    stop = LidarStop(0.25, margin=0.03, standoff=0.12, reach=3.0)
    stop.follow(PATH)
    return stop


def test_a_thing_on_the_path_is_stopped_for_with_room_to_turn_away() -> None:
    horizon = eyes().horizon(np.array([[2.0, 0.0]]), 0.5, Pose(0.5, 0.0))
    assert 2.0 - 0.28 - 0.12 - 0.06 <= horizon <= 2.0 - 0.28 - 0.12 + 0.05


@pytest.mark.parametrize("point", [(2.0, 0.29), (-0.3, 0.0), (4.5, 0.0)])
def test_what_is_aside_behind_or_far_ahead_is_not(point: tuple) -> None:
    assert eyes().horizon(np.array([point]), 0.5, Pose(0.5, 0.0)) == math.inf


def test_the_path_is_looked_along_round_corners() -> None:
    horizon = eyes().horizon(np.array([[5.0, 1.0]]), 4.5, Pose(4.5, 0.0))
    assert horizon == pytest.approx(6.0 - 0.28 - 0.12, abs=0.06)
    assert eyes().horizon(np.array([[5.6, 0.0]]), 4.5, Pose(4.5, 0.0)) == math.inf


def test_in_contact_ahead_it_must_not_move_at_all() -> None:
    assert eyes().horizon(np.array([[0.76, 0.0]]), 0.5, Pose(0.5, 0.0)) < 0.5


def test_what_is_too_near_beside_it_may_be_left_behind_but_not_come_nearer() -> None:
    beside = np.array([[0.5, 0.265]])
    assert eyes().horizon(beside, 0.5, Pose(0.5, 0.0)) == math.inf
    assert eyes().horizon(np.array([[0.8, 0.252]]), 0.5, Pose(0.5, 0.0)) < 0.8


def test_straight_ahead_the_disc_decides() -> None:
    assert eyes().ahead(np.array([[1.0, 0.0]]), Pose(0.0, 0.0, 0.0)) == pytest.approx(1.0 - 0.27)
    assert eyes().ahead(np.array([[1.0, 0.3], [-1.0, 0.0]]), Pose(0.0, 0.0, 0.0)) == math.inf
    assert eyes().ahead(np.array([[0.0, 1.0]]), Pose(0.0, 0.0, math.pi / 2)) == pytest.approx(0.73)


def test_without_hits_or_path_all_is_free() -> None:
    assert eyes().horizon(np.zeros((0, 2)), 0.0, Pose(0.0, 0.0)) == math.inf
    assert LidarStop(0.25).horizon(np.array([[0.1, 0.0]]), 0.0, Pose(0.0, 0.0)) == math.inf


def test_a_scan_becomes_points() -> None:
    points = points_of_scan([1.0, math.inf, 9.0, 0.0, 2.0], [0.0, 0.5, 1.0, 1.5, math.pi / 2], Pose(1.0, 1.0, math.pi),
                            range_max=5.0)
    assert points == pytest.approx(np.array([[0.0, 1.0], [1.0, -1.0]]))


@pytest.mark.parametrize("values", [{"radius": 0.0}, {"radius": 0.2, "margin": -1.0}, {"radius": 0.2, "reach": 0.0}])
def test_lengths_must_be_positive(values: dict) -> None:
    with pytest.raises(InvalidParameter):
        LidarStop(**values)
