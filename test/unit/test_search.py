"""The search against an independent Dijkstra over the same edge costs, and by hand on tiny worlds."""

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from worlds import grid_from_text

from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.mapping.walls import HEADINGS
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.grid_search.hierarchy import UNIT
from social_fleet.planning.lattice import Lattice
from social_fleet.planning.search import Search
from social_fleet.planning.social_cost.costs import edge_costs
from social_fleet.planning.social_cost.norms import norm_of

EPSILON = 0.01


def whole_units(costs):
    return np.round(costs / UNIT) * UNIT


class World:
    """A random map of 60 x 60 cells with its lattice, social costs and a random graph."""

    def __init__(self, seed, exemption, resolution=0.2):
        random = np.random.RandomState(seed)
        values = np.where(random.rand(60, 60) < 0.2, 100, 0).astype(np.int8)
        grid = OccupancyGrid(values, resolution)
        self.exemption = exemption
        self.lattice = Lattice(ConfigurationSpace(grid, 0.08))
        config = PlannerConfig(robot_radius=0.08, open_area=3.0)
        self.social = edge_costs(self.lattice, grid.blocked, norm_of(config), stretch=config.wall_stretch)
        self.graph = random.randint(0, 256, len(self.lattice)).astype(np.uint8) & self.lattice.edges
        self.search = Search(self.lattice, self.social, exemption_radius=exemption, epsilon=EPSILON)
        nodes = self.lattice.largest_component
        self.pairs = nodes[random.randint(0, len(nodes), (200, 2))]
        self.tail, self.heading = np.nonzero(np.isfinite(self.social))
        steps = HEADINGS[self.heading]
        self.head = self.lattice.node[self.lattice.row[self.tail] + steps[:, 1],
                                      self.lattice.col[self.tail] + steps[:, 0]]
        self.length = whole_units(resolution * np.hypot(*steps.T))

    def costs(self, start, goal, graph, social=True):
        """What every edge costs in Eq. 2 or 4 for this pair, worked out from the definitions alone."""
        beyond = np.zeros(len(self.tail))
        if graph is not None:
            beyond = np.where(graph[self.tail] >> self.heading & 1, 0.0, whole_units(EPSILON))
        free = self.matrix(self.length + beyond)  # without social cost
        near = np.zeros(len(self.lattice), dtype=bool)
        if self.exemption > 0.0:
            near |= dijkstra(free, indices=start, limit=self.exemption) < np.inf
            near |= dijkstra(free.T.tocsr(), indices=goal, limit=self.exemption) < np.inf
        waived = near[self.tail] | near[self.head] | (not social)
        if graph is not None:
            waived |= beyond == 0.0
        social = whole_units(self.social[self.tail, self.heading].astype(float))
        return self.length + beyond + np.where(waived, 0.0, social)

    def matrix(self, costs):
        return coo_matrix((costs, (self.tail, self.head)), shape=(len(self.lattice),) * 2).tocsr()


@pytest.mark.parametrize("exemption", [0.0, 1.0])
@pytest.mark.parametrize("with_graph", [False, True])
@pytest.mark.parametrize("prepared", [False, True])
def test_the_cost_is_that_of_an_independent_dijkstra(exemption, with_graph, prepared):
    world = World(7, exemption)
    graph = world.graph if with_graph else None
    metric = world.search.metric(graph, prepared=prepared)
    for start, goal in world.pairs:
        result = world.search.cheapest(start, goal, metric)
        matrix = world.matrix(world.costs(start, goal, graph))
        assert result.cost == pytest.approx(dijkstra(matrix, indices=start)[goal], abs=1e-6)
        along = sum(matrix[node, other] for node, other in zip(result.nodes, result.nodes[1:]))
        assert along == pytest.approx(result.cost, abs=1e-6)
        assert world.search.evaluate(result, metric).sum() == pytest.approx(result.cost, abs=1e-6)


@pytest.mark.parametrize("with_graph", [False, True])
def test_a_prepared_search_stays_optimal_round_closed_nodes(with_graph):
    world = World(3, 1.0)
    graph = world.graph if with_graph else None
    prepared, plain = (world.search.metric(graph, prepared=choice) for choice in (True, False))
    random = np.random.RandomState(1)
    unreachable = 0
    for start, goal in world.pairs:
        closed = np.setdiff1d(random.randint(0, len(world.lattice), 200), (start, goal)).astype(np.int32)
        guided, other = (world.search.cheapest(start, goal, metric, closed=closed) for metric in (prepared, plain))
        unreachable += guided is None
        assert (guided is None) == (other is None)
        if guided is not None:
            assert guided.cost == pytest.approx(other.cost, abs=1e-6)
            assert not np.isin(guided.nodes, closed).any()
    assert unreachable < len(world.pairs) // 2


def test_the_shortest_path_is_that_of_an_independent_dijkstra():
    world = World(8, 1.0)
    distances = dijkstra(world.matrix(world.costs(0, 0, None, social=False)), indices=world.pairs[:, 0])
    for row, (start, goal) in zip(distances, world.pairs):
        assert world.search.shortest(start, goal).cost == pytest.approx(row[goal], abs=1e-6)


def test_the_same_search_gives_the_same_path():
    world = World(9, 1.0)
    start, goal = world.pairs[0]
    metric = world.search.metric(prepared=True)
    first = world.search.cheapest(start, goal, metric)
    for other, another in world.pairs[1:20]:
        world.search.cheapest(other, another, metric)
    again = world.search.cheapest(start, goal, metric)
    np.testing.assert_array_equal(first.nodes, again.nodes)
    assert first.expanded == again.expanded


def small(text):
    grid = grid_from_text(text, 1.0)
    lattice = Lattice(ConfigurationSpace(grid, 0.3))
    return lattice, Search(lattice, np.where(lattice.edges[:, None] >> np.arange(8) & 1, 0, np.inf).astype(np.float32))


def test_by_hand():
    lattice, search = small("""
        .....
        .###.
        .....
    """)
    result = search.shortest(lattice.node[0, 0], lattice.node[2, 4])
    assert result.cost == pytest.approx(6.0)
    assert lattice.cells(result.nodes)[0].tolist() == [0, 0]
    assert lattice.cells(result.nodes)[-1].tolist() == [2, 4]
    assert len(result.nodes) == len(result.headings) + 1 == 7


def test_closed_nodes_are_gone_round_and_opened_again():
    lattice, search = small("""
        .....
        .###.
        .....
    """)
    start, goal = lattice.node[0, 0], lattice.node[0, 4]
    assert search.shortest(start, goal).cost == pytest.approx(4.0)
    assert search.shortest(start, goal, closed=np.array([lattice.node[0, 2]])).cost == pytest.approx(8.0)
    assert search.shortest(start, goal, closed=lattice.node[[0, 2], [2, 2]]) is None
    assert search.shortest(start, goal).cost == pytest.approx(4.0)


def test_no_way():
    lattice, search = small("..#..")
    assert search.shortest(lattice.node[0, 0], lattice.node[0, 4]) is None


def test_start_is_goal():
    lattice, search = small("...")
    result = search.cheapest(1, 1, search.metric())
    assert result.cost == 0.0
    assert result.nodes.tolist() == [1]
    assert not len(result.headings)
    assert lattice.cells(result.nodes).tolist() == [[0, 1]]
