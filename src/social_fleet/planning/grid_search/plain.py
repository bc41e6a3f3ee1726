"""Plain A*: the shortest path, with the octile distance as its heuristic."""

import numpy as np
from numba import njit

from social_fleet.planning.grid_search.buckets import FULL, NEXT, USED, Queue, clear, pop, push
from social_fleet.planning.grid_search.memory import BACKWARD, FORWARD, Memory
from social_fleet.planning.lattice import DCOL, DROW, Links


@njit(cache=True, nogil=True)
def octile(straight: float, diagonal: float, drow: int, dcol: int) -> float:
    """Length of the shortest 8-connected path over an empty map, with edges of these two lengths."""
    drow, dcol = abs(drow), abs(dcol)
    return straight * abs(drow - dcol) + diagonal * min(drow, dcol)


@njit(cache=True, nogil=True)
def shortest(links: Links, start: int, goal: int, memory: Memory, queue: Queue, width: float) -> int:
    """Search with buckets of a `width` [m]: afterwards `memory` has the way to the goal, if there is any.

    Returns the number of expanded nodes.
    """
    row, col, up, down, edges_of, lengths = links
    all_reached, all_arrival, _, all_touched, all_noted = memory
    reached, arrival, touched = all_reached[FORWARD], all_arrival[FORWARD], all_touched[FORWARD]
    heads, entry_node, entry_cost, below, state = queue
    straight, diagonal = lengths[0], lengths[1]
    goal_row, goal_col = row[goal], col[goal]
    base = octile(straight, diagonal, goal_row - row[start], goal_col - col[start])
    clear(heads, state)
    reached[start] = 0.0
    touched[0] = start
    push(heads, entry_node, entry_cost, below, state, 0, start, 0.0)
    expanded, bucket, noted, best = 0, 0, 1, np.inf
    while state[USED] > 0:
        entry = pop(heads, below, state, bucket)
        if entry < 0:
            bucket += 1
            if base + bucket * width > best:
                break
            continue
        node, cost = np.int64(entry_node[entry]), entry_cost[entry]
        if cost > reached[node]:
            continue
        if node == goal:
            best = cost
            continue
        r, c = row[node] - goal_row, col[node] - goal_col
        if cost + octile(straight, diagonal, r, c) >= best:
            continue
        expanded += 1
        if state[NEXT] + 8 > len(entry_node):
            state[FULL] = 1
            break
        over, under = np.int64(up[node]), np.int64(down[node])
        around = (node + 1, over + 1, over, over - 1, node - 1, under - 1, under, under + 1)
        edges = edges_of[node]
        for k in range(8):
            if not edges >> k & 1:
                continue
            other = around[k]
            total = cost + (diagonal if k & 1 else straight)
            known = reached[other]
            if total >= known:
                continue
            estimate = total + octile(straight, diagonal, r + DROW[k], c + DCOL[k])
            if estimate >= best:
                continue
            if known == np.inf:
                touched[noted] = other
                noted += 1
            reached[other] = total
            arrival[other] = k
            push(heads, entry_node, entry_cost, below, state, max(int((estimate - base) / width), bucket), other, total)
    all_noted[FORWARD] = noted
    all_reached[BACKWARD, goal] = 0.0
    all_touched[BACKWARD, 0] = goal
    all_noted[BACKWARD] = 1
    return expanded
