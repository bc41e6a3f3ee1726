"""Plain A*: the shortest path, with the octile distance as its heuristic."""

import math
from typing import Tuple

import numpy as np
from numba import njit

from social_fleet.planning.grid_search.buckets import Queue, clear, holds, pop, push, roomy
from social_fleet.planning.grid_search.memory import FORWARD, Memory, note
from social_fleet.planning.lattice import DCOL, DROW, Links

OCTILE = math.sqrt(2.0) - 1.0


@njit(cache=True, nogil=True)
def octile(drow: int, dcol: int) -> float:
    """Length in cells of the shortest 8-connected path over an empty map."""
    drow, dcol = abs(drow), abs(dcol)
    return max(drow, dcol) + OCTILE * min(drow, dcol)


@njit(cache=True, nogil=True)
def shortest(links: Links, start: int, goal: int, memory: Memory, queue: Queue, width: float) -> Tuple[int, Queue]:
    """Search; afterwards `memory` has the way to the goal, if there is any.

    Parameters
    ----------
    width : float
        Of a bucket [m].

    Returns
    -------
    (int, Queue)
        Expanded nodes, and the queue, perhaps grown.
    """
    resolution = links.lengths[0]
    goal_row, goal_col = links.row[goal], links.col[goal]
    base = octile(goal_row - links.row[start], goal_col - links.col[start]) * resolution
    clear(queue)
    note(memory, FORWARD, start, 0.0, 0)
    push(queue, FORWARD, 0, start, 0.0)
    expanded, bucket, best = 0, 0, np.inf
    while queue.used[FORWARD] > 0:
        if not holds(queue, FORWARD, bucket):
            bucket += 1
            if base + bucket * width > best:
                break
            continue
        entry = pop(queue, FORWARD, bucket)
        node, cost = np.int64(queue.node[entry]), queue.cost[entry]
        if cost > memory.reached[FORWARD, node]:
            continue
        if node == goal:
            best = cost
            continue
        r, c = links.row[node], links.col[node]
        if cost + octile(r - goal_row, c - goal_col) * resolution >= best:
            continue
        expanded += 1
        queue = roomy(queue, 8)
        above, below = np.int64(links.up[node]), np.int64(links.down[node])
        around = (node + 1, above + 1, above, above - 1, node - 1, below - 1, below, below + 1)
        edges = links.edges[node]
        for k in range(8):
            if not edges >> k & 1:
                continue
            other = around[k]
            total = cost + links.lengths[k]
            if total >= memory.reached[FORWARD, other]:
                continue
            estimate = total + octile(r + DROW[k] - goal_row, c + DCOL[k] - goal_col) * resolution
            if estimate >= best:
                continue
            note(memory, FORWARD, other, total, k)
            push(queue, FORWARD, max(int((estimate - base) / width), bucket), other, total)
    return expanded, queue
