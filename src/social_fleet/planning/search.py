"""Searches over one lattice, optimal in Eq. 2 or Eq. 4, again and again in the same memory."""

import math
from dataclasses import dataclass
from typing import Optional

import numpy as np

from social_fleet.planning.astar import Memory, Query, Queue, search, trace
from social_fleet.planning.lattice import Lattice

BUCKETS_PER_CELL = 16  # so that a bucket holds nearly equal costs
MAX_BUCKETS = 1 << 16


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
        self.exempt = (exemption_radius / lattice.resolution) ** 2 if exemption_radius > 0.0 else -1.0  # [cells^2]
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
        query = Query(start, goal, social, no_graph, graph is not None, epsilon, self.exempt)
        memory = Memory(self._reached, self._arrival, self._touched)
        cost, expanded, touched, self._queue = search(lattice.links, self._social, query, memory, self._queue,
                                                      lattice.resolution, self._width)
        result = None
        if math.isfinite(cost):
            nodes, headings = trace(lattice.links, start, goal, self._arrival)
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
            exempt |= offset <= self.exempt
        social[exempt[:-1] | exempt[1:]] = 0.0
        if graph is not None:
            member = (graph[nodes[:-1]] >> headings & 1).astype(bool)
            social = np.where(member, 0.0, social + self._epsilon)
        return np.stack([lattice.lengths[headings], social])
