"""Turns: a fleet that drives one robot after the other, and the orders of windows that this amounts to."""

from typing import NamedTuple, Sequence

import numpy as np

from social_fleet.coordination.encounters import Encounter
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.timing import Timing

_SAME = 1e-6  # by which arc lengths differ when summed up in two ways [m]


class Turn(NamedTuple):
    """One robot's drive while all others stand: position in the fleet, and from where to where on its path [m]."""

    robot: int
    low: float
    high: float


def sides_of(turns: Sequence[Turn], robots: Sequence[Robot], encounters: Sequence[Encounter]) -> np.ndarray:
    """Which robot is first in each window when they take turns: 0 for r, 1 for s, -1 where neither is (W,)."""
    timings = [_timing(index, robot, turns) for index, robot in enumerate(robots)]
    sides = np.full(len(encounters), -1, dtype=np.int64)
    for window, encounter in enumerate(encounters):
        for side, order in enumerate(encounter.orders):
            left = timings[order.follower].last_time(order.at + _SAME)
            reached = timings[order.leader].first_time(order.clear - _SAME)
            if order.possible and (left >= reached).all():
                sides[window] = side
                break
    return sides


def _timing(index: int, robot: Robot, turns: Sequence[Turn]) -> Timing:
    """A robot's motion when every turn takes one second."""
    arcs, times = [0.0], [-1.0]
    for second, turn in enumerate(turns):
        if turn.robot == index:
            arcs += [turn.low, turn.high]
            times += [second + 0.25, second + 0.75]
    return Timing(np.minimum(np.maximum.accumulate(arcs), robot.path.length), np.array(times))
