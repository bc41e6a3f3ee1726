"""Earliest times for given orders: a longest path through the events of a fleet.

Once every window has an order, what is left of the program is a system of differences `t(b) - t(a) >= w`. Its least
solution is at once the earliest for every robot at every event, so no solver is needed, and no big-M rounding stays in
the times. A cycle of waits means that the orders contradict each other.
"""

from dataclasses import dataclass
from typing import List, NamedTuple, Optional, Sequence, Tuple

import numpy as np
from numba import njit

from social_fleet.coordination.timing import Timing

_CREEP = 2.0  # a stretch is driven at no less than nominal speed over this; what is longer is waited standing

SPREAD = -1
"""What `spread` returns when all events have times."""


class Wait(NamedTuple):
    """`follower` leaves the moments `at` [s] of its nominal motion after `leader` reaches the moments `clear`."""

    leader: int
    follower: int
    at: np.ndarray
    clear: np.ndarray


Sides = Tuple[Optional[Wait], Optional[Wait]]
"""What a window asks for when r goes first, and when s does; None for an order that is not possible."""


@dataclass(frozen=True)
class Motion:
    """What the program knows of one robot: its fastest motion, when it may start, whether that is settled, its weight.

    For a `fixed` robot `timing` holds its schedule, on the fleet's clock, and `depart` is 0.
    """

    timing: Timing
    depart: float
    fixed: bool = False
    weight: float = 1.0


class Pace:
    """When a robot is at every moment of its nominal motion.

    A stretch between two events that takes up to twice the nominal time is driven slower; one that takes longer is
    driven at nominal speed, and the robot stands waiting at its end.

    Parameters
    ----------
    moments, times : (K,) arrays
        Events, as moments of the nominal motion [s], rising, and when the robot leaves them on the fleet's clock [s].
    """

    def __init__(self, moments: np.ndarray, times: np.ndarray) -> None:
        spans, waits = np.diff(moments), np.diff(times)
        held = waits > _CREEP * spans + 1e-9
        self.moments = moments
        self.leave = times
        self.arrive = times.copy()
        self.arrive[1:][held] = times[:-1][held] + spans[held]

    def arrival(self, moments: np.ndarray) -> np.ndarray:
        """Times [s] at which the robot first reaches `moments` [s]."""
        high = np.minimum(np.searchsorted(self.moments, moments, side="left"), len(self.moments) - 1)
        low = np.maximum(high - 1, 0)
        spans = self.moments[high] - self.moments[low]
        share = np.where(spans > 0.0, (moments - self.moments[low]) / np.where(spans > 0.0, spans, 1.0), 1.0)
        return np.where(spans > 0.0, self.leave[low] + share * (self.arrive[high] - self.leave[low]),
                        self.arrive[high])

    def departure(self, moments: np.ndarray) -> np.ndarray:
        """Times [s] at which the robot goes on from `moments` [s]."""
        index = np.minimum(np.searchsorted(self.moments, moments, side="left"), len(self.moments) - 1)
        return np.where(self.moments[index] == moments, self.leave[index], self.arrival(moments))

    def knots(self, timing: Timing) -> Tuple[np.ndarray, np.ndarray]:
        """The timed path: arc lengths [m] and times [s] for a schedule, straight between."""
        moments = np.unique(np.concatenate((timing.times, self.moments)))
        arcs = np.interp(moments, timing.times, timing.arc_lengths)
        times = np.stack((self.arrival(moments), self.departure(moments)), axis=1).ravel()
        arcs = np.repeat(arcs, 2)
        kept = np.append(True, np.diff(times) > 1e-9)
        return _without_straight_knots(arcs[kept], times[kept])


def _without_straight_knots(arcs: np.ndarray, times: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """The same motion without the knots at which the speed does not change."""
    speeds = np.diff(arcs) / np.diff(times)
    bends = np.append(np.append(True, np.abs(np.diff(speeds)) > 1e-7), True)[:len(arcs)]
    return arcs[bends], times[bends]


class Events(NamedTuple):
    """Events of all robots in turn: nominal times, whether its robot's first, whether settled; and the last ones."""

    floors: np.ndarray
    first: np.ndarray
    fixed: np.ndarray
    goals: np.ndarray


class Edges(NamedTuple):
    """Waits between events, grouped by tail (`starts`): tail, head, the window that owns it, the side it belongs to."""

    tails: np.ndarray
    heads: np.ndarray
    owners: np.ndarray
    chosen: np.ndarray
    starts: np.ndarray


class Rows(NamedTuple):
    """The same waits window by window, for `order_state`.

    Rows starts[2 w]..starts[2 w + 1] belong to window w with r first, the next to it with s first. `outgoing` lists
    rows by tail, those of event e from out_starts[e] on; `owners` is 2 w + side for every row.
    """

    tails: np.ndarray
    heads: np.ndarray
    starts: np.ndarray
    owners: np.ndarray
    outgoing: np.ndarray
    out_starts: np.ndarray


class EventGraph:
    """The events of a fleet and the waits between them, of both orders of every window.

    Parameters
    ----------
    motions : sequence of Motion
        The whole fleet.
    windows : sequence of Sides
        What either order of each window asks for.
    margin : float
        Time by which a wait's second moment follows its first [s].
    """

    def __init__(self, motions: Sequence[Motion], windows: Sequence[Sides], margin: float) -> None:
        self.margin = margin
        waits = [(window, side, wait) for window, sides in enumerate(windows)
                 for side, wait in enumerate(sides) if wait is not None]
        self._moments = _moments(motions, [wait for _, _, wait in waits])
        self._offsets = np.cumsum([0] + [len(own) for own in self._moments])
        first = np.zeros(self._offsets[-1], dtype=np.bool_)
        first[self._offsets[:-1]] = True
        self.events = Events(
            np.concatenate([own + motion.depart for own, motion in zip(self._moments, motions)]), first,
            np.repeat([motion.fixed for motion in motions], np.diff(self._offsets)),
            np.array([end - 1 for end, motion in zip(self._offsets[1:], motions) if not motion.fixed], dtype=np.int64))
        self.rows = self._rows(waits, len(windows))
        self.edges = Edges(self.rows.tails[self.rows.outgoing], self.rows.heads[self.rows.outgoing],
                           self.rows.owners[self.rows.outgoing] >> 1, self.rows.owners[self.rows.outgoing] & 1,
                           self.rows.out_starts)

    @property
    def offsets(self) -> np.ndarray:
        """Where each robot's events begin, and the end of all (R + 1,)."""
        return self._offsets

    def event(self, robot: int, moments: np.ndarray) -> np.ndarray:
        """Positions of a robot's events at some of its moments."""
        return np.searchsorted(self._moments[robot], moments) + self._offsets[robot]

    def least_times(self, sides: np.ndarray) -> Tuple[np.ndarray, float]:
        """Least times of all events under `sides` (0: r first, 1: s first, -1: open) and the delay of all arrivals [s].

        The delay is infinite when the orders contradict each other or a fixed robot would have to wait.
        """
        return longest_path(self.events, self.edges, sides, self.margin)

    def paces(self, times: np.ndarray) -> List[Pace]:
        """Every robot's pace through its events at `times`."""
        return [Pace(own, times[low:high])
                for own, low, high in zip(self._moments, self._offsets[:-1], self._offsets[1:])]

    def _rows(self, waits: Sequence[Tuple[int, int, Wait]], windows: int) -> Rows:
        none = [np.zeros(0, dtype=np.int64)]
        tails = np.concatenate([self.event(wait.leader, wait.clear) for _, _, wait in waits] or none)
        heads = np.concatenate([self.event(wait.follower, wait.at) for _, _, wait in waits] or none)
        counts = np.zeros(2 * windows, dtype=np.int64)
        for window, side, wait in waits:
            counts[2 * window + side] = len(wait.at)
        starts = np.concatenate((np.zeros(1, dtype=np.int64), np.cumsum(counts)))
        outgoing = np.argsort(tails, kind="stable")
        out_starts = np.searchsorted(tails[outgoing], np.arange(self._offsets[-1] + 1))
        return Rows(tails, heads, starts, np.repeat(np.arange(2 * windows), counts), outgoing, out_starts)


def _moments(motions: Sequence[Motion], waits: Sequence[Wait]) -> List[np.ndarray]:
    """Each robot's moments that some wait speaks of, with its first and last."""
    own: List[List[np.ndarray]] = [[motion.timing.times[[0, -1]]] for motion in motions]
    for wait in waits:
        own[wait.leader].append(wait.clear)
        own[wait.follower].append(wait.at)
    return [np.unique(np.concatenate(parts)) for parts in own]


@njit(cache=True)
def longest_path(events, edges, sides, margin):  # type: ignore[no-untyped-def]
    """See `EventGraph.least_times`."""
    count = len(events.floors)
    times, causes = np.empty(count), np.empty(count, np.int64)
    degrees, queue = np.empty(count, np.int64), np.empty(count, np.int64)
    if spread(events, edges, sides, margin, times, causes, degrees, queue) != SPREAD:
        return times, np.inf
    delay = 0.0
    for goal in events.goals:
        delay += times[goal] - events.floors[goal]
    return times, delay


@njit(cache=True, nogil=True)
def spread(events, edges, sides, margin, times, causes, degrees, queue):  # type: ignore[no-untyped-def]
    """Fill in least times and what each comes from, by Kahn's order over the edges that `sides` makes active.

    `causes` holds the edge that an event's time comes from, or -1 where it is the event before. Returns `SPREAD`, the
    event of a fixed robot that would have to wait, or the number of events where waits close a cycle: then `degrees`
    are left over on it and behind it.
    """
    count = len(events.floors)
    for event in range(count):
        times[event], causes[event] = events.floors[event], -1
        degrees[event] = 0 if events.first[event] else 1
    for edge in range(len(edges.heads)):
        if sides[edges.owners[edge]] == edges.chosen[edge]:
            degrees[edges.heads[edge]] += 1
    low, high = 0, 0
    for event in range(count):
        if degrees[event] == 0:
            queue[high] = event
            high += 1
    while low < high:
        event = queue[low]
        low += 1
        if events.fixed[event]:
            if times[event] > events.floors[event] + 1e-6:
                return event
            times[event] = events.floors[event]
        if event + 1 < count and not events.first[event + 1]:
            after = times[event] + events.floors[event + 1] - events.floors[event]
            if after > times[event + 1]:
                times[event + 1], causes[event + 1] = after, -1
            degrees[event + 1] -= 1
            if degrees[event + 1] == 0:
                queue[high] = event + 1
                high += 1
        for edge in range(edges.starts[event], edges.starts[event + 1]):
            if sides[edges.owners[edge]] == edges.chosen[edge]:
                head = edges.heads[edge]
                if times[event] + margin > times[head]:
                    times[head], causes[head] = times[event] + margin, edge
                degrees[head] -= 1
                if degrees[head] == 0:
                    queue[high] = head
                    high += 1
    return SPREAD if high == count else count
