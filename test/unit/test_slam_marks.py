"""A scanned map has thin walls, and as many marks as asked for, the same ones for the same seed."""

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.errors import InvalidParameter
from social_fleet.mapping.drawing import draw
from social_fleet.mapping.slam_marks import bent, leave_marks

CLEAN = {"bend": 0.0, "thickening": 0.0, "gaps": 0.0, "fringe": 0.0}
ROOM = {"size": [8, 8], "resolution": 0.05, "shapes": [
    {"fill": "wall", "x": [0, 8], "y": [0, 8]}, {"fill": "free", "x": [2, 6], "y": [2, 6]}]}


def room(**marks):
    return draw({**ROOM, "slam": {**CLEAN, **marks}}).values


def test_a_lidar_sees_surfaces_only():
    solid = grid_from_text("""
        #######
        #######
        ##...##
        ##...##
        #######
        #######
    """)
    seen = grid_from_text("""
        ???????
        ?#####?
        ?#...#?
        ?#...#?
        ?#####?
        ???????
    """)
    np.testing.assert_array_equal(leave_marks(solid.values, 0.05, CLEAN), seen.values)


def test_walls_grow_outwards_only():
    clean, thick = room(), room(thickening=1.0)
    np.testing.assert_array_equal(clean == 0, thick == 0)
    assert (thick == 100).sum() > 1.5 * (clean == 100).sum()


def test_missed_walls_stay_blocked():
    gaps = room(gaps=0.3)
    assert 0.2 < 1.0 - (gaps == 100).sum() / (room() == 100).sum() < 0.4
    np.testing.assert_array_equal(gaps == 0, room() == 0)


@pytest.mark.parametrize("marks, low, high", [({"speckle": 20}, 18, 20), ({"fringe": 0.5}, 120, 200)])
def test_wrongly_occupied_cells(marks, low, high):
    assert low <= (room(**marks) == 100).sum() - (room() == 100).sum() <= high


def test_patches_hide_what_is_at_walls():
    patched = room(patches=10, patch_radius=0.3)
    assert ((patched == -1) & (room() == 0)).sum() > 20
    assert (patched[60:100, 60:100] == 0).all()


def test_rays_leave_into_the_unknown():
    rays = room(windows=2, ray_length=1.0)
    outside = (rays == 0) & (room() != 0)
    assert outside.sum() > 40
    assert np.argwhere(outside).min() >= 40 - 21, "no ray is longer than it may be"


def test_the_seed_decides_everything():
    marks = {"bend": 0.2, "gaps": 0.1, "speckle": 5, "patches": 3, "windows": 1}
    np.testing.assert_array_equal(room(seed=4, **marks), room(seed=4, **marks))
    assert (room(seed=4, **marks) != room(seed=5, **marks)).any()


def test_bending_displaces_by_at_most_what_it_says():
    places = np.indices((50, 50))[::-1] * 0.5
    shift = bent(places, {"bend": 0.2, "bend_wavelength": 10.0}) - places
    assert 0.1 < np.abs(shift).max() <= 0.2


def test_unknown_settings_are_refused():
    with pytest.raises(InvalidParameter, match="slam.speck"):
        room(speck=3)
