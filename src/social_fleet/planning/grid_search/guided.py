"""A* from the surroundings of a start to those of a goal, guided by lower bounds of what remains."""

from typing import Tuple

import numpy as np
from numba import njit

from social_fleet.planning.grid_search.buckets import Queue, clear, holds, pop, push, roomy
from social_fleet.planning.grid_search.exemption import Waiver, surround
from social_fleet.planning.grid_search.hierarchy import Hierarchy, Potentials, aim, distance_to_goal
from social_fleet.planning.grid_search.memory import BACKWARD, FORWARD, Memory, note
from social_fleet.planning.grid_search.plain import octile
from social_fleet.planning.lattice import Links


@njit(cache=True, nogil=True)
def bound(links: Links, hierarchy: Hierarchy, potentials: Potentials, node: int, goal: int) -> float:
    """Lower bound [m] of the cost from a node to the goal: by the hierarchy, or the octile distance without one."""
    if len(hierarchy.up):
        return distance_to_goal(hierarchy, potentials, node)
    return octile(links.row[goal] - links.row[node], links.col[goal] - links.col[node]) * links.lengths[0]


@njit(cache=True, nogil=True)
def join(memory: Memory, nodes: np.ndarray) -> Tuple[float, int]:
    """Cost of the cheapest way through one of the nodes, as both sides know it, and that node; inf and -1 for none."""
    best, middle = np.inf, -1
    for node in nodes:
        total = memory.reached[FORWARD, node] + memory.reached[BACKWARD, node]
        if total < best:
            best, middle = total, node
    return best, middle


@njit(cache=True, nogil=True)
def connect(links: Links, social: np.ndarray, hierarchy: Hierarchy, potentials: Potentials, seeds: np.ndarray,
            goal: int, best: float, memory: Memory, queue: Queue, width: float) -> Tuple[float, int, int, Queue]:
    """Search from the seeds on for a way to where the goal's side has been that is cheaper than `best`.

    Parameters
    ----------
    social : (N, 8) float32 array
        What edges cost beyond their length [m].
    seeds : (S,) int32 array
        Nodes that the start's side has reached and not expanded.
    width : float
        Of a bucket [m].

    Returns
    -------
    (float, int, int, Queue)
        The least cost and the node where both sides meet (-1: none is cheaper), expanded nodes, and the queue.
    """
    middle, expanded, bucket, waiting = -1, 0, 0, 0
    estimates = np.empty(len(seeds))
    for index in range(len(seeds)):
        node = seeds[index]
        estimates[index] = memory.reached[FORWARD, node] + bound(links, hierarchy, potentials, node, goal)
    order = np.argsort(estimates)
    base = estimates[order[0]] if len(order) else np.inf
    clear(queue)
    queue = roomy(queue, len(seeds))
    while base + bucket * width < best and (queue.used[FORWARD] > 0 or waiting < len(order)):
        while waiting < len(order) and estimates[order[waiting]] < base + (bucket + 1) * width:
            node = seeds[order[waiting]]
            push(queue, FORWARD, bucket, node, memory.reached[FORWARD, node])
            waiting += 1
        if not holds(queue, FORWARD, bucket):
            if queue.used[FORWARD] == 0 and not estimates[order[waiting]] < np.inf:
                break
            bucket += 1
            continue
        entry = pop(queue, FORWARD, bucket)
        node, cost = np.int64(queue.node[entry]), queue.cost[entry]
        if cost > memory.reached[FORWARD, node]:
            continue
        if cost + memory.reached[BACKWARD, node] < best:
            best, middle = cost + memory.reached[BACKWARD, node], node
        if memory.seen[node] >> BACKWARD & 1:
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
            total = cost + links.lengths[k] + social[node, k]
            if total >= memory.reached[FORWARD, other]:
                continue
            estimate = total + bound(links, hierarchy, potentials, other, goal)
            if estimate >= best:
                continue
            note(memory, FORWARD, other, total, k)
            push(queue, FORWARD, max(int((estimate - base) / width), bucket), other, total)
    return best, middle, expanded, queue


@njit(cache=True, nogil=True)
def cheapest(links: Links, social: np.ndarray, waiver: Waiver, hierarchy: Hierarchy, potentials: Potentials, start: int,
             goal: int, memory: Memory, queue: Queue, width: float) -> Tuple[float, int, int, np.ndarray, Queue]:
    """Search; afterwards `memory` has the way through the node where both sides meet.

    Returns
    -------
    (float, int, int, array, Queue)
        Cost [m] and meeting node (inf and -1 where there is no path), expanded nodes, the nodes of both surroundings,
        and the queue.
    """
    inner, rim, queue = surround(links, waiver, FORWARD, start, memory, queue)
    goal_inner, goal_rim, queue = surround(links, waiver, BACKWARD, goal, memory, queue)
    for node in goal_inner:
        memory.seen[node] |= np.uint8(1 << BACKWARD)
    exempt = np.concatenate((inner, goal_inner))
    near, middle = join(memory, np.concatenate((exempt, rim)))
    if len(hierarchy.up):
        aim(hierarchy, potentials, goal_rim, memory.reached[BACKWARD])
    cost, beyond, expanded, queue = connect(links, social, hierarchy, potentials, rim, goal, near, memory, queue, width)
    return cost, middle if beyond < 0 else beyond, expanded + len(exempt), exempt, queue
