"""Discs that plans go round."""

import math

import numpy as np
import pytest

from social_fleet.errors import InvalidParameter
from social_fleet.geometry import Pose
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.overlays.discs import Disc, covered_nodes, local_discs

NODES = np.arange(400, dtype=np.int32).reshape(20, 20)


def test_the_rim_is_outside():
    disc = Disc(1.0, 2.0, 0.5)
    assert disc.holds(1.2, 2.2)
    assert not disc.holds(1.5, 2.0)


@pytest.mark.parametrize("wrong", [dict(x=math.nan), dict(y=math.inf), dict(radius=0.0), dict(radius=-1.0)])
def test_wrong_discs_are_refused(wrong):
    values = dict(x=0.0, y=0.0, radius=1.0)
    values.update(wrong)
    with pytest.raises(InvalidParameter):
        Disc(**values)


def test_discs_in_cells():
    grid = OccupancyGrid(np.zeros((4, 4), dtype=np.int8), 0.5, Pose(1.0, 2.0, math.pi / 2))
    np.testing.assert_allclose(local_discs(grid, [Disc(1.0, 3.0, 0.25)]), [[2.0, 0.0, 0.5]], atol=1e-9)
    assert local_discs(grid, []).shape == (0, 3)


def test_no_edge_between_nodes_left_touches_a_disc():
    disc = np.array([[9.3, 10.1, 3.2]])
    covered = set(covered_nodes(NODES, disc).tolist())
    assert NODES[10, 9] in covered and NODES[2, 2] not in covered
    for node in set(range(400)) - covered:
        row, column = divmod(node, 20)
        for row2, column2 in ((row, column + 1), (row + 1, column), (row + 1, column + 1), (row + 1, column - 1)):
            if 0 <= row2 < 20 and 0 <= column2 < 20 and NODES[row2, column2] not in covered:
                share = np.linspace(0.0, 1.0, 21)
                x = column + 0.5 + share * (column2 - column)
                y = row + 0.5 + share * (row2 - row)
                assert np.hypot(x - 9.3, y - 10.1).min() >= 3.2


def test_discs_off_the_map_cover_nothing():
    assert not len(covered_nodes(NODES, np.array([[-50.0, 3.0, 4.0], [100.0, 100.0, 2.0]])))
    assert not len(covered_nodes(NODES, np.zeros((0, 3))))


def test_blocked_cells_are_no_nodes():
    nodes = NODES.copy()
    nodes[10] = -1
    assert (covered_nodes(nodes, np.array([[10.0, 10.0, 3.0]])) >= 0).all()
