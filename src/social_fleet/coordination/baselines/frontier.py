"""The open nodes of a best-first search that may prefer others among the nearly best."""

import heapq
import itertools
from typing import Dict, Generic, List, Tuple, TypeVar

Item = TypeVar("Item")


class Frontier(Generic[Item]):
    """Items with a lower bound and a rank: `pop` gives the lowest rank among those whose bound is near the least.

    Parameters
    ----------
    factor, equal : float
        A bound is near while it is at most `factor` times the least plus `equal`.
    """

    def __init__(self, factor: float, equal: float) -> None:
        self._factor = factor
        self._equal = equal
        self._serial = itertools.count()
        self._items: Dict[int, Item] = {}
        self._bounds: List[Tuple[float, int]] = []  # of all items, and of some that have gone
        self._far: List[Tuple[float, int, int]] = []  # bound, rank, serial
        self._near: List[Tuple[int, int]] = []  # rank, minus serial

    def __bool__(self) -> bool:
        return bool(self._items)

    @property
    def bound(self) -> float:
        """The least bound of all items; there must be one."""
        while self._bounds[0][1] not in self._items:
            heapq.heappop(self._bounds)
        return self._bounds[0][0]

    def push(self, item: Item, bound: float, rank: int) -> None:
        """Add an item."""
        serial = next(self._serial)
        self._items[serial] = item
        heapq.heappush(self._bounds, (bound, serial))
        heapq.heappush(self._far, (bound, rank, serial))

    def pop(self) -> Item:
        """Take the item of the lowest rank among those near the least bound; of equals the latest, to get deep."""
        limit = self.bound * self._factor + self._equal
        while self._far and self._far[0][0] <= limit:
            _, rank, serial = heapq.heappop(self._far)
            heapq.heappush(self._near, (rank, -serial))
        return self._items.pop(-heapq.heappop(self._near)[1])
