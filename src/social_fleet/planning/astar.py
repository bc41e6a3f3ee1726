"""A* as a kernel: the queue is a ring of buckets.

Within a bucket the last entry comes first, and a node is expanded again when a cheaper way to it turns up. So the order
inside a bucket affects time, not the result: the search ends when every entry left is dearer than the best path.
"""

import math
from typing import NamedTuple, Tuple

import numpy as np
from numba import njit

from social_fleet.planning.lattice import DCOL, DROW, Links, neighbour

OCTILE = math.sqrt(2.0) - 1.0


class Query(NamedTuple):
    """One search: `exempt` is the squared radius [cells^2] about start and goal without social cost; negative: none."""

    start: int
    goal: int
    social: bool
    graph: np.ndarray
    has_graph: bool
    epsilon: float
    exempt: float


class Memory(NamedTuple):
    """Of every node the cost to reach it (inf where it wasn't, -inf where it must not be) and the heading of arrival.

    `touched` lists the nodes that a search has reached.
    """

    reached: np.ndarray
    arrival: np.ndarray
    touched: np.ndarray


class Queue(NamedTuple):
    """Buckets as linked lists: the top entry of each, and of every entry its node, its cost and the entry below."""

    heads: np.ndarray
    node: np.ndarray
    cost: np.ndarray
    below: np.ndarray


@njit(cache=True)
def octile(drow: int, dcol: int) -> float:
    """Length in cells of the shortest 8-connected path over an empty map."""
    drow, dcol = abs(drow), abs(dcol)
    return max(drow, dcol) + OCTILE * min(drow, dcol)


@njit(cache=True)
def _push(queue: Queue, state: np.ndarray, bucket: int, node: int, cost: float) -> None:
    """Put a node into a bucket; there must be room. `state`: next unused entry, first spare entry, entries in use."""
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
def search(links: Links, social: np.ndarray, query: Query, memory: Memory, queue: Queue, resolution: float,
           width: float) -> Tuple[float, int, int, Queue]:
    """Returns the cost (inf where there is no path), expanded and touched nodes, and the queue, perhaps grown."""
    reached, arrival, touched = memory
    state = np.array([0, -1, 0])
    mask = len(queue.heads) - 1
    queue.heads[:] = -1
    goal_row, goal_col = links.row[query.goal], links.col[query.goal]
    # One step from the exempt disc an edge may still have an end in it.
    margin = (math.sqrt(query.exempt) + 1.5) ** 2 if query.exempt >= 0.0 else -1.0
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
def trace(links: Links, start: int, goal: int, arrival: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
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
