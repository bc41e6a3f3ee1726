"""Roadmaps: block centres, the moves between them, and starts and goals that lie elsewhere."""

import heapq
import math
from typing import List

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.coordination.baselines.roadmap import Roadmap
from social_fleet.geometry import Pose
from social_fleet.mapping.clearance import ConfigurationSpace

CORNER = grid_from_text("""
    ####.
    ####.
    ####.
    .....
""")


def neighbours(roadmap: Roadmap, node: int) -> List[int]:
    graph = roadmap.graph
    return sorted(graph.target[graph.first[node]:graph.first[node + 1]].tolist())


def edges(roadmap: Roadmap) -> np.ndarray:
    """Tail and head of every edge."""
    return np.stack([np.repeat(np.arange(len(roadmap)), np.diff(roadmap.graph.first)), roadmap.graph.target], axis=1)


def test_a_robot_goes_round_a_corner_not_across_it() -> None:
    roadmap = Roadmap(CORNER, 0.4, 1, np.array([(0.5, 0.5), (4.5, 3.5)]))
    assert len(roadmap) == 8
    start, goal = roadmap.terminals
    assert roadmap.distances(goal)[start] == pytest.approx(7.0)


def test_every_move_is_one_that_the_disc_fits_along() -> None:
    rng = np.random.RandomState(3)
    text = "\n".join("".join(rng.choice(list("....#"), 16)) for _ in range(16))
    grid = grid_from_text(text, 0.5, (1.0, -2.0, 0.7))
    space = ConfigurationSpace(grid, 0.3)
    start = tuple(grid.centres(np.argwhere(space.free))[0])
    roadmap = Roadmap(grid, 0.3, 2, np.array([start]))
    moves = edges(roadmap)
    assert len(moves) > 20
    for tail, head in moves:
        points = roadmap.positions(np.array([tail, head]))
        assert space.is_free_path(points)
        assert tail in neighbours(roadmap, head)
    lengths = np.hypot(*(roadmap.positions(moves[:, 0]) - roadmap.positions(moves[:, 1])).T)
    assert roadmap.graph.length == pytest.approx(lengths)


def test_distances_are_those_of_another_search() -> None:
    rng = np.random.RandomState(5)
    grid = grid_from_text("\n".join("".join(rng.choice(list("...#"), 14)) for _ in range(14)))
    roadmap = Roadmap(grid, 0.4, 1, grid.centres(np.argwhere(~grid.blocked)[:1]))
    found = roadmap.distances(int(roadmap.terminals[0]))
    best = {int(roadmap.terminals[0]): 0.0}
    queue = [(0.0, int(roadmap.terminals[0]))]
    while queue:
        so_far, node = heapq.heappop(queue)
        for other in neighbours(roadmap, node):
            points = roadmap.positions(np.array([node, other]))
            total = so_far + math.hypot(*(points[1] - points[0]))
            if total < best.get(other, math.inf) - 1e-12:
                best[other] = total
                heapq.heappush(queue, (total, other))
    assert found == pytest.approx([best.get(node, math.inf) for node in range(len(roadmap))])


def test_a_coarse_roadmap_goes_where_its_moves_fit_on_the_fine_map() -> None:
    slot = grid_from_text("""
        ..##..
        ......
        ......
        ......
        ..##..
        ..##..
    """, 0.5)
    roadmap = Roadmap(slot, 0.3, 2, np.array([(0.5, 1.5), (2.5, 1.5)]))
    start, goal = roadmap.terminals
    assert len(roadmap) == 7 and roadmap.distances(goal)[start] == pytest.approx(2.0)


def test_points_beside_the_centres_are_joined_to_those_around() -> None:
    room = grid_from_text("....\n....\n....\n....")
    points = np.array([(1.2, 1.7), (1.2, 1.7), (2.6, 1.7), (0.5, 0.5)])
    roadmap = Roadmap(room, 0.3, 1, points)
    start, twin, near, centre = roadmap.terminals
    assert start == twin == 16 and near == 17 and centre == 0 and len(roadmap) == 18
    assert roadmap.positions(roadmap.terminals) == pytest.approx(points)
    assert neighbours(roadmap, start) == [0, 1, 2, 4, 5, 6, 8, 9, 10, 17]
    assert roadmap.distances(near)[start] == pytest.approx(1.4)


def test_a_point_in_a_niche_reaches_for_centres_farther_away() -> None:
    niche = grid_from_text("""
        ########
        ########
        #......#
        ########
    """, 0.25)
    roadmap = Roadmap(niche, 0.12, 4, np.array([(0.4, 0.375)]))
    assert len(roadmap) == 1 and neighbours(roadmap, 0) == []
    wide = Roadmap(niche, 0.12, 1, np.array([(0.4, 0.375), (1.6, 0.375)]))
    assert wide.distances(int(wide.terminals[1]))[wide.terminals[0]] == pytest.approx(1.2)


def test_the_frame_of_the_map_is_kept() -> None:
    grid = grid_from_text("...\n...\n...", 1.0, Pose(5.0, 1.0, math.pi / 2.0))
    points = grid.from_local([(0.5, 0.5), (2.5, 2.5)])
    roadmap = Roadmap(grid, 0.3, 1, points)
    assert roadmap.positions(roadmap.terminals) == pytest.approx(points)
    assert roadmap.distances(int(roadmap.terminals[1]))[roadmap.terminals[0]] == pytest.approx(2.0 * math.sqrt(2.0))
