"""Searches over one lattice, optimal in Eq. 2 or Eq. 4, again and again in the same memory."""

import math
from dataclasses import dataclass, field
from typing import Any, Callable, Dict, Optional, Tuple

import numpy as np
from numba import njit

from social_fleet.planning import lattice as lattices
from social_fleet.planning.cache import cached, digest_of, source_of
from social_fleet.planning.grid_search import dissection, hierarchy
from social_fleet.planning.grid_search.buckets import FULL, new_queue
from social_fleet.planning.grid_search.dissection import Skeleton, dissect
from social_fleet.planning.grid_search.exemption import Waiver
from social_fleet.planning.grid_search.guided import cheapest
from social_fleet.planning.grid_search.hierarchy import (
    UNIT, Hierarchy, customised, new_potentials, no_hierarchy)
from social_fleet.planning.grid_search.memory import forget, new_memory, recall
from social_fleet.planning.grid_search.plain import shortest
from social_fleet.planning.lattice import Lattice

BUCKETS_PER_CELL = 16  # so that a bucket holds nearly equal costs
MAX_BUCKETS = 1 << 16
# What is cached is computed with these; when one of them changes, it does not hold any more.
_SKELETON_SOURCES = (lattices, dissection)
_HIERARCHY_SOURCES = (*_SKELETON_SOURCES, hierarchy)


def _no_nodes() -> np.ndarray:
    return np.zeros(0, dtype=np.int32)


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
    exempt : (E,) int32 array
        Nodes whose edges bear no social cost, being near the start or the goal.
    """

    nodes: np.ndarray
    headings: np.ndarray
    cost: float
    expanded: int
    exempt: np.ndarray = field(default_factory=_no_nodes)


@dataclass(frozen=True)
class Metric:
    """What edges cost: Eq. 2, or Eq. 4 with a social graph.

    Attributes
    ----------
    social : (N, 8) float32 array
        Cost of every edge beyond its length [m], infinite where there is none.
    waiver : Waiver
        Where social cost is waived.
    hierarchy : Hierarchy
        Tells exact distances, so that a search goes straight to its goal; empty for none.
    """

    social: np.ndarray
    waiver: Waiver
    hierarchy: Hierarchy

    @property
    def prepared(self) -> bool:
        """Whether there is a hierarchy."""
        return len(self.hierarchy.up) > 0


class Search:
    """Searches one lattice again and again in the same memory; not for several threads at once.

    Lengths and costs of edges are rounded to whole `UNIT`s (a micrometre), so that sums are exact in any order.

    Parameters
    ----------
    lattice : Lattice
        The graph.
    social : (N, 8) float32 array
        Social cost of every edge, infinite where there is none.
    exemption_radius : float
        Edges with an end this close [m] to start or goal, as one drives there, bear no social cost; see `exemption`.
    epsilon : float
        Extra cost [m] of an edge outside the social graph.

    Attributes
    ----------
    social : (N, 8) float32 array
        Social cost of every edge in whole units.
    """

    def __init__(self, lattice: Lattice, social: np.ndarray, *, exemption_radius: float = 0.0,
                 epsilon: float = 0.0) -> None:
        self._lattice = lattice
        self._links = lattice.links._replace(lengths=_whole_units(lattice.lengths))
        self.social = _whole_units(social)
        self._radius = exemption_radius if exemption_radius > 0.0 else -1.0
        self._epsilon = float(_whole_units(np.array(epsilon)))
        self._skeleton: Optional[Skeleton] = None
        dearest = float(np.max(social, where=np.isfinite(social), initial=0.0)) + epsilon
        # From one node to the next an estimate grows by no more than the edge there and back.
        span = 2.0 * (lattice.lengths.max() + dearest)
        self._width = max(lattice.resolution / BUCKETS_PER_CELL, span / (MAX_BUCKETS - 4))
        self._queue = new_queue(1 << math.ceil(math.log2(span / self._width + 4.0)))
        self._memory = new_memory(len(lattice))
        self._potentials, self._no_potentials = new_potentials(len(lattice)), new_potentials(0)

    def metric(self, graph: Optional[np.ndarray] = None, *, prepared: bool = False) -> Metric:
        """What edges cost with a social graph. Does not disturb a search that another thread runs.

        Parameters
        ----------
        graph : (N,) uint8 array, optional
            Social graph: bit k of a node is set where its edge in heading k belongs to it.
        prepared : bool
            Spend a few microseconds per node on a hierarchy that makes every search with this metric fast.
        """
        social, waiver = self.social, Waiver(self._radius, np.zeros(0, dtype=np.uint8), 0.0)
        if graph is not None:
            social, waiver = _with_graph(social, graph, self._epsilon), Waiver(self._radius, graph, self._epsilon)
        if not prepared or not len(self._lattice):
            return Metric(social, waiver, no_hierarchy())
        return Metric(social, waiver, self._hierarchy(social))

    def _hierarchy(self, social: np.ndarray) -> Hierarchy:
        """For any costs; that for Eq. 2 is kept on disk."""
        links = self._links
        if self._skeleton is None:
            digest = digest_of(links.row, links.col, links.edges, source_of(*_SKELETON_SOURCES))
            arrays = cached("skeleton", digest, lambda: dissect(links)._asdict())
            self._skeleton = Skeleton(**arrays)
        skeleton = self._skeleton
        if social is not self.social:
            return customised(links, skeleton, social)
        digest = digest_of(links.row, links.col, links.edges, links.lengths, social, source_of(*_HIERARCHY_SOURCES))
        arrays = cached("hierarchy", digest, lambda: _costs_of(customised(links, skeleton, social)))
        return Hierarchy(skeleton, **arrays)

    def shortest(self, start: int, goal: int, *, closed: Optional[np.ndarray] = None) -> Optional[SearchResult]:
        """The shortest path between two nodes by plain A*, without social cost. See `cheapest`."""
        return self._run(_shortest, start, goal, closed, *self._links)

    def cheapest(self, start: int, goal: int, metric: Metric, *,
                 closed: Optional[np.ndarray] = None) -> Optional[SearchResult]:
        """The path between two nodes that is cheapest in a metric.

        Parameters
        ----------
        start, goal : int
            Nodes.
        metric : Metric
            What edges cost.
        closed : (M,) int array, optional
            Nodes that this search must not enter.

        Returns
        -------
        SearchResult or None
            None when the goal cannot be reached.
        """
        potentials = self._potentials if metric.prepared else self._no_potentials
        skeleton, up, down = metric.hierarchy
        return self._run(_cheapest, start, goal, closed, *self._links, metric.social, *metric.waiver, *skeleton, up,
                         down, *potentials)

    def _run(self, kernel: Callable[..., Tuple[np.ndarray, np.ndarray, float, int, np.ndarray]], start: int, goal: int,
             closed: Optional[np.ndarray], *given: Any) -> Optional[SearchResult]:
        """Run a kernel, again with a larger queue where it was too small."""
        reached, queue = self._memory.reached, self._queue
        if closed is not None:
            reached[:, closed] = -np.inf
        while True:
            queue.state[FULL] = 0
            found = kernel(start, goal, self._width, *self._memory, *queue, *given)
            if not queue.state[FULL]:
                break
            queue = self._queue = new_queue(len(queue.heads), 2 * len(queue.node))
        if closed is not None:
            reached[:, closed] = np.inf
        return SearchResult(*found) if math.isfinite(found[2]) else None

    def evaluate(self, result: SearchResult, metric: Optional[Metric] = None) -> np.ndarray:
        """Length and cost beyond it [m] of each step, by default in Eq. 2, exemption included: shape (2, M - 1)."""
        social, graph = (metric.social, metric.waiver.graph) if metric else (self.social, np.zeros(0, dtype=np.uint8))
        memory = self._memory
        memory.settled[result.exempt] = 1
        steps = _evaluate(self._links.lengths, social, graph, self._epsilon, result.nodes, result.headings,
                          memory.settled)
        memory.settled[result.exempt] = 0
        return steps


# What Python calls has its arrays one by one, for Numba takes longer to recognise tuples of them than to search.


@njit(cache=True, nogil=True)
def _shortest(start: int, goal: int, width: float,
              reached: np.ndarray, arrival: np.ndarray, settled: np.ndarray, touched: np.ndarray, noted: np.ndarray,
              heads: np.ndarray, node: np.ndarray, cost: np.ndarray, below: np.ndarray, state: np.ndarray,
              row: np.ndarray, col: np.ndarray, up: np.ndarray, down: np.ndarray, edges: np.ndarray,
              lengths: np.ndarray) -> Tuple[np.ndarray, np.ndarray, float, int, np.ndarray]:
    """What `SearchResult` holds, by plain A*; the memory is as new afterwards."""
    links, memory = (row, col, up, down, edges, lengths), (reached, arrival, settled, touched, noted)
    expanded = shortest(links, start, goal, memory, (heads, node, cost, below, state), width)
    nodes, headings, total = recall(links, memory, start, goal, goal)
    forget(memory)
    return nodes, headings, total, expanded, np.empty(0, dtype=np.int32)


@njit(cache=True, nogil=True)
def _cheapest(start: int, goal: int, width: float,
              reached: np.ndarray, arrival: np.ndarray, settled: np.ndarray, touched: np.ndarray, noted: np.ndarray,
              heads: np.ndarray, node: np.ndarray, cost: np.ndarray, below: np.ndarray, state: np.ndarray,
              row: np.ndarray, col: np.ndarray, up: np.ndarray, down: np.ndarray, edges: np.ndarray,
              lengths: np.ndarray, social: np.ndarray, radius: float, graph: np.ndarray, epsilon: float,
              rank: np.ndarray, parent: np.ndarray, first: np.ndarray, arc_heads: np.ndarray, arc_up: np.ndarray,
              arc_down: np.ndarray, distance: np.ndarray, known: np.ndarray, number: np.ndarray,
              stack: np.ndarray) -> Tuple[np.ndarray, np.ndarray, float, int, np.ndarray]:
    """What `SearchResult` holds, in the metric given; the memory is as new afterwards."""
    links, memory = (row, col, up, down, edges, lengths), (reached, arrival, settled, touched, noted)
    hierarchy = (rank, parent, first, arc_heads), arc_up, arc_down
    middle, expanded, exempt = cheapest(links, social, (radius, graph, epsilon), hierarchy,
                                        (distance, known, number, stack), start, goal, memory,
                                        (heads, node, cost, below, state), width)
    nodes, headings, total = recall(links, memory, start, middle, goal)
    forget(memory)
    return nodes, headings, total, expanded, exempt


@njit(cache=True, nogil=True)
def _evaluate(lengths: np.ndarray, social: np.ndarray, graph: np.ndarray, epsilon: float, nodes: np.ndarray,
              headings: np.ndarray, exempt: np.ndarray) -> np.ndarray:
    """See `Search.evaluate`; `exempt` (N,) is 1 at exempt nodes."""
    steps = np.empty((2, len(headings)))
    for i in range(len(headings)):
        node, heading = nodes[i], headings[i]
        steps[0, i], steps[1, i] = lengths[heading], social[node, heading]
        if exempt[node] or exempt[nodes[i + 1]]:
            steps[1, i] = epsilon if len(graph) and not graph[node] >> heading & 1 else 0.0
    return steps


def _costs_of(hierarchy: Hierarchy) -> Dict[str, np.ndarray]:
    return {"up": hierarchy.up, "down": hierarchy.down}


def _whole_units(costs: np.ndarray) -> np.ndarray:
    """Costs [m] rounded to multiples of UNIT, which float32 and float64 hold exactly."""
    return (np.rint(costs / UNIT) * UNIT).astype(costs.dtype)


@njit(cache=True, nogil=True)
def _with_graph(social: np.ndarray, graph: np.ndarray, epsilon: float) -> np.ndarray:
    """Eq. 4 beyond length: nothing on the graph, epsilon more than Eq. 2 off it."""
    biased = np.empty_like(social)
    for node in range(len(graph)):
        for k in range(8):
            biased[node, k] = np.float32(0.0) if graph[node] >> k & 1 else np.float32(social[node, k] + epsilon)
    return biased
