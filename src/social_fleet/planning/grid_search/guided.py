"""A* from the surroundings of a start to those of a goal, guided by lower bounds of what remains."""

from typing import Tuple

import numpy as np
from numba import njit

from social_fleet.planning.grid_search.buckets import FULL, NEXT, USED, Queue, clear, pop, push
from social_fleet.planning.grid_search.exemption import Waiver, surround
from social_fleet.planning.grid_search.hierarchy import NEVER, UNIT, Hierarchy, Potentials, aim, climb
from social_fleet.planning.grid_search.memory import BACKWARD, FORWARD, Memory
from social_fleet.planning.grid_search.plain import octile
from social_fleet.planning.lattice import Links

STRAIGHT_FIRST = (0, 1, 7, 2, 6, 3, 5, 4)  # turns from the heading of arrival, in steps of 45 degrees


@njit(cache=True, nogil=True)
def cheapest(links: Links, social: np.ndarray, waiver: Waiver, hierarchy: Hierarchy, potentials: Potentials, start: int,
             goal: int, memory: Memory, queue: Queue, width: float) -> Tuple[int, int, np.ndarray]:
    """Search; afterwards `memory` has the way through the node where both sides meet.

    Parameters
    ----------
    social : (N, 8) float32 array
        What edges cost beyond their length [m].
    width : float
        Of a bucket [m].

    Returns
    -------
    (int, int, array)
        The meeting node (-1 where there is no path), expanded nodes, and the nodes of both surroundings.
    """
    inner, rim = surround(links, waiver, FORWARD, start, memory, queue)
    goal_inner, goal_rim = surround(links, waiver, BACKWARD, goal, memory, queue)
    reached, _, settled, _, _ = memory
    _, known, _, _ = potentials
    for node in goal_inner:
        settled[node] = 1
    exempt = np.concatenate((inner, goal_inner))
    near, middle = _join(reached[FORWARD], reached[BACKWARD], np.concatenate((inner, rim)))
    if len(known):
        aim(hierarchy, potentials, goal_rim, reached[BACKWARD])
    beyond, expanded = _connect(links, social, hierarchy, potentials, rim, goal, near, memory, queue, width)
    return middle if beyond < 0 else beyond, expanded + len(exempt), exempt


@njit(cache=True, nogil=True)
def _join(forward: np.ndarray, backward: np.ndarray, nodes: np.ndarray) -> Tuple[float, int]:
    """Cost of the cheapest way through a node that both sides have reached, and that node; inf and -1 for none."""
    best, middle = np.inf, -1
    for node in nodes:
        total = forward[node] + backward[node]
        if total < best:
            best, middle = total, node
    return best, middle


@njit(cache=True, nogil=True)
def _connect(links: Links, social: np.ndarray, hierarchy: Hierarchy, potentials: Potentials, seeds: np.ndarray,
             goal: int, best: float, memory: Memory, queue: Queue, width: float) -> Tuple[int, int]:
    """Go on from the start's rim `seeds` to where the goal's side has been, if that can be done for less than `best`.

    Returns the node where both sides meet (-1: none is cheaper) and the number of expanded nodes.
    """
    row, col, up, down, edges_of, lengths = links
    (rank_of, parent, first, arc_heads), arc_up, _ = hierarchy
    distance, known, goal_number, stack = potentials
    aimed, number = len(known) > 0, goal_number[0]
    all_reached, all_arrival, settled, all_touched, all_noted = memory
    reached, onward = all_reached[FORWARD], all_reached[BACKWARD]
    arrival, touched, noted = all_arrival[FORWARD], all_touched[FORWARD], all_noted[FORWARD]
    heads, entry_node, entry_cost, below, state = queue
    goal_row, goal_col = row[goal], col[goal]
    estimates = np.empty(len(seeds))
    for index in range(len(seeds)):
        node = seeds[index]
        if aimed:
            units = climb(rank_of[node], parent, first, arc_heads, arc_up, distance, known, number, stack)
            remaining = units * UNIT if units < NEVER else np.inf
        else:
            remaining = octile(lengths[0], lengths[1], row[node] - goal_row, col[node] - goal_col)
        estimates[index] = reached[node] + remaining
    order = np.argsort(estimates)
    base = estimates[order[0]] if len(order) else np.inf
    middle, expanded, bucket, waiting = -1, 0, 0, 0
    clear(heads, state)
    if len(seeds) > len(entry_node):
        state[FULL] = 1
        return middle, expanded
    while base + bucket * width < best and (state[USED] > 0 or waiting < len(order)):
        ready = waiting
        while ready < len(order) and estimates[order[ready]] < base + (bucket + 1) * width:
            ready += 1
        for index in range(ready - 1, waiting - 1, -1):  # so that the best is on top
            node = seeds[order[index]]
            push(heads, entry_node, entry_cost, below, state, bucket, node, reached[node])
        waiting = ready
        entry = pop(heads, below, state, bucket)
        if entry < 0:
            if state[USED] == 0 and not estimates[order[waiting]] < np.inf:
                break
            bucket += 1
            continue
        node, cost = np.int64(entry_node[entry]), entry_cost[entry]
        if cost > reached[node]:
            continue
        if cost + onward[node] < best:
            best, middle = cost + onward[node], node
        if settled[node]:
            continue
        expanded += 1
        if state[NEXT] + 9 + len(order) - waiting > len(entry_node):
            state[FULL] = 1
            break
        over, under = np.int64(up[node]), np.int64(down[node])
        around = (node + 1, over + 1, over, over - 1, node - 1, under - 1, under, under + 1)
        edges, ahead = edges_of[node], arrival[node]
        for turn in STRAIGHT_FIRST:
            k = (ahead + turn) & 7
            if not edges >> k & 1:
                continue
            other = around[k]
            total = cost + lengths[k] + social[node, k]
            if total >= reached[other]:
                continue
            if aimed:
                rank = rank_of[other]
                remaining = UNIT * (distance[rank] if known[rank] == number else climb(
                    rank, parent, first, arc_heads, arc_up, distance, known, number, stack))
            else:
                remaining = octile(lengths[0], lengths[1], row[other] - goal_row, col[other] - goal_col)
            estimate = total + remaining
            if estimate >= best:
                continue
            if reached[other] == np.inf:
                touched[noted] = other
                noted += 1
            reached[other] = total
            arrival[other] = k
            if estimate <= base:
                # No way can be cheaper than this one, so the node's other edges wait until it proves longer.
                push(heads, entry_node, entry_cost, below, state, bucket, node, cost)
                push(heads, entry_node, entry_cost, below, state, bucket, other, total)
                break
            push(heads, entry_node, entry_cost, below, state, max(int((estimate - base) / width), bucket), other, total)
    all_noted[FORWARD] = noted
    return middle, expanded
