"""Rounded corners and merged bends."""

import math

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.driven_path.chords import Ground
from social_fleet.planning.driven_path.corners import merge_bends, round_corners
from social_fleet.planning.lattice import fitting_radius


def ground_of(text, resolution=0.1, radius=0.25):
    space = ConfigurationSpace(grid_from_text(text, resolution), radius)
    return space, Ground(space.grid.blocked, space.clearance, resolution, fitting_radius(space), np.zeros((0, 3)))


_, OPEN = ground_of("\n".join(["." * 60] * 60))
RIGHT_ANGLE = np.array([[10.0, 10.0], [40.0, 10.0], [40.0, 40.0]])


def turns(points):
    headings = np.arctan2(*np.diff(points, axis=0).T[::-1])
    return np.angle(np.exp(1j * np.diff(headings)))


def test_a_corner_becomes_an_arc():
    rounded = round_corners(OPEN, OPEN.radius, RIGHT_ANGLE, 8.0, 1.0, 1.5)
    arc = rounded[1:-1]
    np.testing.assert_allclose(np.hypot(*(arc - [32.0, 18.0]).T), 8.0, atol=1e-9)
    np.testing.assert_allclose(arc[[0, -1]], [[32.0, 10.0], [40.0, 18.0]], atol=1e-9)
    np.testing.assert_array_equal(rounded[[0, -1]], RIGHT_ANGLE[[0, -1]])
    assert np.abs(turns(rounded)).max() < math.radians(8.0)
    assert turns(rounded).sum() == pytest.approx(math.pi / 2)
    assert np.hypot(*np.diff(arc, axis=0).T).max() <= 1.5


def test_right_turns_mirror_left_turns():
    flip = np.array([1.0, -1.0])
    left = round_corners(OPEN, OPEN.radius, RIGHT_ANGLE, 8.0, 1.0, 1.5)
    right = round_corners(OPEN, OPEN.radius, RIGHT_ANGLE * flip + [0.0, 50.0], 8.0, 1.0, 1.5)
    np.testing.assert_allclose(right, left * flip + [0.0, 50.0], atol=1e-9)


def test_short_sides_share_what_there_is():
    zigzag = np.array([[10.0, 10.0], [20.0, 10.0], [20.0, 14.0], [30.0, 14.0]])
    rounded = round_corners(OPEN, OPEN.radius, zigzag, 8.0, 1.0, 1.5)
    assert np.abs(turns(rounded)).max() < math.radians(8.0)
    assert np.hypot(*np.diff(rounded, axis=0).T).min() > 0.0


def test_an_arc_is_as_large_as_the_room_and_a_corner_without_room_stays_sharp():
    text = "\n".join(["." * 30] * 10 + ["#" * 12 + "." * 18] * 20)
    space, ground = ground_of(text)
    # Round the block's corner (12, 20), coming from the west above it and going south.
    for gap, sharp in ((2.5 / math.sqrt(2.0) + 0.02, True), (4.0, False)):
        corner = np.array([12.0 + gap, 20.0 + gap])
        path = np.array([corner - [10.0, 0.0], corner, corner - [0.0, 15.0]])
        path[0, 1] = path[1, 1] = max(corner[1], 22.52)
        path[1, 0] = path[2, 0] = max(corner[0], 14.52)
        if sharp:
            path[1] = [14.52, 22.52]
        rounded = round_corners(ground, ground.radius, path, 8.0, 1.0 if not sharp else 4.0, 1.5)
        assert space.is_free_path(rounded * 0.1)
        assert (len(rounded) == 3) == sharp


def test_a_bend_in_two_becomes_one():
    path = np.array([[10.0, 10.0], [30.0, 10.0], [33.0, 13.0], [33.0, 40.0]])
    np.testing.assert_allclose(merge_bends(OPEN, path, 8.0), [[10.0, 10.0], [33.0, 10.0], [33.0, 40.0]])
    assert len(merge_bends(OPEN, path, 2.0)) == 4


def test_an_s_bend_stays():
    path = np.array([[10.0, 10.0], [30.0, 10.0], [33.0, 13.0], [50.0, 13.0]])
    assert len(merge_bends(OPEN, path, 8.0)) == 4
