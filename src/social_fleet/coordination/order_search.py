"""Good orders quickly: greedy insertion of one window after the other, then single orders turned round.

What that finds bounds the program from above, which is what lets big-M constants be small. For few windows, branch and
bound over the orders proves the best of them sooner than a program is set up.
"""

from typing import List, Sequence, Tuple

import numpy as np
from numba import njit

from social_fleet.coordination.event_graph import EventGraph, Motion, Sides, longest_path

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
        self._graph = EventGraph(motions, windows, margin)

    def delay(self, sides: np.ndarray) -> float:
        """Delay of all arrivals together under `sides` (0: r first, 1: s first, -1: open) [s]; infinite on a cycle."""
        return float(self._graph.least_times(sides)[1])

    def prove(self, delay: float, sides: np.ndarray, *, nodes: int) -> Tuple[float, np.ndarray, bool]:
        """Branch and bound from the best delay known [s] and its sides, over at most so many nodes.

        A node leaves some windows open. Its earliest times are a bound for all below it, and where they happen to keep
        an order in each open window, a solution. Otherwise it branches on the window that asks for the longest delay
        whichever robot goes first.

        Returns
        -------
        delay, sides, proven
            The best delay now known [s], infinite when there is none, and whether there is surely no better.
        """
        root = np.array([-1 if None not in window else int(window[0] is None) for window in self._windows])
        return _branch(self._graph.events, self._graph.edges, root, sides, delay, self._graph.margin, nodes)

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
            times = [self._graph.events.floors[self._graph.event(wait.follower, wait.at[:1])[0]]
                     for wait in sides if wait is not None]
            entries.append((float(min(times)), window))
        return [window for _, window in sorted(entries)]


@njit(cache=True)
def _shortfalls(edges, sides, times, margin):  # type: ignore[no-untyped-def]
    """For each open window and side, by how much the times miss what that side asks for."""
    missing = np.zeros((len(sides), 2))
    for edge in range(len(edges.heads)):
        owner = edges.owners[edge]
        if sides[owner] < 0:
            late = times[edges.tails[edge]] + margin - times[edges.heads[edge]]
            missing[owner, edges.chosen[edge]] = max(missing[owner, edges.chosen[edge]], late)
    return missing


@njit(cache=True)
def _branch(events, edges, root, sides, best, margin, limit):  # type: ignore[no-untyped-def]
    """Depth first, the incumbent's side of each window first; see `OrderSearch.prove`."""
    windows = len(root)
    stack = np.empty((windows + 2, windows), np.int64)
    stack[0] = root
    top = 1
    incumbent = sides.copy()
    visited = 0
    while top > 0:
        if visited >= limit:
            return best, incumbent, False
        visited += 1
        top -= 1
        node = stack[top].copy()
        times, delay = longest_path(events, edges, node, margin)
        if delay >= best - 1e-9:
            continue
        missing = _shortfalls(edges, node, times, margin)
        chosen, worst = -1, 1e-9
        for window in range(windows):
            if node[window] < 0:
                least = min(missing[window, 0], missing[window, 1])
                if least > worst:
                    chosen, worst = window, least
        if chosen < 0:
            best = delay
            for window in range(windows):
                incumbent[window] = node[window]
                if node[window] < 0:
                    incumbent[window] = 0 if missing[window, 0] <= missing[window, 1] else 1
            continue
        preferred = max(incumbent[chosen], 0)
        for side in (1 - preferred, preferred):
            stack[top] = node
            stack[top, chosen] = side
            top += 1
    return best, incumbent, True
