"""String pulling: which points of a path may end a chord, and which chords are chosen."""

import numpy as np
import pytest
from test_chords import ground_of, prices_of
from worlds import grid_from_text

from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.driven_path.chords import is_free
from social_fleet.planning.driven_path.pulling import candidates_of, drop_needless, pull
from social_fleet.planning.lattice import Lattice


def candidates(points, spacing, tolerance=0.75):
    """Where chords may end on a path through a free world."""
    space = ConfigurationSpace(grid_from_text("\n".join(["." * 70] * 12), 0.1), 0.1)
    lattice = Lattice(space)
    nodes = lattice.node[points[:, 1], points[:, 0]]
    paid = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))]) * 0.1
    return candidates_of(ground_of(space), prices_of(lattice), points + 0.5, nodes, paid, tolerance, spacing, -1.0)


def test_candidates_are_the_turns():
    points = np.array([(c, 2) for c in range(2, 12)] + [(11, r) for r in range(3, 10)])
    assert candidates(points, 100.0).tolist() == [0, 9, 16]


def test_candidates_are_dense_near_the_ends_of_a_straight_piece():
    points = np.array([(c, 2) for c in range(2, 67)])
    assert candidates(points, 4.0).tolist() == [0, 4, 8, 16, 32, 48, 56, 60, 64]


def test_candidates_are_where_a_chord_would_not_fit():
    text = "\n".join(["." * 10] * 4 + ["...####..."] * 2)
    space = ConfigurationSpace(grid_from_text(text, 0.1), 0.05)
    lattice = Lattice(space)
    cells = [(1, 1), (1, 2), (2, 2), (2, 3), (2, 4), (2, 5), (2, 6), (2, 7), (1, 7), (1, 8)]
    nodes = lattice.node[tuple(np.array(cells).T)]
    points, paid = lattice.centres(nodes), np.arange(len(cells)) * 0.1
    arguments = ground_of(space), prices_of(lattice), points, nodes, paid
    loose = candidates_of(*arguments, 9.0, 100.0, -1.0)
    assert 2 < len(loose) < len(cells)
    assert all(is_free(arguments[0], *points[i], *points[j]) for i, j in zip(loose, loose[1:]))


class Staircase:
    """A path of free cells with steps where a straight line would do."""

    def __init__(self, rate):
        self.space = ConfigurationSpace(grid_from_text("\n".join(["." * 30] * 12), 0.1), 0.1)
        lattice = Lattice(self.space)
        cells = [(2, c) for c in range(2, 12)] + [(3, c) for c in range(12, 22)] + [(4, c) for c in range(22, 28)]
        self.nodes = lattice.node[tuple(np.array(cells).T)]
        self.points = lattice.centres(self.nodes)
        self.prices = prices_of(lattice, rate)
        steps = np.hypot(*np.diff(self.points, axis=0).T) * 0.1
        self.paid = np.concatenate([[0.0], np.cumsum(steps + rate)])

    def pulled(self, bound):
        arguments = ground_of(self.space), self.prices, self.points, self.nodes, self.paid
        chosen = pull(*arguments, np.arange(len(self.points)), bound, 0.1, 1.0, 10.0, 10, arguments[0].radius, 0.0)
        return drop_needless(*arguments, chosen, bound, 0.1, 1.0)


@pytest.mark.parametrize("rate, bound", [(0.0, -1.0), (0.0, 0.1), (0.3, 0.1)])
def test_a_staircase_becomes_one_chord(rate, bound):
    world = Staircase(rate)
    assert world.pulled(bound).tolist() == [0, len(world.points) - 1]


def test_a_chord_that_is_too_dear_does_not_replace_a_detour():
    world = Staircase(0.0)
    row, column = world.prices.links.row, world.prices.links.col
    dear = (row == 3) & (column < 11) | (row == 2) & (column > 13) | (row == 4) & (column < 21)
    world.prices.social[dear & (row > 2)] += 5.0
    chosen = world.pulled(0.1)
    assert len(chosen) > 2
    np.testing.assert_array_less(world.points[chosen][:, 1], 4.6)
