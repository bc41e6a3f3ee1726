"""Graphs of several robots made one, and graphs on maps that changed."""

import itertools

import numpy as np
import pytest

from social_fleet.errors import InvalidGraph
from social_fleet.geometry import Pose
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.routes.graph_changes import adapted, merged
from social_fleet.planning.routes.heatmaps import MOST, EdgeCounts, Heatmaps
from social_fleet.planning.routes.social_graph import SocialGraph

GRID = OccupancyGrid(np.zeros((12, 20), dtype=np.int8), 0.5, Pose(3.0, -1.0, 0.5))


def graph_of(paths, grid=GRID, threshold=1):
    heatmaps = Heatmaps(grid.shape)
    for path in paths:
        heatmaps.add(path)
    return SocialGraph.extract(heatmaps, threshold, 3, grid=grid)


def random_paths(count, seed):
    """Paths straight along a row or a diagonal."""
    random = np.random.RandomState(seed)
    paths = []
    for _ in range(count):
        start = random.randint((4, 6), (8, 14))
        step = random.randint(-1, 2, 2)
        step = step if step.any() else np.array([0, 1])
        paths.append(start + np.arange(random.randint(2, 5))[:, None] * step)
    return paths


def same(graph, other):
    return np.array_equal(graph.edges, other.edges) and graph.counts == other.counts


def test_merging_is_counting_together_in_any_order():
    parts = [random_paths(30, seed) for seed in range(4)]
    graphs = [graph_of(paths) for paths in parts]
    together = graph_of(list(itertools.chain(*parts)))
    for order in itertools.permutations(graphs):
        assert same(merged(order, 1, 3), together)
    left = merged([merged([merged(graphs[:2], 1, 3), graphs[2]], 1, 3), graphs[3]], 1, 3)
    right = merged([graphs[0], merged([graphs[1], merged(graphs[2:], 1, 3)], 1, 3)], 1, 3)
    assert same(left, together) and same(right, together)


def test_counts_end_where_they_end_in_any_grouping():
    def few(*pairs):
        edges, counts = zip(*pairs)
        return EdgeCounts((2, 2), np.array(edges), np.array(counts, dtype=np.uint16))
    parts = [few((0, MOST - 1), (3, 1)), few((0, 1), (7, MOST)), few((0, 5), (3, 2), (7, MOST))]
    expected = few((0, MOST), (3, 3), (7, MOST))
    for order in itertools.permutations(parts):
        assert EdgeCounts.total((2, 2), order) == expected
        assert EdgeCounts.total((2, 2), [EdgeCounts.total((2, 2), order[:2]), order[2]]) == expected
    assert EdgeCounts.total((2, 2), []) == EdgeCounts.none((2, 2))


def test_an_edge_that_no_robot_used_often_enough_alone():
    path = np.array([(2, column) for column in range(8)])
    alone = graph_of([path])
    assert alone.edge_count == 0 and merged([alone, alone], 1, 3).edge_count == 7


def test_what_cannot_be_merged():
    graph = graph_of(random_paths(20, 1))
    with pytest.raises(InvalidGraph, match="nothing"):
        merged([], 1, 3)
    with pytest.raises(InvalidGraph, match="another map") as caught:
        merged([graph, graph_of(random_paths(3, 1), OccupancyGrid(GRID.values, 0.4))], 1, 3)
    assert caught.value.field == "graphs[1]"
    with pytest.raises(InvalidGraph, match="does not say how many"):
        merged([graph, SocialGraph(graph.edges, GRID.digest, 0.5)], 1, 3)


def grown(grid, below, left, above, right):
    """The map with more cells on all sides, its old ones where they were."""
    values = np.pad(grid.values, ((below, above), (left, right)))
    x, y = grid.from_local([(-left * grid.resolution, -below * grid.resolution)])[0]
    return OccupancyGrid(values, grid.resolution, Pose(x, y, grid.origin.yaw))


def test_a_map_that_grew_keeps_all():
    graph = graph_of(random_paths(40, 2))
    wider = grown(GRID, 3, 5, 2, 1)
    result = adapted(graph, wider)
    assert (result.kept, result.dropped) == (graph.edge_count, 0)
    np.testing.assert_array_equal(result.graph.edges[3:15, 5:25], graph.edges)
    assert result.graph.edge_count == graph.edge_count
    result.graph.check_map(wider)
    back = adapted(result.graph, GRID)
    assert same(back.graph, graph) and back.graph.digest == GRID.digest
    # counts are in order, so that merging goes on
    assert merged([result.graph, result.graph], 3, 3).edge_count == merged([graph, graph], 3, 3).edge_count


def test_a_map_that_shrank_or_was_built_on_keeps_what_is_left():
    graph = graph_of([np.array([(5, column) for column in range(20)])] * 2)
    values = GRID.values.copy()
    values[5, 8] = 100
    result = adapted(graph, OccupancyGrid(values, 0.5, GRID.origin))
    assert (result.kept, result.dropped) == (17, 2)
    assert not result.graph.edges[5, 7] and result.graph.edges[5, 6] and not result.graph.edges[5, 8]
    assert len(result.graph.counts.edges) == 17
    smaller = OccupancyGrid(GRID.values[:, :10], 0.5, GRID.origin)
    assert adapted(graph, smaller)[1:] == (9, 10)
    elsewhere = OccupancyGrid(GRID.values, 0.5, Pose(100.0, 100.0, 0.5))
    assert adapted(graph, elsewhere)[1:] == (0, 19)


def test_cells_that_do_not_coincide_move_by_less_than_half():
    graph = graph_of(random_paths(40, 3))
    x, y = GRID.from_local([(0.2, -0.2)])[0]
    result = adapted(graph, OccupancyGrid(GRID.values, 0.5, Pose(x, y, 0.5)))
    np.testing.assert_array_equal(result.graph.edges, graph.edges)


@pytest.mark.parametrize("grid, field", [
    (OccupancyGrid(GRID.values, 0.25, GRID.origin), "resolution"),
    (OccupancyGrid(GRID.values, 0.5, Pose(3.0, -1.0, 0.6)), "yaw"),
])
def test_other_cells_cannot_be_kept(grid, field):
    with pytest.raises(InvalidGraph) as caught:
        adapted(graph_of(random_paths(10, 4)), grid)
    assert caught.value.field == field
    with pytest.raises(InvalidGraph, match="where its map lay"):
        adapted(SocialGraph(np.zeros(GRID.shape, dtype=np.uint8), "x", 0.5), GRID)
