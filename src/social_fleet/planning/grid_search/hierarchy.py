"""Exact distances from anywhere to a goal, a few hundred additions each: the customised hierarchy.

On the skeleton of `dissection`, every arc gets the cost of the cheapest way between its ends over lower nodes, in both
directions. The cheapest way between any two nodes then climbs from one and descends to the other. Costs are float32,
and every sum is rounded down, so what the hierarchy tells never exceeds the true distance: A* may rely on it as a
lower bound, and falls short of it by parts in a million.

References
----------
Dibbelt, Strasser, Wagner: Customizable Contraction Hierarchies. ACM JEA 21 (2016), doi:10.1145/2886843.
Strasser, Zeitz: A Fast and Tight Heuristic for A* in Road Networks. SEA 2021, doi:10.4230/LIPIcs.SEA.2021.6.
"""

from typing import NamedTuple, Tuple

import numpy as np
from numba import njit

from social_fleet.planning.grid_search.dissection import Skeleton
from social_fleet.planning.lattice import Links, neighbour

ROUND_DOWN = np.float32(1.0 - 2.0 ** -22)  # more than what two roundings to float32 can add


class Hierarchy(NamedTuple):
    """A skeleton with costs: of every arc upwards (low to high) and downwards, (A,) float32 [m]."""

    skeleton: Skeleton
    up: np.ndarray
    down: np.ndarray


class Potentials(NamedTuple):
    """Distances to one goal as far as they were asked for.

    Attributes
    ----------
    distance : (N,) float64 array
        By rank [m]; valid where `known` holds the number of the present goal.
    known : (N,) int32 array
        See above.
    goal : (1,) int32 array
        Number of the present goal.
    stack : (N,) int32 array
        Scratch.
    """

    distance: np.ndarray
    known: np.ndarray
    goal: np.ndarray
    stack: np.ndarray


def customised(links: Links, skeleton: Skeleton, social: np.ndarray) -> Hierarchy:
    """The hierarchy of a lattice with given social costs (N, 8) [m], infinite where there is no edge."""
    up = np.full(len(skeleton.heads), np.inf, dtype=np.float32)
    down = up.copy()
    _enter_edges(links, skeleton, social, up, down)
    lower, tails = _lower_arcs(skeleton)
    _enter_triangles(skeleton, lower, tails, up, down)
    return Hierarchy(skeleton, up, down)


def no_hierarchy() -> Hierarchy:
    """One without arcs, for searches that have to do without."""
    nothing = np.zeros(0, dtype=np.int32)
    return Hierarchy(Skeleton(nothing, nothing, np.zeros(1, dtype=np.int64), nothing),
                     np.zeros(0, dtype=np.float32), np.zeros(0, dtype=np.float32))


def new_potentials(nodes: int) -> Potentials:
    """Potentials of no goal yet."""
    return Potentials(np.empty(nodes), np.zeros(nodes, dtype=np.int32), np.zeros(1, dtype=np.int32),
                      np.empty(nodes, dtype=np.int32))


@njit(cache=True, nogil=True)
def _enter_edges(links: Links, skeleton: Skeleton, social: np.ndarray, up: np.ndarray, down: np.ndarray) -> None:
    """Give arcs between neighbours the cost of the edges between them."""
    for node in range(len(links.row)):
        tail = skeleton.rank[node]
        for k in range(8):
            if not links.edges[node] >> k & 1:
                continue
            head = skeleton.rank[neighbour(links, node, k)]
            cost = np.float32(links.lengths[k] + social[node, k]) * ROUND_DOWN
            low, high = min(tail, head), max(tail, head)
            begin, end = skeleton.first[low], skeleton.first[low + 1]
            arc = begin + np.searchsorted(skeleton.heads[begin:end], high)
            if tail < head:
                up[arc] = cost
            else:
                down[arc] = cost


@njit(cache=True, nogil=True)
def _lower_arcs(skeleton: Skeleton) -> Tuple[np.ndarray, np.ndarray]:
    """The arcs that lead to each rank, one rank after the other, and where each rank's begin."""
    count = len(skeleton.parent)
    begin = np.zeros(count + 1, dtype=np.int64)
    for head in skeleton.heads:
        begin[head + 1] += 1
    for rank in range(count):
        begin[rank + 1] += begin[rank]
    arcs = np.empty(len(skeleton.heads), dtype=np.int32)
    place = begin.copy()
    for tail in range(count):
        for arc in range(skeleton.first[tail], skeleton.first[tail + 1]):
            head = skeleton.heads[arc]
            arcs[place[head]] = arc
            place[head] += 1
    return arcs, begin


@njit(cache=True, nogil=True)
def _enter_triangles(skeleton: Skeleton, lower: np.ndarray, begin: np.ndarray, up: np.ndarray,
                     down: np.ndarray) -> None:
    """From the lowest on, let arcs x-y take the way over every lower node v that has arcs to both."""
    count = len(skeleton.parent)
    arc_to = np.zeros(count, dtype=np.int64)
    tail_end = np.empty(len(skeleton.heads), dtype=np.int32)
    for v in range(count):
        tail_end[skeleton.first[v]:skeleton.first[v + 1]] = skeleton.first[v + 1]
    for x in range(count):
        for arc in range(skeleton.first[x], skeleton.first[x + 1]):
            arc_to[skeleton.heads[arc]] = arc
        for index in range(begin[x], begin[x + 1]):
            vx = lower[index]
            to_x, from_x = up[vx], down[vx]
            for vy in range(vx + 1, tail_end[vx]):
                xy = arc_to[skeleton.heads[vy]]
                up[xy] = min(up[xy], (from_x + up[vy]) * ROUND_DOWN)
                down[xy] = min(down[xy], (down[vy] + to_x) * ROUND_DOWN)


@njit(cache=True, nogil=True)
def aim(hierarchy: Hierarchy, potentials: Potentials, rim: np.ndarray, remaining: np.ndarray) -> None:
    """Make the goal one that is reached over any of the nodes `rim`, from each at the cost `remaining[node]` [m]."""
    skeleton, distance, known, stack = hierarchy.skeleton, potentials.distance, potentials.known, potentials.stack
    potentials.goal[0] += 1
    goal, count = potentials.goal[0], 0
    for node in rim:
        rank = skeleton.rank[node]
        while rank >= 0 and known[rank] != goal:
            known[rank] = goal
            distance[rank] = np.inf
            stack[count] = rank
            count += 1
            rank = skeleton.parent[rank]
    for node in rim:
        rank = skeleton.rank[node]
        distance[rank] = min(distance[rank], remaining[node])
    climb = np.sort(stack[:count])
    for rank in climb:
        here = distance[rank]
        for arc in range(skeleton.first[rank], skeleton.first[rank + 1]):
            head = skeleton.heads[arc]
            distance[head] = min(distance[head], hierarchy.down[arc] + here)
    for rank in climb[::-1]:
        distance[rank] = min(distance[rank], _over_the_top(hierarchy, distance, rank))


@njit(cache=True, nogil=True)
def _over_the_top(hierarchy: Hierarchy, distance: np.ndarray, rank: int) -> float:
    """Distance to the goal by an arc upwards."""
    skeleton = hierarchy.skeleton
    best = np.inf
    for arc in range(skeleton.first[rank], skeleton.first[rank + 1]):
        best = min(best, hierarchy.up[arc] + distance[skeleton.heads[arc]])
    return best


@njit(cache=True, nogil=True)
def distance_to_goal(hierarchy: Hierarchy, potentials: Potentials, node: int) -> float:
    """Distance [m] from a node to the present goal: never more than the true one."""
    skeleton, known, goal = hierarchy.skeleton, potentials.known, potentials.goal[0]
    lowest = skeleton.rank[node]
    if known[lowest] == goal:
        return potentials.distance[lowest]
    rank, count = lowest, 0
    while rank >= 0 and known[rank] != goal:
        potentials.stack[count] = rank
        count += 1
        rank = skeleton.parent[rank]
    for index in range(count - 1, -1, -1):
        rank = potentials.stack[index]
        potentials.distance[rank] = _over_the_top(hierarchy, potentials.distance, rank)
        known[rank] = goal
    return potentials.distance[lowest]
