"""A queue as a ring of buckets, for kernels: entries of about the same cost lie in one linked list.

Within a bucket the last entry comes first. Searches that use it therefore expand a node again when a cheaper way to it
turns up, and end only when every bucket left is dearer than their result; so the order inside a bucket affects time,
never the result.

Kernels unpack tuples of arrays once, at their top, hand single arrays on, and never replace them: Numba counts
references otherwise, which makes an inner loop four times as slow. So a queue that is full says so, and whoever called
the kernel calls it again with a larger one.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

FIRST_ENTRIES = 1 << 16
# Of a queue's state: the next fresh entry, the first spare one (-1: none), entries in use, whether it was too small.
NEXT, SPARE, USED, FULL = 0, 1, 2, 3


class Queue(NamedTuple):
    """`heads`: the top entry of each bucket, -1 for none; of every entry its node, its cost and the entry below it."""

    heads: np.ndarray
    node: np.ndarray
    cost: np.ndarray
    below: np.ndarray
    state: np.ndarray


def new_queue(buckets: int, entries: int = FIRST_ENTRIES) -> Queue:
    """An empty queue; `buckets` is a power of two."""
    return Queue(np.full(buckets, -1, dtype=np.int32), np.empty(entries, dtype=np.int32), np.empty(entries),
                 np.empty(entries, dtype=np.int32), np.array([0, -1, 0, 0]))


@njit(cache=True, nogil=True)
def clear(heads: np.ndarray, state: np.ndarray) -> None:
    """Take out everything."""
    heads[:] = -1
    state[NEXT], state[SPARE], state[USED] = 0, -1, 0


@njit(cache=True, nogil=True)
def push(heads: np.ndarray, node: np.ndarray, cost: np.ndarray, below: np.ndarray, state: np.ndarray, bucket: int,
         new_node: int, new_cost: float) -> None:
    """Put a node into a bucket; there must be room."""
    entry = state[SPARE]
    if entry >= 0:
        state[SPARE] = below[entry]
    else:
        entry = state[NEXT]
        state[NEXT] += 1
    slot = bucket & (len(heads) - 1)
    node[entry] = new_node
    cost[entry] = new_cost
    below[entry] = heads[slot]
    heads[slot] = entry
    state[USED] += 1


@njit(cache=True, nogil=True)
def pop(heads: np.ndarray, below: np.ndarray, state: np.ndarray, bucket: int) -> int:
    """Take the entry on top of a bucket; -1 where there is none."""
    slot = bucket & (len(heads) - 1)
    entry = heads[slot]
    if entry >= 0:
        heads[slot] = below[entry]
        below[entry] = state[SPARE]
        state[SPARE] = entry
        state[USED] -= 1
    return entry
