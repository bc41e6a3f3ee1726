"""The hierarchy against SciPy's distances."""

import numpy as np
import pytest
from scipy.sparse.csgraph import dijkstra
from test_search import World, whole_units
from worlds import grid_from_text

from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.grid_search.dissection import dissect
from social_fleet.planning.grid_search.hierarchy import aim, customised, distance_to_goal, new_potentials
from social_fleet.planning.lattice import Lattice


def hierarchy_of(world):
    links = world.lattice.links._replace(lengths=whole_units(world.lattice.lengths))
    return customised(links, dissect(links), whole_units(world.social))


def aimed(hierarchy, nodes, rim, remaining):
    potentials = new_potentials(nodes)
    aim(hierarchy, potentials, np.array(rim, dtype=np.int32), remaining)
    return potentials


def test_distances_to_a_goal_are_those_of_dijkstra_from_below():
    world = World(5, 0.0)
    hierarchy = hierarchy_of(world)
    backwards = world.matrix(world.costs(0, 0, None)).T.tocsr()
    for goal in world.pairs[:10, 1]:
        expected = dijkstra(backwards, indices=goal)
        potentials = aimed(hierarchy, len(world.lattice), [goal], np.zeros(len(world.lattice)))
        told = np.array([distance_to_goal(hierarchy, potentials, node) for node in range(len(world.lattice))])
        near = np.isfinite(expected)
        np.testing.assert_array_equal(np.isfinite(told), near)
        np.testing.assert_allclose(told[near], expected[near], atol=1e-9)


def test_a_goal_of_many_nodes_has_the_least_of_their_distances():
    world = World(6, 0.0)
    hierarchy = hierarchy_of(world)
    remaining = whole_units(np.random.RandomState(0).rand(len(world.lattice)) * 5.0)
    rim = world.pairs[:7, 0]
    potentials = aimed(hierarchy, len(world.lattice), rim, remaining)
    ways = dijkstra(world.matrix(world.costs(0, 0, None)).T.tocsr(), indices=rim) + remaining[rim][:, None]
    for node in world.pairs[:50, 1]:
        assert distance_to_goal(hierarchy, potentials, node) == pytest.approx(ways[:, node].min(), abs=1e-9)


def test_a_skeleton_by_hand():
    # A corridor of seven cells: split in the middle, then both halves are too short to be split.
    lattice = Lattice(ConfigurationSpace(grid_from_text(".......", 1.0), 0.3))
    skeleton = dissect(lattice.links)
    assert sorted(skeleton.rank.tolist()) == list(range(7))
    middle = int(np.argmax(skeleton.rank))
    assert 1 <= middle <= 5  # the line that splits the corridor is taken out last
    assert skeleton.parent[skeleton.rank[middle]] == -1
    for low in range(7):
        heads = skeleton.heads[skeleton.first[low]:skeleton.first[low + 1]]
        assert (np.diff(heads) > 0).all() and (heads > low).all()
        assert skeleton.parent[low] == (heads[0] if len(heads) else -1)
