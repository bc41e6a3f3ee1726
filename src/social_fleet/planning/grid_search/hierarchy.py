"""Exact distances from anywhere to a goal, a few hundred additions each: the customised hierarchy.

On the skeleton of `dissection`, every arc gets the cost of the cheapest way between its ends over lower nodes, in both
directions. The cheapest way between any two nodes then climbs from one and descends to the other. Costs are whole
numbers of `UNIT`, so sums are exact, up to four kilometres; what is dearer counts as that, a lower bound.

References
----------
Dibbelt, Strasser, Wagner: Customizable Contraction Hierarchies. ACM JEA 21 (2016), doi:10.1145/2886843.
Strasser, Zeitz: A Fast and Tight Heuristic for A* in Road Networks. SEA 2021, doi:10.4230/LIPIcs.SEA.2021.6.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from social_fleet.planning.grid_search.dissection import Skeleton
from social_fleet.planning.lattice import Links, step

UNIT = 2.0 ** -20  # [m], about a micrometre
DEAREST = 2 ** 32 - 1  # [UNIT], of an arc
NEVER = 2 ** 60  # [UNIT], the distance from where there is no way


class Hierarchy(NamedTuple):
    """A skeleton with costs: of every arc upwards (low to high) and downwards, (A,) uint32 [UNIT]."""

    skeleton: Skeleton
    up: np.ndarray
    down: np.ndarray


class Potentials(NamedTuple):
    """Distances to one goal as far as they were asked for.

    Attributes
    ----------
    distance : (N,) int64 array
        By rank [UNIT]; valid where `known` holds the number of the present goal.
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
    up = np.full(len(skeleton.heads), DEAREST, dtype=np.uint32)
    down = up.copy()
    _enter_edges(links, skeleton, social, up, down)
    _enter_triangles(skeleton, up, down)
    return Hierarchy(skeleton, up, down)


def no_hierarchy() -> Hierarchy:
    """One without arcs, for searches that have to do without."""
    nothing = np.zeros(0, dtype=np.int32)
    return Hierarchy(Skeleton(nothing, nothing, np.zeros(1, dtype=np.int64), nothing),
                     np.zeros(0, dtype=np.uint32), np.zeros(0, dtype=np.uint32))


def new_potentials(nodes: int) -> Potentials:
    """Potentials of no goal yet."""
    return Potentials(np.empty(nodes, dtype=np.int64), np.zeros(nodes, dtype=np.int32), np.zeros(1, dtype=np.int32),
                      np.empty(nodes, dtype=np.int32))


@njit(cache=True, nogil=True)
def _enter_edges(links: Links, skeleton: Skeleton, social: np.ndarray, up: np.ndarray, down: np.ndarray) -> None:
    """Give arcs between neighbours the cost of the edges between them."""
    _, _, over, under, edges_of, lengths = links
    rank_of, _, first, heads = skeleton
    for node in range(len(rank_of)):
        tail = rank_of[node]
        for k in range(8):
            if not edges_of[node] >> k & 1:
                continue
            head = rank_of[step(over, under, node, k)]
            cost = np.uint32(min(round((lengths[k] + social[node, k]) / UNIT), DEAREST))
            low, high = min(tail, head), max(tail, head)
            arc = first[low] + np.searchsorted(heads[first[low]:first[low + 1]], high)
            if tail < head:
                up[arc] = cost
            else:
                down[arc] = cost


@njit(cache=True, nogil=True)
def _enter_triangles(skeleton: Skeleton, up: np.ndarray, down: np.ndarray) -> None:
    """From the lowest on, let arcs x-y take the way over every lower node v that has arcs to both."""
    _, parent, first, heads = skeleton
    arc_to = np.zeros(len(parent), dtype=np.int64)  # by head: the arc from x to it
    # Every v waits, in a list of x, for the x that its arc `turn` leads to.
    turn = first[:-1].copy()
    waiting, behind = np.full(len(parent), -1, dtype=np.int32), np.full(len(parent), -1, dtype=np.int32)
    for x in range(len(parent)):
        for arc in range(first[x], first[x + 1]):
            arc_to[heads[arc]] = arc
        v = waiting[x]
        while v >= 0:
            following, vx = behind[v], turn[v]
            to_x, from_x = np.int64(up[vx]), np.int64(down[vx])
            for vy in range(vx + 1, first[v + 1]):
                xy = arc_to[heads[vy]]
                up[xy] = min(np.int64(up[xy]), from_x + up[vy])
                down[xy] = min(np.int64(down[xy]), down[vy] + to_x)
            turn[v] += 1
            _queue_up(v, turn, first, heads, waiting, behind)
            v = following
        _queue_up(x, turn, first, heads, waiting, behind)


@njit(cache=True, nogil=True)
def _queue_up(v: int, turn: np.ndarray, first: np.ndarray, heads: np.ndarray, waiting: np.ndarray,
              behind: np.ndarray) -> None:
    """Put v into the list of the rank that its next arc leads to, if it has one."""
    if turn[v] < first[v + 1]:
        head = heads[turn[v]]
        behind[v] = waiting[head]
        waiting[head] = v


@njit(cache=True, nogil=True)
def aim(hierarchy: Hierarchy, potentials: Potentials, rim: np.ndarray, remaining: np.ndarray) -> None:
    """Make the goal one that is reached over any of the nodes `rim`, from each at the cost `remaining[node]` [m]."""
    (rank_of, parent, first, heads), up, down = hierarchy
    distance, known, number, stack = potentials
    number[0] += 1
    goal, count = number[0], 0
    for node in rim:
        rank = rank_of[node]
        while rank >= 0 and known[rank] != goal:
            known[rank] = goal
            distance[rank] = NEVER
            stack[count] = rank
            count += 1
            rank = parent[rank]
    for node in rim:
        rank = rank_of[node]
        distance[rank] = min(distance[rank], np.int64(remaining[node] / UNIT))
    ascending = np.sort(stack[:count])
    for rank in ascending:
        here = distance[rank]
        for arc in range(first[rank], first[rank + 1]):
            head = heads[arc]
            distance[head] = min(distance[head], np.int64(down[arc]) + here)
    for rank in ascending[::-1]:
        best = distance[rank]
        for arc in range(first[rank], first[rank + 1]):
            best = min(best, np.int64(up[arc]) + distance[heads[arc]])
        distance[rank] = best


@njit(cache=True, nogil=True)
def climb(rank: int, parent: np.ndarray, first: np.ndarray, heads: np.ndarray, up: np.ndarray, distance: np.ndarray,
          known: np.ndarray, goal: int, stack: np.ndarray) -> int:
    """Distance [UNIT] from a rank to the present goal; the arrays are those of `Hierarchy` and `Potentials`."""
    count, higher = 0, rank
    while higher >= 0 and known[higher] != goal:
        stack[count] = higher
        count += 1
        higher = parent[higher]
    for index in range(count - 1, -1, -1):
        lower = stack[index]
        best = np.int64(NEVER)
        for arc in range(first[lower], first[lower + 1]):
            best = min(best, np.int64(up[arc]) + distance[heads[arc]])
        distance[lower] = best
        known[lower] = goal
    return distance[rank]


def distance_to_goal(hierarchy: Hierarchy, potentials: Potentials, node: int) -> float:
    """Distance [m] from a node to the present goal, inf where there is no way."""
    _, parent, first, heads = hierarchy.skeleton
    units = climb(hierarchy.skeleton.rank[node], parent, first, heads, hierarchy.up, potentials.distance,
                  potentials.known, potentials.goal[0], potentials.stack)
    return float(units) * UNIT if units < NEVER else np.inf
