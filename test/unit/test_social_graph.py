"""The social graph: extraction, files, and learning."""

import math

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.errors import InvalidGraph, InvalidInput
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.routes.heatmaps import EdgeCounts, Heatmaps, headings_of
from social_fleet.planning.routes.social_graph import SocialGraph, learn

EAST, NORTH_EAST, WEST = 0, 1, 4
GRID = OccupancyGrid(np.zeros((6, 20), dtype=np.int8), 0.5)


def straight(row, columns):
    return np.array([[row, column] for column in columns])


def heatmaps_of(*paths):
    heatmaps = Heatmaps(GRID.shape)
    for path in paths:
        heatmaps.add(path)
    return heatmaps


def test_an_edge_needs_more_paths_than_the_threshold():
    heatmaps = heatmaps_of(straight(2, range(20)), straight(2, range(20)), straight(2, range(10)))
    assert SocialGraph.extract(heatmaps, 1, 1, grid=GRID).edge_count == 19
    graph = SocialGraph.extract(heatmaps, 2, 1, grid=GRID)
    assert graph.edge_count == 9
    assert graph.node_count == 10
    assert graph.edges[2, 0] == 1 << EAST


def test_small_components_are_pruned_by_their_nodes():
    heatmaps = heatmaps_of(straight(0, range(8)), straight(5, range(5)))
    assert SocialGraph.extract(heatmaps, 0, 5, grid=GRID).node_count == 13
    assert SocialGraph.extract(heatmaps, 0, 6, grid=GRID).node_count == 8
    assert SocialGraph.extract(heatmaps, 0, 9, grid=GRID).edge_count == 0


def test_components_are_weakly_connected():
    meeting = heatmaps_of(straight(3, range(0, 6)), straight(3, range(10, 4, -1)))
    assert SocialGraph.extract(meeting, 0, 11, grid=GRID).node_count == 11


def test_networkx():
    graph = SocialGraph.extract(heatmaps_of(np.array([[1, 1], [2, 2], [2, 3]])), 0, 1, grid=GRID).to_networkx()
    assert set(graph.nodes) == {(1, 1), (2, 2), (2, 3)}
    assert graph.edges[(1, 1), (2, 2)] == {"heading": NORTH_EAST, "paths": 1,
                                           "weight": pytest.approx(0.5 * math.sqrt(2.0))}
    assert graph.edges[(2, 2), (2, 3)]["weight"] == 0.5


def test_edges_that_leave_the_map_are_refused():
    for heading, row, column in ((EAST, 0, 1), (WEST, 0, 0), (NORTH_EAST, 1, 0), (6, 0, 0)):
        edges = np.zeros((2, 2), dtype=np.uint8)
        edges[row, column] = 1 << heading
        with pytest.raises(InvalidGraph, match="leaves the map"):
            SocialGraph(edges, "x", 0.5)
    with pytest.raises(InvalidGraph):
        SocialGraph(np.zeros((2, 2)), "x", 0.5)
    with pytest.raises(InvalidGraph, match="do not fit"):
        SocialGraph(np.zeros((2, 2), dtype=np.uint8), "x", 0.5, counts=EdgeCounts.none((3, 2)))


def test_edges_have_the_numbers_of_their_counts():
    graph = SocialGraph.extract(heatmaps_of(straight(2, range(20)), straight(4, range(5, 1, -1))), 0, 1, grid=GRID)
    np.testing.assert_array_equal(graph.edge_numbers, graph.counts.edges)


def test_a_graph_of_another_map_is_refused():
    graph = SocialGraph.extract(heatmaps_of(straight(2, range(20))), 0, 1, grid=GRID)
    other = OccupancyGrid(np.zeros((6, 20), dtype=np.int8), 0.25)
    with pytest.raises(InvalidGraph, match="another map"):
        SocialPlanner(other, PlannerConfig(robot_radius=0.1), graph=graph)
    with pytest.raises(InvalidGraph, match="another map"):  # whatever its digest says
        SocialGraph(graph.edges[:3], GRID.digest, 0.5).check_map(GRID)


def test_learning_makes_routes_that_plans_then_take():
    text = "\n".join(["#" * 80] + ["#" + "." * 78 + "#"] * 9 + ["#" * 80])
    planner = SocialPlanner(grid_from_text(text, 0.2), PlannerConfig(exemption_radius=0.5))
    told = []
    graph = learn(planner, paths=40, seed=3, progress=lambda done, total: told.append((done, total)))
    assert told == [(done, 40) for done in range(1, 41)]
    np.testing.assert_array_equal(graph.edges, learn(planner, paths=40, seed=3).edges)
    planner.graph = graph
    plan = planner.plan((1.5, 1.1), (14.5, 1.1))
    used = graph.edges[plan.cells[:-1, 0], plan.cells[:-1, 1]] >> headings_of(plan.cells) & 1
    assert used.mean() > 0.7
    planner.graph = None
    assert planner.plan((1.5, 1.1), (14.5, 1.1)).cost >= plan.cost
    with pytest.raises(InvalidInput):
        learn(planner, paths=0, seed=1)
