"""A queue as a ring of buckets, for kernels: entries of about the same cost lie in one linked list.

Within a bucket the last entry comes first. Searches that use it therefore expand a node again when a cheaper way to it
turns up, and end only when every bucket left is dearer than their result; so the order inside a bucket affects time,
never the result.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

FIRST_ENTRIES = 1 << 14


class Queue(NamedTuple):
    """`heads` (rings, buckets): the top entry of each bucket; of every entry its node, its cost and the entry below.

    `state` holds the next unused entry and the first spare one, -1 for none; `used` the entries in each ring.
    """

    heads: np.ndarray
    node: np.ndarray
    cost: np.ndarray
    below: np.ndarray
    state: np.ndarray
    used: np.ndarray


def new_queue(rings: int, buckets: int) -> Queue:
    """An empty queue; `buckets` is a power of two."""
    return Queue(np.full((rings, buckets), -1, dtype=np.int32), np.empty(FIRST_ENTRIES, dtype=np.int32),
                 np.empty(FIRST_ENTRIES), np.empty(FIRST_ENTRIES, dtype=np.int32), np.array([0, -1]),
                 np.zeros(rings, dtype=np.int64))


@njit(cache=True, nogil=True)
def clear(queue: Queue) -> None:
    """Take out everything."""
    queue.heads[:] = -1
    queue.used[:] = 0
    queue.state[0], queue.state[1] = 0, -1


@njit(cache=True, nogil=True)
def roomy(queue: Queue, entries: int) -> Queue:
    """The queue, with room for so many entries more."""
    if queue.state[0] + entries <= len(queue.node):
        return queue
    spare = max(len(queue.node), entries)
    return Queue(queue.heads, np.concatenate((queue.node, np.empty(spare, dtype=np.int32))),
                 np.concatenate((queue.cost, np.empty(spare))),
                 np.concatenate((queue.below, np.empty(spare, dtype=np.int32))), queue.state, queue.used)


@njit(cache=True, nogil=True)
def push(queue: Queue, ring: int, bucket: int, node: int, cost: float) -> None:
    """Put a node into a bucket; there must be room."""
    entry = queue.state[1]
    if entry >= 0:
        queue.state[1] = queue.below[entry]
    else:
        entry = queue.state[0]
        queue.state[0] += 1
    slot = bucket & (queue.heads.shape[1] - 1)
    queue.node[entry] = node
    queue.cost[entry] = cost
    queue.below[entry] = queue.heads[ring, slot]
    queue.heads[ring, slot] = entry
    queue.used[ring] += 1


@njit(cache=True, nogil=True)
def holds(queue: Queue, ring: int, bucket: int) -> bool:
    """Whether a bucket has an entry."""
    return queue.heads[ring, bucket & (queue.heads.shape[1] - 1)] >= 0


@njit(cache=True, nogil=True)
def pop(queue: Queue, ring: int, bucket: int) -> int:
    """Take the entry on top of a bucket that has one."""
    slot = bucket & (queue.heads.shape[1] - 1)
    entry = queue.heads[ring, slot]
    queue.heads[ring, slot] = queue.below[entry]
    queue.below[entry] = queue.state[1]
    queue.state[1] = entry
    queue.used[ring] -= 1
    return entry
