"""The graph that is searched: free cells as numbered nodes, eight headings, one bit per edge that can be driven.

Nodes are numbered row by row, so a node's neighbours in its own row are the numbers beside it, and those in the
row above lie around the node straight above. Two int32 per node thus give all eight neighbours, because a diagonal
edge exists only where the straight one does. Headings count counter-clockwise from the grid's columns.
"""

import math
from typing import NamedTuple, Tuple

import numpy as np
from numba import njit

from social_fleet.mapping.clearance import TOUCH_TOLERANCE, ConfigurationSpace
from social_fleet.mapping.distances import segment_clearance
from social_fleet.mapping.walls import HEADINGS

DCOL, DROW = HEADINGS[:, 0].copy(), HEADINGS[:, 1].copy()
SQRT2 = math.sqrt(2.0)


def fitting_radius(space: ConfigurationSpace) -> float:
    """The robot's radius in cells, less half of what counts as touching, so that rounding never matters."""
    return (space.radius - 0.5 * TOUCH_TOLERANCE) / space.grid.resolution


class Links(NamedTuple):
    """A lattice as its kernels see it; see `Lattice` for the arrays."""

    row: np.ndarray
    col: np.ndarray
    up: np.ndarray
    down: np.ndarray
    edges: np.ndarray
    lengths: np.ndarray


class Lattice:
    """The free cells of a configuration space as a graph.

    Parameters
    ----------
    space : ConfigurationSpace
        Map and robot radius.

    Attributes
    ----------
    node : (rows, cols) int32 array
        Number of each free cell's node, -1 elsewhere.
    row, col : (N,) int32 arrays
        The cell of each node.
    up, down : (N,) int32 arrays
        Node of the cell in the next and the previous row, -1 where that is not free.
    edges : (N,) uint8 array
        Bit k is set where the edge in heading k can be driven: the neighbour is free, for a diagonal both its
        orthogonal neighbours too, and the robot's disc fits all along.
    lengths : (8,) float64 array
        Length [m] of an edge by heading.
    links : Links
        The arrays above for kernels.
    component : (N,) int32 array
        Nodes with the same number reach each other.
    """

    def __init__(self, space: ConfigurationSpace) -> None:
        grid = space.grid
        self.resolution = grid.resolution
        self.node, self.row, self.col, self.up, self.down = _number(space.free)
        self.edges = _drivable_edges(self.node, self.row, self.col, space.clearance, grid.blocked,
                                     fitting_radius(space), grid.resolution)
        self.lengths = np.where(np.arange(8) % 2 == 0, 1.0, SQRT2) * grid.resolution
        self.links = Links(self.row, self.col, self.up, self.down, self.edges, self.lengths)
        self.component, self._sizes = _components(self.links)

    def __len__(self) -> int:
        return len(self.row)

    def cells(self, nodes: np.ndarray) -> np.ndarray:
        """(row, column) of `nodes`, shape (M, 2)."""
        return np.column_stack([self.row[nodes], self.col[nodes]])

    def centres(self, nodes: np.ndarray) -> np.ndarray:
        """Centres (x, y) of the cells of `nodes` in cells along the grid's axes, shape (M, 2)."""
        return np.column_stack([self.col[nodes], self.row[nodes]]) + 0.5

    @property
    def largest_component(self) -> np.ndarray:
        """Nodes of the largest component, ascending; none on a map without free cells."""
        if not len(self._sizes):
            return np.zeros(0, dtype=np.int64)
        return np.flatnonzero(self.component == np.argmax(self._sizes))


@njit(cache=True, nogil=True)
def step(up: np.ndarray, down: np.ndarray, node: int, heading: int) -> int:
    """The node that an edge of `node` in `heading` leads to; only valid where that edge exists."""
    if heading == 0:
        return node + 1
    if heading == 4:
        return node - 1
    if heading < 4:
        return up[node] + 2 - heading
    return down[node] + heading - 6


@njit(cache=True, nogil=True)
def neighbour(links: Links, node: int, heading: int) -> int:
    """`step` for those who have a lattice's `links` at hand."""
    return step(links.up, links.down, node, heading)


@njit(cache=True)
def _number(free: np.ndarray) -> Tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    rows, cols = free.shape
    node = np.full((rows, cols), -1, dtype=np.int32)
    count = 0
    for r in range(rows):
        for c in range(cols):
            if free[r, c]:
                node[r, c] = count
                count += 1
    row = np.empty(count, dtype=np.int32)
    col = np.empty(count, dtype=np.int32)
    up = np.full(count, -1, dtype=np.int32)
    down = np.full(count, -1, dtype=np.int32)
    for r in range(rows):
        for c in range(cols):
            n = node[r, c]
            if n >= 0:
                row[n] = r
                col[n] = c
                if r + 1 < rows:
                    up[n] = node[r + 1, c]
                if r > 0:
                    down[n] = node[r - 1, c]
    return node, row, col, up, down


@njit(cache=True)
def _drivable_edges(node: np.ndarray, row: np.ndarray, col: np.ndarray, clearance: np.ndarray, blocked: np.ndarray,
                    radius: float, resolution: float) -> np.ndarray:
    """Headings 0 to 3 are checked, the other four are the same edges backwards. `radius` in cells."""
    rows, cols = node.shape
    edges = np.zeros(len(row), dtype=np.uint8)
    for n in range(len(row)):
        r, c = row[n], col[n]
        for k in range(4):
            r2, c2 = r + DROW[k], c + DCOL[k]
            if r2 >= rows or c2 < 0 or c2 >= cols or node[r2, c2] < 0:
                continue
            if k % 2 == 1 and (node[r2, c] < 0 or node[r, c2] < 0):
                continue
            # Half an edge away from both ends, a wall may be nearer to the edge than to either of them.
            nearest = min(clearance[r, c], clearance[r2, c2]) / resolution
            half = 0.25 if k % 2 == 0 else 0.5
            if nearest * nearest < radius * radius + half + 1e-4:
                ends = (c + 0.5, r + 0.5), (c2 + 0.5, r2 + 0.5)
                if segment_clearance(blocked, ends[0], ends[1], radius, radius) < radius:
                    continue
            edges[n] |= np.uint8(1 << k)
            edges[node[r2, c2]] |= np.uint8(1 << (k + 4))
    return edges


@njit(cache=True)
def _components(links: Links) -> Tuple[np.ndarray, np.ndarray]:
    """The component of every node, and how many nodes each component has."""
    nodes = len(links.row)
    component = np.full(nodes, -1, dtype=np.int32)
    stack = np.empty(nodes, dtype=np.int32)
    sizes = np.zeros(nodes, dtype=np.int32)
    count = 0
    for seed in range(nodes):
        if component[seed] >= 0:
            continue
        component[seed] = count
        stack[0] = seed
        top = 1
        while top > 0:
            top -= 1
            n = stack[top]
            sizes[count] += 1
            for k in range(8):
                if links.edges[n] >> k & 1:
                    m = neighbour(links, n, k)
                    if component[m] < 0:
                        component[m] = count
                        stack[top] = m
                        top += 1
        count += 1
    return component, sizes[:count]
