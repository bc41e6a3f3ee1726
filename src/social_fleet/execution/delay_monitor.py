"""How late a robot is, and whether that is worth acting on."""

from bisect import bisect_right
from typing import List

from social_fleet.coordination.schedule import Schedule
from social_fleet.execution.governor import interpolate

_SHORT = 0.05  # progress this far short of a scheduled wait counts as having reached it [m]


class DelayMonitor:
    """Compares reported progress with the schedule, with hysteresis.

    Parameters
    ----------
    schedule : Schedule
        What the robot follows.
    late : float
        Delay from which the robot counts as late [s].
    recovered : float
        Delay below which it no longer does [s].

    Attributes
    ----------
    schedule : Schedule
        The one that it compares with.
    delay : float
        At the last update [s]; negative when the robot is ahead.
    is_late : bool
        Whether it counts as late.
    """

    def __init__(self, schedule: Schedule, *, late: float = 5.0, recovered: float = 2.0) -> None:
        self.schedule = schedule
        self._arcs: List[float] = schedule.arc_lengths.tolist()
        self._times: List[float] = schedule.times.tolist()
        self._late = late
        self._recovered = recovered
        self.delay = 0.0
        self.is_late = False

    def update(self, now: float, progress: float) -> float:
        """The delay [s] of a robot that reports `progress` [m] at `now`."""
        latest = self._leaves(progress + _SHORT)
        earliest = self._reaches(progress)
        if now > latest:
            self.delay = now - latest
        else:
            self.delay = min(now - earliest, 0.0)
        if self.delay > self._late:
            self.is_late = True
        elif self.delay < self._recovered:
            self.is_late = False
        return self.delay

    def _leaves(self, arc_length: float) -> float:
        """When the schedule leaves `arc_length`; infinitely late at its end only if it is already there."""
        if arc_length >= self._arcs[-1]:
            return self._times[-1]
        index = bisect_right(self._arcs, arc_length)
        if index == 0:
            return self._times[0]
        return interpolate(arc_length, self._arcs[index - 1:index + 1], self._times[index - 1:index + 1])

    def _reaches(self, arc_length: float) -> float:
        """When the schedule first comes to `arc_length`."""
        low, high = 0, len(self._arcs) - 1
        while low < high:
            middle = (low + high) // 2
            low, high = (middle + 1, high) if self._arcs[middle] < arc_length else (low, middle)
        if low == 0 or self._arcs[low] < arc_length:
            return self._times[low]
        return interpolate(arc_length, self._arcs[low - 1:low + 1], self._times[low - 1:low + 1])
