"""Good orders quickly: greedy insertion of one window after the other, then single orders turned round.

What it finds bounds the program from above, which is what lets big-M constants be small; it proves nothing.
"""

from typing import List, Sequence, Tuple

import numpy as np
from numba import njit

from social_fleet.coordination.event_graph import Motion, Sides

_PASSES = 20


class OrderSearch:
    """Orders of some windows, judged by the sum of the earliest arrivals that they allow.

    Parameters
    ----------
    motions : sequence of Motion
        The whole fleet.
    windows : sequence of (Wait or None, Wait or None)
        What either order of each window asks for; None where it is not possible.
    margin : float
        [s]
    """

    def __init__(self, motions: Sequence[Motion], windows: Sequence[Sides], margin: float) -> None:
        self._windows = windows
        self._margin = margin
        robots = sorted({robot for sides in windows for wait in sides if wait is not None
                         for robot in (wait.leader, wait.follower)})
        self._moments = {robot: self._events(motions[robot], robot) for robot in robots}
        starts = np.cumsum([0] + [len(self._moments[robot]) for robot in robots])
        self._offsets = dict(zip(robots, starts.tolist()))
        self._floors = np.concatenate([self._moments[robot] + motions[robot].depart for robot in robots])
        self._first = np.zeros(starts[-1], dtype=np.bool_)
        self._first[starts[:-1]] = True
        self._fixed = np.repeat([motions[robot].fixed for robot in robots], np.diff(starts))
        self._goals = np.array([end - 1 for robot, end in zip(robots, starts[1:]) if not motions[robot].fixed])
        self._edges = self._all_edges()

    def delay(self, sides: np.ndarray) -> float:
        """Delay of all arrivals together under `sides` (0: r first, 1: s first, -1: open) [s]; infinite on a cycle."""
        return float(_delay(self._floors, self._first, self._fixed, self._goals, *self._edges, sides, self._margin))

    def best(self) -> Tuple[float, np.ndarray]:
        """The least delay found [s], infinite when none was, and its sides."""
        sides = np.full(len(self._windows), -1, dtype=np.int64)
        for window in self._by_time():
            choices = []
            for side in (0, 1):
                if self._windows[window][side] is not None:
                    sides[window] = side
                    choices.append((self.delay(sides), side))
            least, sides[window] = min(choices)
            if not np.isfinite(least):
                return least, sides
        return self._improved(sides)

    def _improved(self, sides: np.ndarray) -> Tuple[float, np.ndarray]:
        least = self.delay(sides)
        for _ in range(_PASSES):
            before = least
            for window, (r_first, s_first) in enumerate(self._windows):
                if r_first is None or s_first is None:
                    continue
                sides[window] = 1 - sides[window]
                delay = self.delay(sides)
                if delay < least - 1e-9:
                    least = delay
                else:
                    sides[window] = 1 - sides[window]
            if least >= before:
                break
        return least, sides

    def _by_time(self) -> List[int]:
        """Windows by when the first robot could be there."""
        entries = []
        for window, sides in enumerate(self._windows):
            times = [self._floors[self._node(wait.follower, wait.at[:1])[0]] for wait in sides if wait is not None]
            entries.append((float(min(times)), window))
        return [window for _, window in sorted(entries)]

    def _events(self, motion: Motion, robot: int) -> np.ndarray:
        parts = [motion.timing.times[[0, -1]]]
        for wait in (wait for sides in self._windows for wait in sides if wait is not None):
            if wait.leader == robot:
                parts.append(wait.clear)
            elif wait.follower == robot:
                parts.append(wait.at)
        return np.unique(np.concatenate(parts))

    def _node(self, robot: int, moments: np.ndarray) -> np.ndarray:
        return np.searchsorted(self._moments[robot], moments) + self._offsets[robot]

    def _all_edges(self) -> Tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Heads, windows and sides of all edges, grouped by tail, and where each tail's group starts."""
        tails, heads, owners, chosen = [], [], [], []
        for window, sides in enumerate(self._windows):
            for side, wait in enumerate(sides):
                if wait is None:
                    continue
                tails.append(self._node(wait.leader, wait.clear))
                heads.append(self._node(wait.follower, wait.at))
                owners.append(np.full(len(wait.at), window))
                chosen.append(np.full(len(wait.at), side))
        tail = np.concatenate(tails)
        grouped = np.argsort(tail, kind="stable")
        starts = np.searchsorted(tail[grouped], np.arange(len(self._floors) + 1))
        return (np.concatenate(heads)[grouped], np.concatenate(owners)[grouped], np.concatenate(chosen)[grouped],
                starts)


@njit(cache=True)
def _delay(floors, first, fixed, goals, heads, owners, chosen, starts, sides, margin):  # type: ignore[no-untyped-def]
    """Sum of the goals' earliest times above their floors under the edges that `sides` makes active."""
    count = len(floors)
    degrees = np.zeros(count, np.int64)
    for edge in range(len(heads)):
        if sides[owners[edge]] == chosen[edge]:
            degrees[heads[edge]] += 1
    times = floors.copy()
    queue = np.empty(count, np.int64)
    low, high = 0, 0
    for node in range(count):
        if not first[node]:
            degrees[node] += 1
        if degrees[node] == 0:
            queue[high] = node
            high += 1
    while low < high:
        node = queue[low]
        low += 1
        if fixed[node]:
            if times[node] > floors[node] + 1e-6:
                return np.inf
            times[node] = floors[node]
        if node + 1 < count and not first[node + 1]:
            times[node + 1] = max(times[node + 1], times[node] + floors[node + 1] - floors[node])
            degrees[node + 1] -= 1
            if degrees[node + 1] == 0:
                queue[high] = node + 1
                high += 1
        for edge in range(starts[node], starts[node + 1]):
            if sides[owners[edge]] == chosen[edge]:
                target = heads[edge]
                times[target] = max(times[target], times[node] + margin)
                degrees[target] -= 1
                if degrees[target] == 0:
                    queue[high] = target
                    high += 1
    if high < count:
        return np.inf
    total = 0.0
    for goal in goals:
        total += times[goal] - floors[goal]
    return total
