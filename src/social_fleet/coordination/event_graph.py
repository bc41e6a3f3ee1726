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
    """What the program knows of one robot: its fastest motion, when it may start, and whether that is settled.

    For a `fixed` robot `timing` holds its schedule, on the fleet's clock, and `depart` is 0.
    """

    timing: Timing
    depart: float
    fixed: bool = False


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


def earliest(motions: Sequence[Motion], waits: Sequence[Wait], margin: float) -> Optional[List[Pace]]:
    """The least times at which every robot keeps every wait.

    Parameters
    ----------
    margin : float
        Time by which a wait's second moment follows its first [s].

    Returns
    -------
    list of Pace, or None when the waits contradict each other or a fixed robot would have to wait.
    """
    moments = _events(motions, waits)
    offsets = np.cumsum([0] + [len(own) for own in moments])
    tails = [np.searchsorted(moments[wait.leader], wait.clear) + offsets[wait.leader] for wait in waits]
    heads = [np.searchsorted(moments[wait.follower], wait.at) + offsets[wait.follower] for wait in waits]
    fixed = np.repeat([motion.fixed for motion in motions], np.diff(offsets))
    floors = np.concatenate([own + motion.depart for own, motion in zip(moments, motions)])
    first = np.zeros(offsets[-1], dtype=bool)
    first[offsets[:-1]] = True
    none = [np.zeros(0, dtype=np.int64)]
    times = _longest_path(floors, first, fixed, np.concatenate(tails or none), np.concatenate(heads or none), margin)
    if times is None:
        return None
    return [Pace(own, times[low:high]) for own, low, high in zip(moments, offsets[:-1], offsets[1:])]


def _events(motions: Sequence[Motion], waits: Sequence[Wait]) -> List[np.ndarray]:
    """Each robot's moments that some wait speaks of, with its first and last."""
    own: List[List[np.ndarray]] = [[motion.timing.times[[0, -1]]] for motion in motions]
    for wait in waits:
        own[wait.leader].append(wait.clear)
        own[wait.follower].append(wait.at)
    return [np.unique(np.concatenate(parts)) for parts in own]


@njit(cache=True)
def _longest_path(floors, first, fixed, tails, heads, margin):  # type: ignore[no-untyped-def]
    """Least times >= floors that keep every edge, by Kahn's order; None on a cycle or a late fixed event."""
    count = len(floors)
    degrees = np.zeros(count, np.int64)
    starts = np.zeros(count + 1, np.int64)
    for edge in range(len(tails)):
        degrees[heads[edge]] += 1
        starts[tails[edge] + 1] += 1
    starts = np.cumsum(starts)
    fill = starts[:-1].copy()
    targets = np.empty(len(tails), np.int64)
    for edge in range(len(tails)):
        targets[fill[tails[edge]]] = heads[edge]
        fill[tails[edge]] += 1
    for node in range(count):
        if not first[node]:
            degrees[node] += 1
    times = floors.copy()
    queue = np.empty(count, np.int64)
    low, high = 0, 0
    for node in range(count):
        if degrees[node] == 0:
            queue[high] = node
            high += 1
    while low < high:
        node = queue[low]
        low += 1
        if fixed[node] and times[node] > floors[node] + 1e-6:
            return None
        if fixed[node]:
            times[node] = floors[node]
        if node + 1 < count and not first[node + 1]:
            times[node + 1] = max(times[node + 1], times[node] + floors[node + 1] - floors[node])
            degrees[node + 1] -= 1
            if degrees[node + 1] == 0:
                queue[high] = node + 1
                high += 1
        for edge in range(starts[node], starts[node + 1]):
            target = targets[edge]
            times[target] = max(times[target], times[node] + margin)
            degrees[target] -= 1
            if degrees[target] == 0:
                queue[high] = target
                high += 1
    return times if high == count else None
