"""How long a differential drive needs along a path: the segment minima of Eq. 5, with turns and acceleration.

The program, the tracker and the reports share this one model, so that what is scheduled can be driven. Schedules use
a share of each limit; the rest is the tracker's reserve for catching up and for corrections.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import List, Optional, Tuple, Union

import numpy as np

from social_fleet.coordination.driven_path import driven_legs, sampled
from social_fleet.coordination.robot import MotionLimits
from social_fleet.geometry import Polyline, wrap_angle

TURN_IN_PLACE = math.radians(20.0)
"""A vertex that bends more than this is turned at standing still [rad]."""

SPEED_SHARE = 0.95
ACCELERATION_SHARE = 0.8
TURN_SHARE = 0.7

_STEP = 0.1  # spacing of the profile's samples [m]
_SMALLEST_TURN = math.radians(0.5)  # differences of heading that no robot turns for [rad]

Arcs = Union[float, np.ndarray]


@dataclass(frozen=True)
class Timing:
    """The fastest motion along a path, from standstill to standstill.

    Attributes
    ----------
    arc_lengths, times : (K,) arrays
        Knots, linear between: [m] never falling, [s] strictly rising from 0. An arc length that stands twice
        is a turn in place.
    """

    arc_lengths: np.ndarray
    times: np.ndarray

    @property
    def duration(self) -> float:
        """Time from the first motion to the last [s]."""
        return float(self.times[-1])

    def first_time(self, arc_length: Arcs) -> np.ndarray:
        """When the robot first reaches `arc_length` [s]."""
        arcs, starts, ends = self._stays
        index = np.minimum(np.searchsorted(arcs, arc_length, side="left"), len(arcs) - 1)
        before = np.maximum(index - 1, 0)
        reach = np.maximum(arcs[index] - arcs[before], 1e-12)
        share = np.minimum(np.maximum((np.asarray(arc_length) - arcs[before]) / reach, 0.0), 1.0)
        return np.where(index == before, starts[index], ends[before] + share * (starts[index] - ends[before]))

    def last_time(self, arc_length: Arcs) -> np.ndarray:
        """When the robot leaves `arc_length` [s]."""
        arcs, starts, ends = self._stays
        index = np.maximum(np.searchsorted(arcs, arc_length, side="right") - 1, 0)
        after = np.minimum(index + 1, len(arcs) - 1)
        reach = np.maximum(arcs[after] - arcs[index], 1e-12)
        share = np.minimum(np.maximum((np.asarray(arc_length) - arcs[index]) / reach, 0.0), 1.0)
        return np.where(index == after, ends[index], ends[index] + share * (starts[after] - ends[index]))

    @cached_property
    def _stays(self) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The knots' arc lengths [m], each once, with when the robot comes there and when it goes on [s]."""
        arcs, first, counts = np.unique(self.arc_lengths, return_index=True, return_counts=True)
        return arcs, self.times[first], self.times[first + counts - 1]


def turning_points(path: Polyline) -> Tuple[np.ndarray, np.ndarray]:
    """Inner vertices that are turned at in place.

    Returns
    -------
    arc_lengths, angles : (T,) arrays
        Where [m], and by how much, signed [rad].
    """
    bends = _bends(path)
    sharp = np.abs(bends) > TURN_IN_PLACE
    return path.arc_lengths[1:-1][sharp], bends[sharp]


def speed_profile(path: Polyline, limits: MotionLimits) -> Tuple[np.ndarray, np.ndarray]:
    """The fastest speeds along a path that keep to the scheduled share of each limit.

    Speed is limited by the drive, in bends by turn rate and turn acceleration, and everywhere by the acceleration
    towards the stops: both ends and the turning points.

    Returns
    -------
    arc_lengths, speeds : (K,) arrays
        Samples [m] and speeds there [m/s]; between two samples the acceleration is constant.
    """
    usable = MotionLimits(SPEED_SHARE * limits.max_speed, ACCELERATION_SHARE * limits.max_acceleration,
                          TURN_SHARE * limits.max_turn_rate, TURN_SHARE * limits.max_turn_acceleration)
    legs = driven_legs(path, turning_points(path)[0].tolist())
    return sampled(legs, [leg.permitted_speeds(usable) for leg in legs], _STEP)


def turn_duration(angle: float, limits: MotionLimits) -> float:
    """Time for a turn in place by `angle` [rad] from standstill to standstill [s]."""
    angle = abs(angle)
    if angle < _SMALLEST_TURN:
        return 0.0
    rate, acceleration = TURN_SHARE * limits.max_turn_rate, TURN_SHARE * limits.max_turn_acceleration
    if angle <= rate ** 2 / acceleration:
        return 2.0 * math.sqrt(angle / acceleration)
    return angle / rate + rate / acceleration


def nominal_timing(path: Polyline, limits: MotionLimits, *, start_yaw: Optional[float] = None,
                   goal_yaw: Optional[float] = None) -> Timing:
    """The fastest motion along `path`, turns in place included.

    Parameters
    ----------
    start_yaw, goal_yaw : float, optional
        Headings before and after [rad]; None where the path's own will do.
    """
    arcs, speeds = speed_profile(path, limits)
    spans = np.diff(arcs)
    seconds = 2.0 * spans / np.maximum(speeds[1:] + speeds[:-1], 1e-9)
    times = np.concatenate(([0.0], np.cumsum(seconds)))
    for arc, angle in _turns(path, start_yaw, goal_yaw):
        pause = turn_duration(angle, limits)
        if pause <= 0.0:
            continue
        at = int(np.searchsorted(arcs, arc - 1e-9))
        arcs = np.insert(arcs, at, arcs[at])
        times = np.concatenate((times[:at + 1], times[at:] + pause))
    return Timing(arcs, times)


def _turns(path: Polyline, start_yaw: Optional[float], goal_yaw: Optional[float]) -> List[Tuple[float, float]]:
    turns = []
    moves = path.length > 0.0
    if start_yaw is not None and (moves or goal_yaw is not None):
        target = path.heading(0.0) if moves else goal_yaw
        assert target is not None
        turns.append((0.0, wrap_angle(target - start_yaw)))
    turns += list(zip(*turning_points(path)))
    if goal_yaw is not None and moves:
        turns.append((path.length, wrap_angle(goal_yaw - path.heading(path.length))))
    return turns


def _bends(path: Polyline) -> np.ndarray:
    """Signed change of heading at every inner vertex [rad]."""
    if len(path.points) < 3:
        return np.zeros(0)
    changes = np.diff(path.segment_headings)
    return (changes + np.pi) % (2.0 * np.pi) - np.pi
