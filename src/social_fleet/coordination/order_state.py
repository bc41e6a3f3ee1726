"""Orders of windows, given one by one and taken back, with the earliest times that they allow.

`event_graph.longest_path` computes all times anew; here only what an order changes is touched, which makes an order
cost microseconds. For every time there is a chain of causes: the orders along it explain a late arrival, or, where the
chain closes, why no schedule has all of them.
"""

from typing import FrozenSet, List, Optional, Sequence, Set, Tuple

import numpy as np

from social_fleet.coordination import order_kernels
from social_fleet.coordination.event_graph import EventGraph, Motion
from social_fleet.errors import SolverFailed

Choice = Tuple[int, int]
"""A window and the side that goes first: 0 for r, 1 for s."""

_TRAIL = 64  # raised times remembered, as a multiple of the events
_SHORTEST_TRAIL = 1 << 16


class OrderState:
    """The orders given so far.

    Parameters
    ----------
    graph : EventGraph
        Events of the fleet and the waits of both orders of every window.
    motions : sequence of Motion
    weights : (R,) array
        What a second of delay costs for each robot; 0 for fixed ones.
    longest : bool
        Whether the latest arrival counts, rather than the weighted sum.

    Attributes
    ----------
    possible : (W, 2) bool array
        Which orders the starts and goals allow.
    sides : (W,) array
        0 where r goes first, 1 where s does, -1 where the window is open.
    robots : (E,) array
        Whose each event is.
    """

    def __init__(self, graph: EventGraph, motions: Sequence[Motion], weights: np.ndarray, longest: bool) -> None:
        self.graph = graph
        self.rows = rows = graph.rows
        self.possible = np.diff(rows.starts).reshape(-1, 2) > 0
        self.sides = np.full(len(self.possible), -1, dtype=np.int64)
        self.weights, self.longest = weights, longest
        self._events = graph.events
        self._offsets = graph.offsets
        self.robots = np.repeat(np.arange(len(motions)), np.diff(self._offsets))
        self._fixed = np.array([motion.fixed for motion in motions], dtype=np.bool_)
        self.goals = self._offsets[1:] - 1
        self.times = self._events.floors.copy()
        self._causes = np.full(len(self.times), -1, dtype=np.int64)
        self.latest = self.times[self.goals] + _horizon(motions, len(self.sides), graph.margin)
        self._scratch = (np.full(len(motions), -1, dtype=np.int64), np.zeros(len(motions), dtype=np.int64),
                         np.zeros(len(motions), dtype=np.int64))
        size = max(_TRAIL * len(self.times), _SHORTEST_TRAIL)
        self._trail = np.zeros(size, dtype=np.int64), np.zeros(size), np.zeros(size, dtype=np.int64)
        self._top = 0
        self._given: List[Tuple[int, int]] = []
        self._settled: Set[int] = set()
        self._windows_of, self._window_starts = self._by_robot(len(motions))

    @property
    def given(self) -> int:
        """How many orders are given."""
        return len(self._given)

    def give(self, window: int, side: int) -> Optional[int]:
        """Let a side of a window go first; the event that makes it impossible, or None."""
        rows = self.rows
        self._given.append((window, self._top))
        self._top, bad = order_kernels.give(
            window, side, self.times, self._causes, self._events.floors, self._offsets, self.robots, self._fixed,
            self.latest, rows.tails, rows.heads, rows.starts, rows.outgoing, rows.out_starts, rows.owners, self.sides,
            self.graph.margin, *self._scratch, *self._trail, self._top)
        if bad >= 0 and self._top > len(self._trail[0]) - 4 * len(self.goals) and not self._is_closed(int(bad)):
            raise SolverFailed("the orders of too many windows are open at once; send fewer robots at once")
        return None if bad < 0 else int(bad)

    def take_back(self, to: int) -> None:
        """Take back the latest orders until `to` are left."""
        while len(self._given) > to:
            window, top = self._given.pop()
            self.sides[window] = -1
            self._top = order_kernels.take_back(self.times, self._causes, *self._trail, self._top, top)

    def settle(self) -> None:
        """Make the orders given so far part of the problem: explanations leave them out."""
        self._settled = {window for window, _ in self._given}

    def windows_of(self, robot: int) -> np.ndarray:
        """The windows of a robot."""
        return self._windows_of[self._window_starts[robot]:self._window_starts[robot + 1]]

    def robots_of(self, window: int) -> np.ndarray:
        """The two robots of a window (2,)."""
        row = self.rows.starts[2 * window + int(not self.possible[window, 0])]
        return self.robots[[self.rows.tails[row], self.rows.heads[row]]]

    def arrivals(self) -> np.ndarray:
        """Earliest arrivals of all robots (R,) [s]."""
        return self.times[self.goals]

    def cost(self, times: Optional[np.ndarray] = None) -> float:
        """The objective [s], weighted, under the orders given or at `times`."""
        return float(order_kernels.cost(self.times if times is None else times, self.goals, self.weights, self.longest))

    def contested(self) -> np.ndarray:
        """Open windows of which the times keep neither order, by when the first of the robots is there."""
        rows = self.rows
        broken = np.flatnonzero(order_kernels.contested(self.times, rows.tails, rows.heads, rows.starts, self.possible,
                                                        self.sides, self.graph.margin))
        return broken[np.argsort(self.entries()[broken], kind="stable")]

    def kept(self, times: np.ndarray) -> np.ndarray:
        """For each window and side (W, 2) whether `times` of all events keep that order."""
        rows = self.rows
        return order_kernels.kept(times, rows.tails, rows.heads, rows.starts, self.possible, self.graph.margin)

    def entries(self, times: Optional[np.ndarray] = None) -> np.ndarray:
        """When the first of its robots is at each window (W,) [s], under the orders given or at `times`."""
        return order_kernels.entries(self.times if times is None else times, self.rows.heads, self.rows.starts,
                                     self.possible)

    def dive(self, wanted: np.ndarray, by_time: np.ndarray, cap: float) -> Tuple[float, np.ndarray]:
        """Orders that begin with those `wanted` (-1: none), tried in the sequence `by_time`.

        Returns
        -------
        cost, sides
            The objective, infinite when no orders were found below `cap`; and the sides. The state is as before.
        """
        rows, top, sides = self.rows, self._top, self.sides.copy()
        high, found = order_kernels.dive(
            wanted, by_time, cap, self.longest, self.weights, self.goals, self._windows_of, self._window_starts,
            self.times, self._causes, self._events.floors, self._offsets, self.robots, self._fixed, self.latest,
            rows.tails, rows.heads, rows.starts, rows.outgoing, rows.out_starts, rows.owners, self.possible, self.sides,
            self.graph.margin, *self._scratch, *self._trail, top)
        chosen = self.sides.copy()
        self.sides[:] = sides
        self._top = order_kernels.take_back(self.times, self._causes, *self._trail, high, top)
        return float(found), chosen

    def explain(self, event: int) -> FrozenSet[Choice]:
        """Orders, none of them settled, that bring about the time of an event: all on its chain of causes.

        Where the chain closes, the orders on the cycle alone.
        """
        return frozenset(choice for choice in self._chain(event) if choice[0] not in self._settled)

    def explain_windows(self, event: int) -> FrozenSet[int]:
        """The windows, settled or not, on an event's chain of causes."""
        return frozenset(window for window, _ in self._chain(event))

    def _is_closed(self, event: int) -> bool:
        """Whether the causes of an event go round."""
        return bool(self._walk(event)[1])

    def _chain(self, event: int) -> Set[Choice]:
        owners = np.unique(self.rows.owners[self._walk(event)[0]])
        return set(zip((owners >> 1).tolist(), (owners & 1).tolist()))

    def _walk(self, event: int) -> Tuple[np.ndarray, bool]:
        """The rows that an event's time comes from, back to a departure; or those of a cycle, and that it is one."""
        return order_kernels.walk(event, self._causes, self.rows.tails, self._offsets, self.robots)

    def _by_robot(self, robots: int) -> Tuple[np.ndarray, np.ndarray]:
        """The windows of every robot, one robot after the other, and where each robot's begin."""
        first_rows = self.rows.starts[:-1].reshape(-1, 2)[self.possible]
        windows = np.nonzero(self.possible)[0]
        ends = np.concatenate((self.robots[self.rows.tails[first_rows]], self.robots[self.rows.heads[first_rows]]))
        pairs = np.unique(np.stack((ends, np.tile(windows, 2)), axis=1), axis=0)
        return (np.ascontiguousarray(pairs[:, 1]),
                np.searchsorted(pairs[:, 0], np.arange(robots + 1)).astype(np.int64))


def with_kept(sides: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """Orders of all windows (W,): the given ones, and for those open (-1) what is `kept` (`OrderState.kept`)."""
    return np.where(sides >= 0, sides, np.where(kept[:, 0], 0, 1))


def _horizon(motions: Sequence[Motion], windows: int, margin: float) -> float:
    """Eq. 8, with the margins: no robot has to arrive later than nominal by more [s]."""
    longest = sum(max(motion.timing.duration + motion.depart, 0.0) for motion in motions)
    latest = max((float(motion.timing.times[-1]) for motion in motions), default=0.0)
    return 2.0 * longest + latest + margin * (windows + 1)
