"""The graph on which the fleet planners search: centres of blocks of cells, and every start and goal."""

import functools
import heapq
import math
from typing import Dict, List, NamedTuple, Sequence, Tuple

import numpy as np
from numba import njit

from social_fleet.mapping.clearance import TOUCH_TOLERANCE
from social_fleet.mapping.distances import segment_clearance
from social_fleet.mapping.grid import OccupancyGrid

_SAME_PLACE = 1e-6  # [m]
_FARTHEST_RING = 3  # of blocks about its own in which a start or goal looks for its first step


class Graph(NamedTuple):
    """A roadmap as its kernels see it.

    x, y (N,) are the nodes [m, along the grid's axes]; the edges of node n are those from first[n] on, below
    first[n + 1], with their targets and lengths [m].
    """

    x: np.ndarray
    y: np.ndarray
    first: np.ndarray
    target: np.ndarray
    length: np.ndarray


class Roadmap:
    """Where a robot of one radius may move: 8-connected block centres, joined to some points of one's own.

    A move exists where the disc fits all along it on the *original* map, so a coarse roadmap closes no passage that its
    own straight moves get through.

    Parameters
    ----------
    grid : OccupancyGrid
        The map.
    radius : float
        Of the robots [m].
    coarsening : int
        Cells along the edge of a block.
    points : (P, 2) array_like
        Starts and goals [m, map frame], where the robot fits. Each becomes a node, with straight moves to the block
        centres around it and to others of these points as near.

    Attributes
    ----------
    graph : Graph
    terminals : (P,) int64 array
        Node of each point.
    """

    def __init__(self, grid: OccupancyGrid, radius: float, coarsening: int, points: np.ndarray) -> None:
        self.grid = grid
        self.radius = radius
        self._lattice = _lattice(grid, radius, coarsening)
        self._spacing = coarsening * grid.resolution
        self._distances: Dict[int, np.ndarray] = {}
        local = grid.to_local(points)
        self.terminals, added, links = self._attach(local)
        self.graph = _joined(self._lattice.graph, np.array(added).reshape(-1, 2), links)

    def __len__(self) -> int:
        return len(self.graph.x)

    def distances(self, goal: int) -> np.ndarray:
        """Length [m] of the shortest way from every node to node `goal`, infinite where there is none."""
        if goal not in self._distances:
            self._distances[goal] = _distances(*self.graph[2:], goal)
        return self._distances[goal]

    def positions(self, nodes: np.ndarray) -> np.ndarray:
        """Nodes as points (M, 2) [m, map frame]."""
        return self.grid.from_local(np.stack([self.graph.x[nodes], self.graph.y[nodes]], axis=1))

    def _attach(self, points: np.ndarray) -> Tuple[np.ndarray, List[np.ndarray], "_Links"]:
        """Each point's node, the positions of new nodes, and the new edges in one direction."""
        terminals = np.empty(len(points), dtype=np.int64)
        added: List[np.ndarray] = []
        links: _Links = []
        for index, point in enumerate(points):
            same = self._node_at(point, added)
            if same >= 0:
                terminals[index] = same
                continue
            terminals[index] = node = len(self._lattice.graph.x) + len(added)
            near = self._near_centres(point) + self._near_points(point, added)
            links += [(node, other, math.hypot(*(place - point))) for other, place in near]
            added.append(point)
        return terminals, added, links

    def _node_at(self, point: np.ndarray, added: Sequence[np.ndarray]) -> int:
        """The node that is at `point`, -1 if none is."""
        for other, place in self._ring(point, 0):
            if math.hypot(*(place - point)) < _SAME_PLACE:
                return other
        for index, place in enumerate(added):
            if math.hypot(*(place - point)) < _SAME_PLACE:
                return len(self._lattice.graph.x) + index
        return -1

    def _near_centres(self, point: np.ndarray) -> List[Tuple[int, np.ndarray]]:
        """Centres of the blocks around that can be reached in a straight line; of more blocks where there is none."""
        for ring in range(1, _FARTHEST_RING + 1):
            near = [(node, place) for node, place in self._ring(point, ring) if self._is_free(point, place)]
            if near:
                return near
        return []

    def _near_points(self, point: np.ndarray, added: Sequence[np.ndarray]) -> List[Tuple[int, np.ndarray]]:
        reach = 2.0 * self._spacing
        return [(len(self._lattice.graph.x) + index, place) for index, place in enumerate(added)
                if math.hypot(*(place - point)) < reach and self._is_free(point, place)]

    def _ring(self, point: np.ndarray, ring: int) -> List[Tuple[int, np.ndarray]]:
        """Nodes, with their places, of the blocks at most `ring` blocks from that of `point`."""
        number, graph = self._lattice.number, self._lattice.graph
        column, row = np.floor(point / self._spacing).astype(int)
        block = number[max(row - ring, 0):row + ring + 1, max(column - ring, 0):column + ring + 1]
        return [(int(node), np.array([graph.x[node], graph.y[node]])) for node in block[block >= 0]]

    def _is_free(self, p: np.ndarray, q: np.ndarray) -> bool:
        needed = _fitting_radius(self.grid, self.radius)
        p, q = p / self.grid.resolution, q / self.grid.resolution
        return bool(segment_clearance(self.grid.blocked, p, q, needed, needed) >= needed)


_Links = List[Tuple[int, int, float]]


class _Lattice(NamedTuple):
    number: np.ndarray  # (block rows, block columns) int32: node of each block, -1 where the robot does not fit
    graph: Graph


def _fitting_radius(grid: OccupancyGrid, radius: float) -> float:
    """The radius [cells], less half of what counts as touching, so that rounding never matters."""
    return (radius - 0.5 * TOUCH_TOLERANCE) / grid.resolution


@functools.lru_cache(maxsize=8)
def _lattice(grid: OccupancyGrid, radius: float, coarsening: int) -> _Lattice:
    number, row, column = _numbered(grid.blocked, coarsening, _fitting_radius(grid, radius))
    scale = coarsening * grid.resolution
    first, target, length = _edges(grid.blocked, coarsening, _fitting_radius(grid, radius), number, row, column)
    return _Lattice(number, Graph((column + 0.5) * scale, (row + 0.5) * scale, first, target, length * scale))


@njit(cache=True)
def _numbered(blocked: np.ndarray, size: int, radius: float) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Number the blocks at whose centres the disc fits. Radius in cells."""
    rows, columns = -(-blocked.shape[0] // size), -(-blocked.shape[1] // size)
    number = np.full((rows, columns), -1, dtype=np.int32)
    count = 0
    for r in range(rows):
        for c in range(columns):
            centre = (c + 0.5) * size, (r + 0.5) * size
            if segment_clearance(blocked, centre, centre, radius, radius) >= radius:
                number[r, c] = count
                count += 1
    row, column = np.empty(count, dtype=np.int32), np.empty(count, dtype=np.int32)
    for r in range(rows):
        for c in range(columns):
            if number[r, c] >= 0:
                row[number[r, c]], column[number[r, c]] = r, c
    return number, row, column


@njit(cache=True)
def _edges(blocked: np.ndarray, size: int, radius: float, number: np.ndarray, row: np.ndarray,
           column: np.ndarray) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """First edges, targets and lengths [blocks]; an edge is checked once and holds in both directions."""
    nodes = len(row)
    around = ((0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1))
    free = np.zeros((nodes, 8), dtype=np.bool_)
    degree = np.zeros(nodes + 1, dtype=np.int64)
    for n in range(nodes):
        for k in range(4):
            r, c = row[n] + around[k][0], column[n] + around[k][1]
            if r < 0 or r >= number.shape[0] or c < 0 or c >= number.shape[1] or number[r, c] < 0:
                continue
            here, there = ((column[n] + 0.5) * size, (row[n] + 0.5) * size), ((c + 0.5) * size, (r + 0.5) * size)
            if segment_clearance(blocked, here, there, radius, radius) >= radius:
                free[n, k] = True
                free[number[r, c], k + 4] = True
                degree[n + 1] += 1
                degree[number[r, c] + 1] += 1
    first = np.cumsum(degree)
    target = np.empty(first[nodes], dtype=np.int32)
    length = np.empty(first[nodes])
    for n in range(nodes):
        place = first[n]
        for k in range(8):
            if free[n, k]:
                target[place] = number[row[n] + around[k][0], column[n] + around[k][1]]
                length[place] = math.sqrt(2.0) if k % 2 == 1 else 1.0
                place += 1
    return first, target, length


def _joined(graph: Graph, points: np.ndarray, links: _Links) -> Graph:
    """The graph with more nodes at `points` (P, 2), and `links` in both directions."""
    count = len(graph.x) + len(points)
    tail = np.repeat(np.arange(len(graph.x)), np.diff(graph.first))
    ends = np.array([(a, b) for a, b, _ in links], dtype=np.int64).reshape(-1, 2)
    more = np.array([length for _, _, length in links])
    tails = np.concatenate([tail, ends[:, 0], ends[:, 1]])
    targets = np.concatenate([graph.target, ends[:, 1], ends[:, 0]])
    lengths = np.concatenate([graph.length, more, more])
    order = np.argsort(tails, kind="stable")
    first = np.zeros(count + 1, dtype=np.int64)
    first[1:] = np.cumsum(np.bincount(tails, minlength=count))
    return Graph(np.concatenate([graph.x, points[:, 0]]), np.concatenate([graph.y, points[:, 1]]), first,
                 targets[order].astype(np.int64), lengths[order])


@njit(cache=True, nogil=True)
def _distances(first: np.ndarray, target: np.ndarray, length: np.ndarray, goal: int) -> np.ndarray:
    """Dijkstra's algorithm from the goal; edges are the same in both directions."""
    distance = np.full(len(first) - 1, np.inf)
    distance[goal] = 0.0
    queue = [(0.0, goal)]
    while queue:
        reached, node = heapq.heappop(queue)
        if reached > distance[node]:
            continue
        for edge in range(first[node], first[node + 1]):
            other, total = target[edge], reached + length[edge]
            if total < distance[other]:
                distance[other] = total
                heapq.heappush(queue, (total, other))
    return distance
