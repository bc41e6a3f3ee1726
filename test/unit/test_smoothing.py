"""From searched cells to the driven path."""

import math

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.geometry import Polyline
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.driven_path.chords import Ground, Prices
from social_fleet.planning.driven_path.smoothing import jogs, rounded, smooth, turns
from social_fleet.planning.lattice import Lattice, fitting_radius
from social_fleet.planning.search import Search

WORLD = "\n".join(["." * 60] * 18 + ["." * 25 + "#" * 8 + "." * 27] * 24 + ["." * 60] * 18)


class Room:
    """A room of 6 x 6 m with a pillar, and a social cost that makes some rows a lane."""

    def __init__(self, text=WORLD, lane=None):
        self.space = ConfigurationSpace(grid_from_text(text, 0.1), 0.25)
        self.lattice = Lattice(self.space)
        self.ground = Ground(self.space.grid.blocked, self.space.clearance, 0.1, fitting_radius(self.space),
                             np.zeros((0, 3)))
        rate = np.zeros(len(self.lattice)) if lane is None else np.abs(self.lattice.row - lane) * 0.1
        social = np.where(self.lattice.edges[:, None] >> np.arange(8) & 1, rate[:, None] * 0.1, np.inf)
        self.social = social.astype(np.float32)
        self.search = Search(self.lattice, self.social)

    def smoothed(self, start, goal, *, bound, corner_radius=0.8):
        result = self.search.cheapest(self.lattice.node[start], self.lattice.node[goal], self.search.metric())
        points = self.lattice.centres(result.nodes)
        paid = np.concatenate([[0.0], np.cumsum(self.search.evaluate(result).sum(axis=0))])
        prices = Prices(self.lattice.links, self.social, np.zeros(len(self.lattice), dtype=np.uint8))
        return smooth(points, result.nodes, paid, self.ground, prices, bound=bound, corner_radius=corner_radius,
                      least=self.ground.radius)


def signed_turns(points):
    return np.angle(np.exp(1j * np.diff(Polyline(points).segment_headings)))


def test_an_open_room_is_crossed_in_a_line():
    path = Room("\n".join(["." * 60] * 60)).smoothed((5, 5), (30, 54), bound=-1.0)
    np.testing.assert_allclose(path, [[5.5, 5.5], [54.5, 30.5]])


@pytest.mark.parametrize("bound", [-1.0, 0.5])
def test_round_a_pillar(bound):
    room = Room()
    path = room.smoothed((30, 5), (30, 54), bound=bound)
    assert room.space.is_free_path(path * 0.1)
    shortest = 2.0 * math.hypot(19.5 - 1.8, 11.5 + 1.8) + 11.6  # over the pillar's corners at the robot's radius
    assert Polyline(path).length < 1.1 * shortest
    assert np.abs(signed_turns(path)).max() < math.radians(8.0)
    assert np.abs(signed_turns(path)).sum() < math.radians(110.0)


def test_a_lane_stays_a_lane():
    path = Room("\n".join(["." * 60] * 60), lane=10).smoothed((10, 5), (10, 54), bound=0.5)
    np.testing.assert_allclose(path[:, 1], 10.5)


def test_the_way_to_a_lane_is_not_cut_beyond_the_bound():
    room = Room("\n".join(["." * 60] * 60), lane=5)
    tight, loose = (room.smoothed((30, 5), (30, 54), bound=bound) for bound in (0.02, 3.0))
    assert tight[:, 1].min() <= loose[:, 1].min()
    assert Polyline(loose).length <= Polyline(tight).length


def test_corners_stay_sharp_without_a_radius():
    path = np.array([[10.0, 10.0], [40.0, 10.0], [40.0, 10.0], [40.0, 40.0]])
    np.testing.assert_array_equal(rounded(Room().ground, path, 0.0, 2.5), path[[0, 1, 3]])


def test_a_path_of_one_place():
    here = np.array([[5.5, 5.5], [5.5, 5.5]])
    np.testing.assert_array_equal(rounded(Room().ground, here, 0.8, 2.5), here)


def test_turns_have_no_sign_and_no_seam():
    path = np.array([[0.0, 0.0], [-1.0, -0.1], [-2.0, 0.1], [-2.0, 1.0], [-1.0, 1.0]])
    np.testing.assert_allclose(turns(path), np.abs(signed_turns(path)))


def test_jogs_are_turns_in_place_beside_a_short_side():
    path = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 1.0], [20.0, 1.0], [30.0, 11.0], [30.0, 31.0], [30.5, 31.0]])
    assert jogs(path, 4.0).tolist() == [[0, 3], [4, 6]]
    assert not len(jogs(path, 0.1))


def test_a_jog_may_use_up_the_margin():
    # A gap 0.6 m wide whose walls are a cell apart: with a margin the lattice's path makes two turns in it.
    lower, upper = ["." * 12 + "#" * 6 + "." * 12], ["." * 18 + "#" * 6 + "." * 6]
    text = "\n".join(["." * 30] * 10 + upper * 8 + ["." * 30] * 6 + lower * 8 + ["." * 30] * 10)
    room = Room(text)
    wide = room.ground._replace(radius=room.ground.radius + 0.4)
    result = room.search.shortest(room.lattice.node[20, 3], room.lattice.node[20, 26])
    points = room.lattice.centres(result.nodes)
    paid = np.arange(len(points)) * 0.1
    prices = Prices(room.lattice.links, room.social, np.zeros(len(room.lattice), dtype=np.uint8))
    path = smooth(points, result.nodes, paid, wide, prices, bound=-1.0, corner_radius=0.8, least=room.ground.radius)
    assert room.space.is_free_path(path * 0.1)
    assert turns(path).max(initial=0.0) < math.radians(20.0)
