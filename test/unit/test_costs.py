"""Edge costs as line integrals."""

import math

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.errors import InvalidParameter
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.mapping.walls import wall_distances
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.lattice import Lattice
from social_fleet.planning.social_cost.costs import edge_costs, walls_beside
from social_fleet.planning.social_cost.norms import HeadingCost, Norm, norm_of

EAST, NORTH, WEST, SOUTH = 0, 2, 4, 6

CORRIDOR = """
    ####################
    ....................
    ....................
    ....................
    ....................
    ....................
    ....................
    ....................
    ####################
"""


class Uniform(Norm):
    """The same rate everywhere but per heading, and the row as what must not change."""

    reach = 5.0

    def __init__(self, rates):
        self.rates = rates

    def heading_cost(self, walls, heading):
        same = np.ones_like(walls[heading])
        return HeadingCost(self.rates[heading] * same, walls[SOUTH], 2.0 * same)


def costs_of(text, norm, resolution=0.2, radius=0.1, stretch=0.0):
    grid = grid_from_text(text, resolution)
    lattice = Lattice(ConfigurationSpace(grid, radius))
    return lattice, edge_costs(lattice, grid.blocked, norm, stretch=stretch)


def test_an_edge_costs_its_length_times_the_rate_and_its_drift():
    lattice, social = costs_of(CORRIDOR, Uniform([1.0] * 8))
    node = lattice.node[4, 10]
    assert social[node, EAST] == pytest.approx(0.2)
    assert social[node, NORTH] == pytest.approx(0.2 + 2.0 * 0.2)
    assert social[node, 1] == pytest.approx(0.2 * math.sqrt(2.0) + 2.0 * 0.2)


def test_there_is_no_edge_into_a_wall():
    lattice, social = costs_of(CORRIDOR, Uniform([1.0] * 8))
    assert social[lattice.node[1, 10], SOUTH] == math.inf


def test_an_opening_is_no_drift():
    lattice, social = costs_of("""
        ..........
        ..........
        ..........
        ####..####
        ####..####
        ####..####
    """, Uniform([0.0] * 8))
    assert social[lattice.node[4, 3], EAST] == 0.0  # the wall to the south jumps away by three cells
    assert social[lattice.node[3, 4], NORTH] == pytest.approx(2.0 * 0.2)


def test_a_weight_means_the_same_at_every_resolution():
    norm = norm_of(PlannerConfig(robot_radius=0.1, standoff=0.2))
    fine = "\n".join("".join(c * 4 for c in line.strip()) for line in CORRIDOR.strip().splitlines() for _ in range(4))
    totals = []
    for text, resolution in ((CORRIDOR, 0.4), (fine, 0.1)):
        lattice, social = costs_of(text, norm, resolution)
        row = int(1.4 / resolution)  # 1 m from the wall, up to a cell
        cells = range(int(2.0 / resolution), int(6.0 / resolution))
        totals.append(sum(social[lattice.node[row, column], EAST] for column in cells))
    assert totals[0] == pytest.approx(totals[1], rel=0.2)


def test_tacking_never_pays():
    # Driving north is dear, north-east and west are free: 1.41 m of the one and 1 m of the other make 1 m north.
    rates = [9.0] * 8
    rates[1] = rates[WEST] = 0.0
    lattice, social = costs_of(CORRIDOR, Uniform(rates))
    node = lattice.node[4, 10]
    north = 0.2 + social[node, NORTH] - 2.0 * 0.2  # without the drift
    assert 0.9 * 0.2 * (math.sqrt(2.0) * math.sqrt(2.0) + 1.0) > north > 0.2
    assert social[node, WEST] == 0.0


def test_a_norm_must_not_pay_for_travel():
    for bad in (-1.0, math.nan, 1e37):
        with pytest.raises(InvalidParameter):
            costs_of(CORRIDOR, Uniform([bad] * 8))


def test_walls_beside_close_doors_but_not_walls():
    grid = grid_from_text("""
        ..........
        ..........
        ###..#####
        ..........
    """, 0.2)
    rays = wall_distances(grid.blocked, 0.2, limit=5.0)
    beside = walls_beside(grid.blocked, 0.2, limit=5.0, stretch=0.4)
    assert rays[SOUTH, 2, 3] == pytest.approx(0.5)  # through the door
    assert beside[SOUTH, 2, 3] == beside[SOUTH, 2, 4] == pytest.approx(0.1)
    assert beside[SOUTH, 2, 8] == rays[SOUTH, 2, 8] == pytest.approx(0.1)
    np.testing.assert_array_equal(walls_beside(grid.blocked, 0.2, limit=5.0, stretch=0.0), rays)


def test_walls_beside_do_not_look_through_walls():
    grid = grid_from_text("""
        ....#.#
        ....#..
        ....#.#
    """, 1.0)
    beside = walls_beside(grid.blocked, 1.0, limit=9.0, stretch=6.0)
    assert beside[SOUTH, 2, 3] == pytest.approx(2.5)
