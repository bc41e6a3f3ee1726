"""The surroundings of a start or goal, where social cost is waived.

They are the nodes within the exemption radius at the price of going there without social cost: the length, plus
epsilon for every step off the social graph. So what lies behind a wall is not among them, and no way to one of them is
cheaper than the one that stays among them. A cheapest path therefore leaves the start's surroundings once and enters
the goal's once, and between the two every edge costs what it always costs. So bounds need to know nothing of ends.
"""

from typing import NamedTuple, Tuple

import numpy as np
from numba import njit

from social_fleet.planning.grid_search.buckets import FULL, NEXT, USED, Queue, clear, pop, push
from social_fleet.planning.grid_search.memory import FORWARD, Memory
from social_fleet.planning.lattice import Links


class Waiver(NamedTuple):
    """What is waived: social cost within `radius` [m] of an end, negative for nowhere.

    `graph` (N,) uint8 is the social graph by node, empty for none; `epsilon` [m] the extra cost of an edge outside it.
    """

    radius: float
    graph: np.ndarray
    epsilon: float


@njit(cache=True, nogil=True)
def surround(links: Links, waiver: Waiver, side: int, end: int, memory: Memory,
             queue: Queue) -> Tuple[np.ndarray, np.ndarray]:
    """Dijkstra from a start (FORWARD) or to a goal (BACKWARD) as far as the radius; `memory` learns the ways.

    Returns
    -------
    (inner, rim)
        Nodes of the surroundings, and the nodes outside that one exempt edge joins to them (without surroundings the
        end itself).
    """
    _, _, up, down, edges_of, lengths = links
    radius, graph, epsilon = waiver
    all_reached, all_arrival, _, all_touched, all_noted = memory
    reached, arrival, touched = all_reached[side], all_arrival[side], all_touched[side]
    heads, entry_node, entry_cost, below, state = queue
    width, turned, biased, bucket, noted = 0.5 * lengths[0], 4 * side, len(graph) > 0, 0, 1
    clear(heads, state)
    reached[end] = 0.0
    touched[0] = end
    push(heads, entry_node, entry_cost, below, state, 0, end, 0.0)
    while state[USED] > 0:
        entry = pop(heads, below, state, bucket)
        if entry < 0:
            bucket += 1
            continue
        node, cost = np.int64(entry_node[entry]), entry_cost[entry]
        if cost > reached[node] or cost > radius:
            continue
        if state[NEXT] + 8 > len(entry_node):
            state[FULL] = 1
            break
        over, under = np.int64(up[node]), np.int64(down[node])
        around = (node + 1, over + 1, over, over - 1, node - 1, under - 1, under, under + 1)
        edges = edges_of[node]
        for k in range(8):
            if not edges >> k & 1:
                continue
            other, heading = around[k], (k + turned) & 7
            total = cost + lengths[k]
            known = reached[other]
            if total >= known:
                continue
            if biased and not graph[node if side == FORWARD else other] >> heading & 1:
                total += epsilon
                if total >= known:
                    continue
            if known == np.inf:
                touched[noted] = other
                noted += 1
            reached[other] = total
            arrival[other] = heading
            if total <= radius:
                push(heads, entry_node, entry_cost, below, state, int(total / width), other, total)
    all_noted[side] = noted
    return _split(reached, touched[:noted], radius)


@njit(cache=True, nogil=True)
def _split(reached: np.ndarray, found: np.ndarray, radius: float) -> Tuple[np.ndarray, np.ndarray]:
    """Those within the radius, and the others."""
    inner, rim = np.empty(len(found), dtype=np.int32), np.empty(len(found), dtype=np.int32)
    inside, outside = 0, 0
    for node in found:
        if reached[node] <= radius:
            inner[inside] = node
            inside += 1
        else:
            rim[outside] = node
            outside += 1
    return inner[:inside], rim[:outside]
