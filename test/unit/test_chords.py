"""Chords: where a robot fits along a line, and what the line costs."""

import math

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.driven_path.chords import Ground, Prices, chain_cost, is_free
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
