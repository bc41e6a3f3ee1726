"""A* over the lattice, optimal in Eq. 2 or Eq. 4.

The queue is a ring of buckets a sixteenth of a cell wide. Within a bucket the last entry comes first, and a node is
expanded again when a cheaper way to it turns up, so the order inside a bucket affects time, not the result.
"""

import math
from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np
from numba import njit

from social_fleet.planning.lattice import DCOL, DROW, Lattice, neighbour

BUCKETS_PER_CELL = 16
MAX_BUCKETS = 1 << 16
OCTILE = math.sqrt(2.0) - 1.0


@dataclass(frozen=True)
class SearchResult:
    """The cheapest path over the lattice.

    Attributes
    ----------
    nodes : (M,) int32 array
        From the start's node to the goal's.
    headings : (M - 1,) uint8 array
        Heading of every step.
    cost : float
        What was minimised [m].
    expanded : int
        Nodes taken from the queue, repeated ones included.
    """

    nodes: np.ndarray
    headings: np.ndarray
    cost: float
    expanded: int


class Search:
    """Searches one lattice again and again in the same memory.

    Parameters
    ----------
    lattice : Lattice
        The graph.
    social : (N, 8) float32 array
        Social cost of every edge, infinite where there is none.
    exemption_radius : float
        Edges with an end this close [m] to start or goal cost their length only.
    epsilon : float
        Extra cost [m] of an edge outside the social graph.
    """

    def __init__(self, lattice: Lattice, social: np.ndarray, *, exemption_radius: float = 0.0,
                 epsilon: float = 0.0) -> None:
        self._lattice = lattice
        self._social = social
        self._exempt = (exemption_radius / lattice.resolution) ** 2
        self._epsilon = epsilon
        self._no_graph = np.zeros(1, dtype=np.uint8)
        dearest = float(np.max(social, where=np.isfinite(social), initial=0.0)) + epsilon
        width = lattice.resolution / BUCKETS_PER_CELL
        span = 2.0 * lattice.lengths.max() + dearest
        width = max(width, span / (MAX_BUCKETS - 4))
        self._width = width
        self._heads = np.full(1 << math.ceil(math.log2(span / width + 4.0)), -1, dtype=np.int32)
        count = len(lattice)
        self._reached = np.full(count, np.inf)
        self._arrival = np.zeros(count, dtype=np.uint8)
        self._touched = np.empty(count, dtype=np.int32)
        self._pool = (np.empty(4096, dtype=np.int32), np.empty(4096, dtype=np.int32), np.empty(4096))

    def shortest(self, start: int, goal: int, *, closed: Optional[np.ndarray] = None) -> Optional[SearchResult]:
        """The shortest path, without social cost. See `cheapest`."""
        return self._run(start, goal, False, None, closed)

    def cheapest(self, start: int, goal: int, *, graph: Optional[np.ndarray] = None,
                 closed: Optional[np.ndarray] = None) -> Optional[SearchResult]:
        """The path that minimises Eq. 2, or Eq. 4 with a graph.

        Parameters
        ----------
        start, goal : int
            Nodes.
        graph : (N,) uint8 array, optional
            Social graph: bit k of a node is set where its edge in heading k belongs to it.
        closed : (M,) int array, optional
            Nodes that this search must not enter.

        Returns
        -------
        SearchResult or None
            None when the goal cannot be reached.
        """
        return self._run(start, goal, True, graph, closed)

    def _run(self, start: int, goal: int, social: bool, graph: Optional[np.ndarray],
             closed: Optional[np.ndarray]) -> Optional[SearchResult]:
        lattice = self._lattice
        if closed is not None:
            self._reached[closed] = -np.inf
        epsilon = self._epsilon if graph is not None else 0.0
        cost, expanded, touched, self._pool = _search(
            start, goal, lattice.row, lattice.col, lattice.up, lattice.down, lattice.edges, self._social,
            lattice.lengths, social, self._no_graph if graph is None else graph, graph is not None, epsilon,
            self._exempt, lattice.resolution, self._width, self._reached, self._arrival, self._touched, self._heads,
            self._pool)
        result = None
        if math.isfinite(cost):
            nodes, headings = _trace(start, goal, self._arrival, lattice.up, lattice.down)
            result = SearchResult(nodes, headings, cost, expanded)
        self._reached[self._touched[:touched]] = np.inf
        if closed is not None:
            self._reached[closed] = np.inf
        return result

    def evaluate(self, nodes: np.ndarray, headings: np.ndarray, graph: Optional[np.ndarray] = None) -> np.ndarray:
        """Length and social part [m] of Eq. 2 or 4 of given steps, exemption included: shape (2, M - 1)."""
        lattice = self._lattice
        social = self._social[nodes[:-1], headings].astype(float)
        exempt = np.zeros(len(nodes), dtype=bool)
        for end in (nodes[0], nodes[-1]):
            offset = (lattice.row[nodes] - lattice.row[end]) ** 2 + (lattice.col[nodes] - lattice.col[end]) ** 2
            exempt |= offset <= self._exempt
        social[exempt[:-1] | exempt[1:]] = 0.0
        if graph is not None:
            member = (graph[nodes[:-1]] >> headings & 1).astype(bool)
            social = np.where(member, 0.0, social + self._epsilon)
        return np.stack([lattice.lengths[headings], social])


@njit(cache=True)
def _octile(drow: int, dcol: int) -> float:
    """Length in cells of the shortest 8-connected path over an empty map."""
    drow, dcol = abs(drow), abs(dcol)
    return max(drow, dcol) + OCTILE * min(drow, dcol)


@njit(cache=True)
def _search(start, goal, row, col, up, down, edges, social, lengths, is_social, graph, has_graph, epsilon,  # type: ignore
            exempt, resolution, width, reached, arrival, touched, heads, pool):
    """Returns (cost or inf, expanded, number of touched nodes, pool); `reached` holds -inf at closed nodes."""
    pool_node, pool_next, pool_cost = pool
    mask = len(heads) - 1
    heads[:] = -1
    used = 0
    spare = -1
    live = 0
    goal_row, goal_col = row[goal], col[goal]
    start_row, start_col = row[start], col[start]
    # One step from the exempt disc an edge may still have an end in it.
    margin = (math.sqrt(exempt) + 1.5) ** 2
    base = _octile(goal_row - start_row, goal_col - start_col) * resolution
    scale = 1.0 / width
    reached[start] = 0.0
    touched[0] = start
    touch = 1
    pool_node[0], pool_cost[0], pool_next[0] = start, 0.0, -1
    heads[0] = 0
    used, live = 1, 1
    bucket = 0
    best = np.inf
    expanded = 0
    while live > 0:
        entry = heads[bucket & mask]
        if entry < 0:
            bucket += 1
            if best < np.inf and base + bucket * width > best:
                break
            continue
        heads[bucket & mask] = pool_next[entry]
        pool_next[entry] = spare
        spare = entry
        live -= 1
        node, cost = np.int64(pool_node[entry]), pool_cost[entry]
        if cost > reached[node]:
            continue
        r, c = row[node], col[node]
        if node == goal:
            best = cost
            continue
        if cost + _octile(r - goal_row, c - goal_col) * resolution >= best:
            continue
        expanded += 1
        near_start = (r - start_row) ** 2 + (c - start_col) ** 2
        near_goal = (r - goal_row) ** 2 + (c - goal_col) ** 2
        near = near_start <= margin or near_goal <= margin
        inside = near_start <= exempt or near_goal <= exempt
        bits = edges[node]
        above, below = np.int64(up[node]), np.int64(down[node])
        around = (node + 1, above + 1, above, above - 1, node - 1, below - 1, below, below + 1)
        for k in range(8):
            if not bits >> k & 1:
                continue
            other = around[k]
            known = reached[other]
            total = cost + lengths[k]
            if total >= known:
                continue
            r2, c2 = r + DROW[k], c + DCOL[k]
            if is_social:
                if has_graph and graph[node] >> k & 1:
                    pass
                else:
                    free_of_cost = inside
                    if near and not inside:
                        free_of_cost = ((r2 - start_row) ** 2 + (c2 - start_col) ** 2 <= exempt
                                        or (r2 - goal_row) ** 2 + (c2 - goal_col) ** 2 <= exempt)
                    total += epsilon
                    if not free_of_cost:
                        total += social[node, k]
                    if total >= known:
                        continue
            estimate = total + _octile(r2 - goal_row, c2 - goal_col) * resolution
            if estimate >= best:
                continue
            if known == np.inf:
                touched[touch] = other
                touch += 1
            reached[other] = total
            arrival[other] = k
            if spare >= 0:
                entry = spare
                spare = pool_next[entry]
            else:
                if used == len(pool_node):
                    pool_node = np.concatenate((pool_node, np.empty_like(pool_node)))
                    pool_next = np.concatenate((pool_next, np.empty_like(pool_next)))
                    pool_cost = np.concatenate((pool_cost, np.empty_like(pool_cost)))
                entry = used
                used += 1
            slot = max(int((estimate - base) * scale), bucket)
            pool_node[entry] = other
            pool_cost[entry] = total
            pool_next[entry] = heads[slot & mask]
            heads[slot & mask] = entry
            live += 1
    return best, expanded, touch, (pool_node, pool_next, pool_cost)


@njit(cache=True)
def _trace(start: int, goal: int, arrival: np.ndarray, up: np.ndarray,
           down: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Nodes and headings of the path, followed back from the goal."""
    count = 1
    node = goal
    while node != start:
        node = neighbour(node, (arrival[node] + 4) % 8, up, down)
        count += 1
    nodes = np.empty(count, dtype=np.int32)
    headings = np.empty(count - 1, dtype=np.uint8)
    node = goal
    for i in range(count - 1, 0, -1):
        nodes[i] = node
        headings[i - 1] = arrival[node]
        node = neighbour(node, (arrival[node] + 4) % 8, up, down)
    nodes[0] = start
    return nodes, headings
