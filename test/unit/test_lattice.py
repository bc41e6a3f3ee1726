"""The graph that is searched, checked by hand and against exact clearances."""

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.lattice import DCOL, DROW, Lattice, neighbour

WORLD = """
    .....
    ..#..
    .....
    ####.
    .....
"""


@pytest.fixture(name="lattice")
def make_lattice():
    return Lattice(ConfigurationSpace(grid_from_text(WORLD, 1.0), 0.3))


def test_nodes_are_numbered_row_by_row(lattice):
    assert lattice.node[0].tolist() == [0, 1, 2, 3, 4]
    assert lattice.node[1].tolist() == [-1, -1, -1, -1, 5]
    assert lattice.cells(np.array([0, 5])).tolist() == [[0, 0], [1, 4]]
    assert lattice.centres(np.array([5])).tolist() == [[4.5, 1.5]]


def test_neighbours_lie_in_the_direction_of_the_heading(lattice):
    for node in range(len(lattice)):
        for heading in range(8):
            if lattice.edges[node] >> heading & 1:
                other = neighbour(lattice.links, node, heading)
                assert lattice.row[other] - lattice.row[node] == DROW[heading]
                assert lattice.col[other] - lattice.col[node] == DCOL[heading]
                assert lattice.edges[other] >> (heading + 4) % 8 & 1


def test_a_diagonal_needs_both_orthogonal_neighbours(lattice):
    corner = lattice.node[0, 3]
    assert not lattice.edges[corner] >> 1 & 1  # north-east past the end of the wall
    assert lattice.edges[lattice.node[2, 0]] >> 1 & 1  # north-east in the open
    assert not lattice.edges[lattice.node[2, 1]] >> 1 & 1  # into the pillar
    assert lattice.edges[lattice.node[2, 1]] >> 2 & 1


def test_every_edge_keeps_the_robot_off_the_walls():
    text = "\n".join("".join("#" if value else "." for value in row)
                     for row in np.random.RandomState(5).rand(30, 30) < 0.12)
    space = ConfigurationSpace(grid_from_text(text, 0.2), 0.25)
    lattice = Lattice(space)
    for node in range(len(lattice)):
        for heading in range(8):
            if lattice.edges[node] >> heading & 1:
                ends = space.grid.centres(lattice.cells(np.array([node, neighbour(lattice.links, node, heading)])))
                assert space.is_free_path(ends)


def test_components():
    lattice = Lattice(ConfigurationSpace(grid_from_text("""
        ...#.
        ...#.
    """, 1.0), 0.3))
    component = lattice.component
    assert component[lattice.node[0, 0]] == component[lattice.node[1, 2]] != component[lattice.node[0, 4]]
    assert lattice.cells(lattice.largest_component)[:, 1].max() == 2


def test_a_map_without_room():
    lattice = Lattice(ConfigurationSpace(grid_from_text("#.#", 1.0), 2.0))
    assert len(lattice) == 0
    assert len(lattice.largest_component) == 0
