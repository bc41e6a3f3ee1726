"""What a search remembers of the nodes, kept from one search to the next so that none has to clear a whole map."""

from typing import NamedTuple, Tuple

import numpy as np
from numba import njit

from social_fleet.planning.lattice import Links, neighbour

FORWARD, BACKWARD = 0, 1
# Flags of a node in `Memory.seen`, from which on its first index counts as FORWARD or BACKWARD.
TOUCHED = 4


class Memory(NamedTuple):
    """Of every node and side (from the start, towards the goal) what the search has found.

    Attributes
    ----------
    reached : (2, N) float64 array
        Cost to reach the node, or to go on from it to the goal: inf where not known, -inf where it must not be entered.
    arrival : (2, N) uint8 array
        Heading of the edge by which it was reached, or by which it is left towards the goal.
    seen : (N,) uint8 array
        Bit `side` is set when that side has expanded the node, bit 2 when it is listed in `touched`.
    touched : (N,) int32 array
        Nodes that the search has come to.
    noted : (1,) int64 array
        How many these are.
    """

    reached: np.ndarray
    arrival: np.ndarray
    seen: np.ndarray
    touched: np.ndarray
    noted: np.ndarray


def new_memory(nodes: int) -> Memory:
    """Memory for so many nodes."""
    return Memory(np.full((2, nodes), np.inf), np.zeros((2, nodes), dtype=np.uint8), np.zeros(nodes, dtype=np.uint8),
                  np.empty(nodes, dtype=np.int32), np.zeros(1, dtype=np.int64))


@njit(cache=True, nogil=True)
def note(memory: Memory, side: int, node: int, cost: float, heading: int) -> None:
    """Remember a cheaper way to a node."""
    if not memory.seen[node] & TOUCHED:
        memory.seen[node] |= np.uint8(TOUCHED)
        memory.touched[memory.noted[0]] = node
        memory.noted[0] += 1
    memory.reached[side, node] = cost
    memory.arrival[side, node] = heading


@njit(cache=True, nogil=True)
def forget(memory: Memory) -> None:
    """Make the memory as new."""
    for index in range(memory.noted[0]):
        node = memory.touched[index]
        memory.reached[FORWARD, node] = np.inf
        memory.reached[BACKWARD, node] = np.inf
        memory.seen[node] = 0
    memory.noted[0] = 0


@njit(cache=True, nogil=True)
def trace(links: Links, memory: Memory, start: int, middle: int, goal: int) -> Tuple[np.ndarray, np.ndarray]:
    """Nodes and headings of the path from start to goal through a node that both sides have reached."""
    before, after = 0, 0
    node = middle
    while node != start:
        node = neighbour(links, node, (memory.arrival[FORWARD, node] + 4) % 8)
        before += 1
    node = middle
    while node != goal:
        node = neighbour(links, node, memory.arrival[BACKWARD, node])
        after += 1
    nodes = np.empty(before + after + 1, dtype=np.int32)
    headings = np.empty(before + after, dtype=np.uint8)
    node = middle
    for i in range(before - 1, -1, -1):
        nodes[i + 1] = node
        headings[i] = memory.arrival[FORWARD, node]
        node = neighbour(links, node, (headings[i] + 4) % 8)
    nodes[0] = start
    node = middle
    for i in range(before, before + after):
        headings[i] = memory.arrival[BACKWARD, node]
        node = neighbour(links, node, headings[i])
        nodes[i + 1] = node
    return nodes, headings
