"""The reference: a point that moves along the path as the schedule says, as fast as the robot can and may."""

from bisect import bisect_right
from typing import List

from social_fleet.coordination.schedule import Schedule
from social_fleet.coordination.timing import ACCELERATION_SHARE
from social_fleet.execution.braking import approach, stopping_speed
from social_fleet.execution.reference_path import ReferencePath

_FOLLOWING_PERIODS = 3.0  # smooths the pursuit of the schedule; one period makes it ring at creeping speeds
_STEP_SHARE = 0.9  # of the acceleration: the rest is for correcting errors
_SNAP = 1e-6  # [m]


class Governor:
    """Moves the reference so that it keeps to the schedule, and never faster than the robot can follow.

    The reference aims for where the schedule will be once it has braked, so that it neither runs ahead of a scheduled
    stop nor lags behind steady motion. It obeys the speed profile, with what the schedule leaves in reserve for
    catching up, can always stop at the next bound, and waits for a robot that stays behind.

    Attributes
    ----------
    arc_length, speed : float
        Of the reference [m, m/s].
    """

    def __init__(self, schedule: Schedule, path: ReferencePath) -> None:
        limits = schedule.robot.limits
        self.arc_length = 0.0
        self.speed = 0.0
        self._times: List[float] = schedule.times.tolist()
        self._knots: List[float] = schedule.arc_lengths.tolist()
        self._path = path
        self._braking = ACCELERATION_SHARE * limits.max_acceleration
        self._stepping = _STEP_SHARE * limits.max_acceleration
        self._fastest = limits.max_speed

    def scheduled(self, now: float) -> float:
        """The arc length that the schedule gives for `now` [m]."""
        return interpolate(now, self._times, self._knots)

    def advance(self, now: float, period: float, leg: int, *, stop: float, bound: float, patience: float) -> None:
        """Move on by one period.

        Parameters
        ----------
        now : float
            Its beginning [s].
        leg : int
            Number of the path's leg that the reference is on.
        stop : float
            Arc length of the next stop, which is reached exactly [m].
        bound : float
            Arc length that others leave free [m]; where it is passed already, the reference stands.
        patience : float
            Share of the permitted speed that the robot can be followed at: 0 waits for it.
        """
        smoothing = _FOLLOWING_PERIODS * period
        preview = now + period + 0.5 * (self.speed / self._braking + smoothing)
        speed = min(self._permitted(leg, period) * patience,
                    stopping_speed(min(stop, bound) - self.arc_length, self._braking, period))
        target = self.scheduled(preview)
        if target < stop:  # else the stop alone says when to brake, to the millimetre
            speed = min(speed, stopping_speed(target - self.arc_length, self._braking, smoothing))
        self.speed = approach(self.speed, speed, self._stepping * period)
        self._move(period, stop)

    def brake(self, period: float, stop: float) -> None:
        """Slow down as fast as the robot can, whatever the schedule says."""
        self.speed = approach(self.speed, 0.0, self._stepping * period / _STEP_SHARE)
        self._move(period, stop)

    def _move(self, period: float, stop: float) -> None:
        self.arc_length += self.speed * period
        if self.arc_length > stop - _SNAP:
            self.arc_length = stop
            self.speed = 0.0 if self.speed <= self._stepping * period else self.speed

    def _permitted(self, leg: int, period: float) -> float:
        """The path's highest speed, here or a step ahead: it is zero at every stop, also at the one to depart from.

        What one step of acceleration gives is always permitted, or legs of a millimetre would hold the robot for ever.
        """
        ahead = self.arc_length + (self.speed + self._stepping * period) * period
        speed = max(self._path.speed(leg, self.arc_length), self._path.speed(leg, ahead))
        return min(max(speed, self._stepping * period), self._fastest)


def interpolate(value: float, values: List[float], results: List[float]) -> float:
    """Linear interpolation, constant beyond the ends; `values` rise."""
    index = bisect_right(values, value)
    if index == 0:
        return results[0]
    if index == len(values):
        return results[-1]
    low = values[index - 1]
    share = (value - low) / (values[index] - low)
    return results[index - 1] + share * (results[index] - results[index - 1])
