"""Chords: where a robot fits along a line, and what the line costs."""

import math

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.driven_path.chords import (
    Ground, Prices, candidates_of, chain_cost, drop_needless, is_free, pull)
from social_fleet.planning.lattice import Lattice, fitting_radius

NO_DISCS = np.zeros((0, 3))


def ground_of(space, discs=NO_DISCS):
    return Ground(space.grid.blocked, space.clearance, space.grid.resolution, fitting_radius(space), np.array(discs))


def prices_of(lattice, rate=0.0):
    """The same social cost per step wherever there is an edge."""
    social = np.where(lattice.edges[:, None] >> np.arange(8) & 1, rate, np.inf).astype(np.float32)
    return Prices(lattice.links, social, np.zeros(len(lattice), dtype=np.uint8))


def test_it_agrees_with_the_exact_clearance_of_the_path():
    random = np.random.RandomState(3)
    text = "\n".join("".join("#" if value else "." for value in row) for row in random.rand(40, 40) < 0.04)
    space = ConfigurationSpace(grid_from_text(text, 0.1), 0.21)
    ground = ground_of(space)
    free = 0
    starts = random.rand(500, 2) * 40.0
    ends = np.clip(starts + random.uniform(-8.0, 8.0, (500, 2)), 0.0, 40.0)
    for (x0, y0), (x1, y1) in zip(starts, ends):
        fits = is_free(ground, x0, y0, x1, y1)
        assert fits == space.is_free_path(np.array([[x0, y0], [x1, y1]]) * 0.1)
        free += fits
    assert 50 < free < 450


def test_the_robot_may_touch_but_not_more():
    space = ConfigurationSpace(grid_from_text("""
        ######
        ......
        ......
        ######
    """, 0.2), 0.2)
    assert is_free(ground_of(space), 1.0, 2.0, 5.0, 2.0)
    assert not is_free(ground_of(space), 1.0, 2.0, 5.0, 2.02)


def test_discs_block_a_chord():
    space = ConfigurationSpace(grid_from_text("\n".join(["." * 20] * 20), 0.1), 0.1)
    ground = ground_of(space, [[10.0, 10.0, 3.0]])
    assert not is_free(ground, 5.0, 12.9, 15.0, 12.9)
    assert is_free(ground, 5.0, 13.1, 15.0, 13.1)
    assert not is_free(ground, 10.0, 10.0, 10.0, 10.0)


@pytest.mark.parametrize("goal", [(0, 0), (0, 7), (7, 0), (7, 7), (3, 7), (7, 2)])
def test_a_chain_has_the_length_of_the_shortest_path(goal):
    lattice = Lattice(ConfigurationSpace(grid_from_text("\n".join(["." * 8] * 8), 0.5), 0.2))
    steps, short = max(goal), min(goal)
    length, social = chain_cost(prices_of(lattice, 0.1), lattice.node[0, 0], lattice.node[goal], np.inf)
    assert length == pytest.approx(0.5 * (steps - short + math.sqrt(2.0) * short))
    assert social == pytest.approx(0.1 * steps)
    back = chain_cost(prices_of(lattice, 0.1), lattice.node[goal], lattice.node[0, 0], np.inf)
    assert back == pytest.approx((length, social))


def test_a_chain_ends_at_a_wall_and_at_its_budget():
    lattice = Lattice(ConfigurationSpace(grid_from_text("....#..."), 0.3))
    prices = prices_of(lattice, 1.0)
    assert chain_cost(prices, lattice.node[0, 0], lattice.node[0, 3], np.inf) == (3.0, 3.0)
    assert chain_cost(prices, lattice.node[0, 0], lattice.node[0, 3], 5.0) == (np.inf, np.inf)
    assert chain_cost(prices, lattice.node[0, 0], lattice.node[0, 5], np.inf) == (np.inf, np.inf)


def test_the_exempt_pay_nothing():
    lattice = Lattice(ConfigurationSpace(grid_from_text("........"), 0.3))
    prices = prices_of(lattice, 1.0)._replace(exempt=np.array([1, 1, 1, 0, 0, 0, 0, 0], dtype=np.uint8))
    assert chain_cost(prices, lattice.node[0, 0], lattice.node[0, 7], np.inf) == (7.0, 4.0)


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
