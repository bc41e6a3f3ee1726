"""The surroundings of a start or goal, where social cost is waived.

They are the nodes within the exemption radius at the price of going there without social cost: the length, plus
epsilon for every step off the social graph. So what lies behind a wall is not among them, and no way to one of them is
cheaper than the one that stays among them. A cheapest path therefore leaves the start's surroundings once and enters
the goal's once, and between the two every edge costs what it always costs. So bounds need to know nothing of ends.
"""

from typing import NamedTuple, Tuple

import numpy as np
from numba import njit

from social_fleet.planning.grid_search.buckets import Queue, clear, holds, pop, push, roomy
from social_fleet.planning.grid_search.memory import FORWARD, Memory, note
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
             queue: Queue) -> Tuple[np.ndarray, np.ndarray, Queue]:
    """Dijkstra from a start (FORWARD) or to a goal (BACKWARD) as far as the radius; `memory` learns the ways.

    Returns
    -------
    (inner, rim, queue)
        Nodes of the surroundings, the nodes outside that one exempt edge joins to them (without surroundings the end
        itself), and the queue, perhaps grown.
    """
    found, count, bucket = np.empty(512, dtype=np.int32), 1, 0
    width = 0.5 * links.lengths[0]
    clear(queue)
    note(memory, side, end, 0.0, 0)
    push(queue, 0, 0, end, 0.0)
    found[0] = end
    while queue.used[0] > 0:
        if not holds(queue, 0, bucket):
            bucket += 1
            continue
        entry = pop(queue, 0, bucket)
        node, cost = np.int64(queue.node[entry]), queue.cost[entry]
        if cost > memory.reached[side, node] or cost > waiver.radius:
            continue
        queue = roomy(queue, 8)
        if count + 8 > len(found):
            found = np.concatenate((found, found))
        above, below = np.int64(links.up[node]), np.int64(links.down[node])
        around = (node + 1, above + 1, above, above - 1, node - 1, below - 1, below, below + 1)
        edges = links.edges[node]
        for k in range(8):
            if not edges >> k & 1:
                continue
            other = around[k]
            heading = k if side == FORWARD else (k + 4) & 7
            total = cost + links.lengths[k]
            if len(waiver.graph) and not waiver.graph[node if side == FORWARD else other] >> heading & 1:
                total += waiver.epsilon
            known = memory.reached[side, other]
            if total < known:
                if known == np.inf:
                    found[count] = other
                    count += 1
                note(memory, side, other, total, heading)
                push(queue, 0, int(total / width), other, total)
    return _split(memory.reached[side], found[:count], waiver.radius, queue)


@njit(cache=True, nogil=True)
def _split(reached: np.ndarray, found: np.ndarray, radius: float,
           queue: Queue) -> Tuple[np.ndarray, np.ndarray, Queue]:
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
    return inner[:inside], rim[:outside], queue
