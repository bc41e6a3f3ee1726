"""The order in which a lattice is taken apart, and what that leaves: the skeleton of a hierarchy, whatever the costs.

Nested dissection: a straight line of cells splits a set of nodes in two, for no edge is longer than a diagonal. Nodes
of the line come after those beside it, and both sides are split again. Taking the nodes out in this order and joining
the neighbours of each by an arc, as Gaussian elimination fills in a matrix, leaves every node with arcs to the few
nodes of the lines round it. Buildings have short lines: through doors and across corridors.

References
----------
Dibbelt, Strasser, Wagner: Customizable Contraction Hierarchies. ACM JEA 21 (2016), doi:10.1145/2886843.
"""

from typing import NamedTuple, Tuple

import numpy as np
from numba import njit

from social_fleet.planning.lattice import Links, step

LEAST_SHARE = 0.25  # of the nodes that has to lie on either side of a line


class Skeleton(NamedTuple):
    """Nodes by rank, that is in the order in which they are taken out, and the arcs from each to higher ones.

    Attributes
    ----------
    rank : (N,) int32 array
        Of every node.
    parent : (N,) int32 array
        By rank: the lowest rank that an arc leads to, -1 for none. All others that it leads to lie above that one.
    first : (N + 1,) int64 array
        By rank: where its arcs begin.
    heads : (A,) int32 array
        Rank that an arc leads to, ascending for each tail.
    """

    rank: np.ndarray
    parent: np.ndarray
    first: np.ndarray
    heads: np.ndarray


def dissect(links: Links) -> Skeleton:
    """The skeleton of a lattice."""
    order = _nested_dissection(links.row, links.col)
    rank = np.empty(len(order), dtype=np.int32)
    rank[order] = np.arange(len(order), dtype=np.int32)
    return Skeleton(rank, *_fill(links, order, rank))


@njit(cache=True, nogil=True)
def _nested_dissection(row: np.ndarray, col: np.ndarray) -> np.ndarray:
    """Nodes in order; each range of `order` that waits on the stack is split into two sides and the line after them."""
    count = len(row)
    order = np.arange(count).astype(np.int32)
    beyond, line = np.empty(count, dtype=np.int32), np.empty(count, dtype=np.int32)
    ranges = [(0, count)]
    while ranges:
        low, high = ranges.pop()
        place = _best_line(row, col, order[low:high])
        if place[0] < 0:
            continue
        along = row if place[0] == 0 else col
        kept, over, on = low, 0, 0
        for i in range(low, high):
            node = order[i]
            if along[node] < place[1]:
                order[kept] = node
                kept += 1
            elif along[node] > place[1]:
                beyond[over] = node
                over += 1
            else:
                line[on] = node
                on += 1
        order[kept:kept + over] = beyond[:over]
        order[kept + over:high] = line[:on]
        ranges.append((low, kept))
        ranges.append((kept, kept + over))
    return order


@njit(cache=True, nogil=True)
def _best_line(row: np.ndarray, col: np.ndarray, nodes: np.ndarray) -> Tuple[int, int]:
    """Axis (0: row, 1: column) and coordinate of the line with the fewest nodes for what it splits off; -1: none."""
    best, axis, where = np.inf, -1, 0
    if len(nodes) < 4:
        return axis, where
    for candidate in range(2):
        along = row if candidate == 0 else col
        low, high = along[nodes[0]], along[nodes[0]]
        for node in nodes:
            low, high = min(low, along[node]), max(high, along[node])
        counts = np.zeros(high - low + 1, dtype=np.int64)
        for node in nodes:
            counts[along[node] - low] += 1
        before = 0
        for place in range(len(counts)):
            smaller = min(before, len(nodes) - before - counts[place])
            before += counts[place]
            if smaller > 0 and smaller >= LEAST_SHARE * len(nodes):
                price = (counts[place] + 0.5) / smaller
                if price < best:
                    best, axis, where = price, candidate, low + place
    return axis, where


@njit(cache=True, nogil=True)
def _fill(links: Links, order: np.ndarray, rank: np.ndarray) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`parent`, `first` and `heads`: a node's arcs lead to its higher neighbours and where its children's lead to."""
    _, _, up, down, edges_of, _ = links
    count = len(order)
    parent, child, sibling = np.full(count, -1, np.int32), np.full(count, -1, np.int32), np.full(count, -1, np.int32)
    first = np.zeros(count + 1, dtype=np.int64)
    heads = np.empty(32 * count + 8, dtype=np.int32)
    mark = np.full(count, -1, dtype=np.int32)
    fresh = np.empty(count, dtype=np.int32)
    for tail in range(count):
        node, arcs = np.int64(order[tail]), 0
        for k in range(8):
            if edges_of[node] >> k & 1:
                head = rank[step(up, down, node, k)]
                if head > tail and mark[head] != tail:
                    mark[head] = tail
                    fresh[arcs] = head
                    arcs += 1
        below = child[tail]
        while below >= 0:
            for arc in range(first[below], first[below + 1]):
                head = heads[arc]
                if head > tail and mark[head] != tail:
                    mark[head] = tail
                    fresh[arcs] = head
                    arcs += 1
            below = sibling[below]
        if first[tail] + arcs > len(heads):
            heads = np.concatenate((heads, np.empty(len(heads) + arcs, dtype=np.int32)))
        heads[first[tail]:first[tail] + arcs] = np.sort(fresh[:arcs])
        first[tail + 1] = first[tail] + arcs
        if arcs:
            parent[tail] = heads[first[tail]]
            sibling[tail] = child[parent[tail]]
            child[parent[tail]] = tail
    return parent, first, heads[:first[count]].copy()
