"""Directional heatmaps."""

import numpy as np
import pytest

from social_fleet.errors import InvalidInput
from social_fleet.planning.routes.heatmaps import MOST, EdgeCounts, Heatmaps, edges_of, headings_of

EAST, NORTH_EAST, WEST = 0, 1, 4


def test_a_path_counts_where_and_whither_it_went():
    heatmaps = Heatmaps((3, 4))
    heatmaps.add(np.array([[0, 0], [0, 1], [1, 2]]))
    heatmaps.add(np.array([[0, 0], [0, 1]]))
    assert heatmaps.counts[EAST, 0, 0] == 2
    assert heatmaps.counts[NORTH_EAST, 0, 1] == 1
    assert heatmaps.counts.sum() == 3
    assert heatmaps.shape == (3, 4)


def test_opposite_traffic_is_told_apart():
    heatmaps = Heatmaps((1, 2))
    heatmaps.add(np.array([[0, 0], [0, 1]]))
    heatmaps.add(np.array([[0, 1], [0, 0]]))
    assert heatmaps.counts[EAST, 0].tolist() == [1, 0]
    assert heatmaps.counts[WEST, 0].tolist() == [0, 1]


def test_all_headings():
    ring = np.array([[0, 0], [0, 1], [1, 2], [2, 2], [3, 1], [3, 0], [2, -1], [1, -1], [0, 0]])
    assert headings_of(ring).tolist() == list(range(8))


def test_counts_stop_at_their_maximum():
    heatmaps = Heatmaps((1, 2))
    heatmaps.counts[EAST, 0, 0] = 65535
    heatmaps.add(np.array([[0, 0], [0, 1]]))
    assert heatmaps.counts[EAST, 0, 0] == 65535


@pytest.mark.parametrize("cells", [
    [[0, 0], [0, 2]],  # a leap
    [[0, 0], [0, 0]],  # a rest
    [[0, 0], [-1, 0]],  # off the map
    [[0, 3], [0, 4]],
])
def test_what_is_no_path_is_refused_and_not_counted(cells):
    heatmaps = Heatmaps((2, 4))
    with pytest.raises(InvalidInput):
        heatmaps.add(np.array([[1, 1], [0, 1]] + cells if cells[0] == [0, 0] else cells))
    assert heatmaps.counts.sum() == 0


def test_a_single_cell_counts_nothing():
    heatmaps = Heatmaps((2, 2))
    heatmaps.add(np.array([[1, 1]]))
    heatmaps.add(np.zeros((0, 2), dtype=int))
    assert heatmaps.counts.sum() == 0


def test_counts_without_the_unused_edges():
    heatmaps = Heatmaps((3, 4))
    for _ in range(2):
        heatmaps.add(np.array([[0, 0], [0, 1], [1, 2]]))
    counts = heatmaps.edge_counts()
    assert counts == EdgeCounts((3, 4), np.array([0, 12 + 1]), np.array([2, 2], dtype=np.uint16))
    assert [part.tolist() for part in counts.places] == [[EAST, NORTH_EAST], [0, 0], [0, 1]]
    np.testing.assert_array_equal(edges_of(np.array([[0, 0], [0, 1], [1, 2]]), (3, 4)), counts.edges)
    again = Heatmaps((3, 4))
    again.add_counts(counts)
    again.add_counts(EdgeCounts((3, 4), np.array([0]), np.array([MOST], dtype=np.uint16)))
    assert again.counts[EAST, 0, 0] == MOST and again.counts[NORTH_EAST, 0, 1] == 2


def test_forgetting_cells_takes_the_edges_that_leave_and_enter_them():
    heatmaps = Heatmaps((3, 5))
    heatmaps.add(np.array([[1, 0], [1, 1], [1, 2], [1, 3], [1, 4]]))
    heatmaps.add(np.array([[2, 4], [2, 3], [1, 2], [0, 1], [0, 0]]))
    heatmaps.forget(np.array([[1, 2], [0, 0]]))
    left = heatmaps.edge_counts()
    assert [part.tolist() for part in left.places] == [[EAST, EAST, WEST], [1, 1, 2], [0, 3, 4]]
