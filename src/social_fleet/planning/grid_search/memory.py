"""What a search remembers of the nodes, kept from one search to the next so that none has to clear a whole map."""

from typing import NamedTuple, Tuple

import numpy as np
from numba import njit

from social_fleet.planning.lattice import Links, step

FORWARD, BACKWARD = 0, 1


class Memory(NamedTuple):
    """Of every node and side (from the start, towards the goal) what the search has found.

    Attributes
    ----------
    reached : (2, N) float64 array
        Cost to reach the node, or to go on from it to the goal: inf where not known, -inf where it must not be entered.
    arrival : (2, N) uint8 array
        Heading of the edge by which it was reached, or by which it is left towards the goal.
    settled : (N,) uint8 array
        1 where the way on to the goal is known and final.
    touched : (2, N) int32 array
        Nodes that each side has come to.
    noted : (2,) int64 array
        How many these are.
    """

    reached: np.ndarray
    arrival: np.ndarray
    settled: np.ndarray
    touched: np.ndarray
    noted: np.ndarray


def new_memory(nodes: int) -> Memory:
    """Memory for so many nodes."""
    return Memory(np.full((2, nodes), np.inf), np.zeros((2, nodes), dtype=np.uint8), np.zeros(nodes, dtype=np.uint8),
                  np.empty((2, nodes), dtype=np.int32), np.zeros(2, dtype=np.int64))


@njit(cache=True, nogil=True)
def forget(memory: Memory) -> None:
    """Make the memory as new."""
    all_reached, _, settled, all_touched, noted = memory
    for side in range(2):
        reached, touched = all_reached[side], all_touched[side]
        for index in range(noted[side]):
            reached[touched[index]] = np.inf
            settled[touched[index]] = 0
        noted[side] = 0


@njit(cache=True, nogil=True)
def recall(links: Links, memory: Memory, start: int, middle: int, goal: int) -> Tuple[np.ndarray, np.ndarray, float]:
    """Nodes, headings and cost of the path from start to goal through a node that both sides have reached.

    With -1 for the node, or where one of the sides has not come there: no nodes, and infinite cost.
    """
    _, _, up, down, _, _ = links
    reached, arrival, _, _, _ = memory
    cost = reached[FORWARD, middle] + reached[BACKWARD, middle] if middle >= 0 else np.inf
    if not cost < np.inf:
        return np.empty(0, dtype=np.int32), np.empty(0, dtype=np.uint8), np.inf
    before = _follow(up, down, arrival[FORWARD], middle, start, 4)
    after = _follow(up, down, arrival[BACKWARD], middle, goal, 0)
    nodes = np.concatenate((before[::-1], after[1:]))
    headings = np.empty(len(nodes) - 1, dtype=np.uint8)
    for i in range(len(before) - 1):
        headings[len(before) - 2 - i] = arrival[FORWARD, before[i]]
    for i in range(len(after) - 1):
        headings[len(before) - 1 + i] = arrival[BACKWARD, after[i]]
    return nodes, headings, cost


@njit(cache=True, nogil=True)
def _follow(up: np.ndarray, down: np.ndarray, arrival: np.ndarray, node: int, end: int, turn: int) -> np.ndarray:
    """Nodes from `node` to `end` by the edges in heading `arrival` + `turn`."""
    nodes = np.empty(256, dtype=np.int32)
    nodes[0] = node
    count = 1
    while node != end:
        if count == len(nodes):
            nodes = np.concatenate((nodes, nodes))
        node = step(up, down, node, (arrival[node] + turn) & 7)
        nodes[count] = node
        count += 1
    return nodes[:count]
