"""A* over the lattice, optimal in Eq. 2 or Eq. 4.

The queue is a ring of buckets a sixteenth of a cell wide. Within a bucket the last entry comes first, and a node is
expanded again when a cheaper way to it turns up, so the order inside a bucket affects time, not the result.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple, Optional, Tuple

import numpy as np
from numba import njit

from social_fleet.planning.lattice import DCOL, DROW, Lattice, Links, neighbour

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


class Query(NamedTuple):
    """One search: `exempt` is the squared radius [cells^2] about start and goal where the social part is waived."""

    start: int
    goal: int
    social: bool
    graph: np.ndarray
    has_graph: bool
    epsilon: float
    exempt: float


class Memory(NamedTuple):
    """Per node: cost to reach it (inf where it wasn't, -inf where it must not be) and heading of arrival; then a list."""

    reached: np.ndarray
    arrival: np.ndarray
    touched: np.ndarray


class Queue(NamedTuple):
    """Buckets as linked lists: the top entry of each, and of every entry its node, its cost and the entry below."""

    heads: np.ndarray
    node: np.ndarray
    cost: np.ndarray
    below: np.ndarray


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
        self._none = np.zeros(1, dtype=np.uint8)
        dearest = float(np.max(social, where=np.isfinite(social), initial=0.0)) + epsilon
        width = lattice.resolution / BUCKETS_PER_CELL
        span = 2.0 * lattice.lengths.max() + dearest
        width = max(width, span / (MAX_BUCKETS - 4))
        self._width = width
        buckets = 1 << math.ceil(math.log2(span / width + 4.0))
        self._queue = Queue(np.full(buckets, -1, dtype=np.int32), np.empty(4096, dtype=np.int32), np.empty(4096),
                            np.empty(4096, dtype=np.int32))
        count = len(lattice)
        self._reached = np.full(count, np.inf)
        self._arrival = np.zeros(count, dtype=np.uint8)
        self._touched = np.empty(count, dtype=np.int32)

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
        no_graph = self._none if graph is None else graph
        query = Query(start, goal, social, no_graph, graph is not None, epsilon, self._exempt)
        memory = Memory(self._reached, self._arrival, self._touched)
        cost, expanded, touched, self._queue = _search(lattice.links, self._social, query, memory, self._queue,
                                                       lattice.resolution, self._width)
        result = None
        if math.isfinite(cost):
            nodes, headings = _trace(lattice.links, start, goal, self._arrival)
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
def octile(drow: int, dcol: int) -> float:
    """Length in cells of the shortest 8-connected path over an empty map."""
    drow, dcol = abs(drow), abs(dcol)
    return max(drow, dcol) + OCTILE * min(drow, dcol)


@njit(cache=True)
def _push(queue: Queue, state: np.ndarray, bucket: int, node: int, cost: float) -> None:
    """Put a node into a bucket; there must be room. `state` is (next unused entry, first spare entry, entries in use)."""
    entry = state[1]
    if entry >= 0:
        state[1] = queue.below[entry]
    else:
        entry = state[0]
        state[0] += 1
    slot = bucket & (len(queue.heads) - 1)
    queue.node[entry] = node
    queue.cost[entry] = cost
    queue.below[entry] = queue.heads[slot]
    queue.heads[slot] = entry
    state[2] += 1


@njit(cache=True)
def _pop(queue: Queue, state: np.ndarray, slot: int) -> int:
    """Take the entry on top of a bucket that has one."""
    entry = queue.heads[slot]
    queue.heads[slot] = queue.below[entry]
    queue.below[entry] = state[1]
    state[1] = entry
    state[2] -= 1
    return entry


@njit(cache=True)
def _grown(queue: Queue) -> Queue:
    """The queue with room for twice as many entries."""
    return Queue(queue.heads, np.concatenate((queue.node, queue.node)), np.concatenate((queue.cost, queue.cost)),
                 np.concatenate((queue.below, queue.below)))


@njit(cache=True)
def _distance_squared(links: Links, a: int, b: int) -> int:
    """Between the centres of two nodes [cells^2]."""
    drow, dcol = links.row[a] - links.row[b], links.col[a] - links.col[b]
    return drow * drow + dcol * dcol


@njit(cache=True)
def _nearness(links: Links, query: Query, node: int, margin: float) -> int:
    """2 where all edges of a node are exempt from social cost, 1 where some may be, 0 where none is."""
    nearest = min(_distance_squared(links, node, query.start), _distance_squared(links, node, query.goal))
    if nearest <= query.exempt:
        return 2
    return 1 if nearest <= margin else 0


@njit(cache=True)
def _search(links: Links, social: np.ndarray, query: Query, memory: Memory, queue: Queue, resolution: float,
            width: float) -> Tuple[float, int, int, Queue]:
    """Returns the cost (inf where there is no path), expanded and touched nodes, and the queue, perhaps grown."""
    reached, arrival, touched = memory
    state = np.array([0, -1, 0])
    mask = len(queue.heads) - 1
    queue.heads[:] = -1
    goal_row, goal_col = links.row[query.goal], links.col[query.goal]
    # One step from the exempt disc an edge may still have an end in it.
    margin = (math.sqrt(query.exempt) + 1.5) ** 2
    base = octile(goal_row - links.row[query.start], goal_col - links.col[query.start]) * resolution
    reached[query.start] = 0.0
    touched[0] = query.start
    touch, expanded, bucket, best = 1, 0, 0, np.inf
    _push(queue, state, 0, query.start, 0.0)
    while state[2] > 0:
        if queue.heads[bucket & mask] < 0:
            bucket += 1
            if base + bucket * width > best:
                break
            continue
        entry = _pop(queue, state, bucket & mask)
        node, cost = np.int64(queue.node[entry]), queue.cost[entry]
        if cost > reached[node]:
            continue
        if node == query.goal:
            best = cost
            continue
        r, c = links.row[node], links.col[node]
        if cost + octile(r - goal_row, c - goal_col) * resolution >= best:
            continue
        expanded += 1
        if state[0] + 8 > len(queue.node):
            queue = _grown(queue)
        nearness = _nearness(links, query, node, margin) if query.social else 2
        learnt = query.graph[node] if query.has_graph else 0
        above, below = np.int64(links.up[node]), np.int64(links.down[node])
        around = (node + 1, above + 1, above, above - 1, node - 1, below - 1, below, below + 1)
        for k in range(8):
            if not links.edges[node] >> k & 1:
                continue
            other = around[k]
            known = reached[other]
            total = cost + links.lengths[k]
            if total >= known:
                continue
            if not learnt >> k & 1:
                total += query.epsilon
                if nearness == 0 or (nearness == 1 and _nearness(links, query, other, margin) < 2):
                    total += social[node, k]
                if total >= known:
                    continue
            estimate = total + octile(r + DROW[k] - goal_row, c + DCOL[k] - goal_col) * resolution
            if estimate >= best:
                continue
            if known == np.inf:
                touched[touch] = other
                touch += 1
            reached[other] = total
            arrival[other] = k
            _push(queue, state, max(int((estimate - base) / width), bucket), other, total)
    return best, expanded, touch, queue


@njit(cache=True)
def _trace(links: Links, start: int, goal: int, arrival: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Nodes and headings of the path, followed back from the goal."""
    count = 1
    node = goal
    while node != start:
        node = neighbour(links, node, (arrival[node] + 4) % 8)
        count += 1
    nodes = np.empty(count, dtype=np.int32)
    headings = np.empty(count - 1, dtype=np.uint8)
    node = goal
    for i in range(count - 1, 0, -1):
        nodes[i] = node
        headings[i - 1] = arrival[node]
        node = neighbour(links, node, (arrival[node] + 4) % 8)
    nodes[0] = start
    return nodes, headings
