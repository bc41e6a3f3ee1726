"""The smooth curve that is driven along a planned polyline, and how fast; doc/execution.md has the derivation.

Timing and tracking share it, so that what is scheduled is what can be driven.
"""

from dataclasses import dataclass
from typing import List, Sequence, Tuple

import numpy as np

from social_fleet.coordination.robot import MotionLimits
from social_fleet.geometry import Polyline

CUT = 0.01
"""How far the curve may leave the polyline [m]."""

_HALF_WIDTHS = (0.02, 0.04, 0.08, 0.12, 0.18, 0.24, 0.3)  # of the averaging, to choose from [m]
_STEP = 0.02  # spacing of samples [m]
_FEWEST = 4  # steps of a leg, however short: the speed is zero at both ends only
_WIDENING = 0.5  # change of the half width per arc length at most [-]
_LEAST_SHARE = 0.2  # of the turn acceleration that is left for acceleration along a bend


@dataclass(frozen=True)
class DrivenLeg:
    """The curve between two stops, in even samples, at least two.

    Position is the average of the polyline around an arc length, with weights that fall linearly to both sides, so
    that the curvature changes gradually, as a turn rate does. The average is as wide as leaves the polyline by `CUT`
    at most, and of no width at the stops.

    Attributes
    ----------
    arc_lengths : (M,) array
        Along the polyline [m].
    points : (M, 2) array
        Positions [m].
    headings : (M,) array
        Directions of travel without jumps [rad].
    """

    arc_lengths: np.ndarray
    points: np.ndarray
    headings: np.ndarray

    @property
    def step(self) -> float:
        """Spacing of the samples [m]; positive even for a path of one point."""
        return max(float(self.arc_lengths[1] - self.arc_lengths[0]), 1e-9)

    def permitted_speeds(self, limits: MotionLimits, *, moving: bool = False) -> np.ndarray:
        """The fastest speeds at the samples [m/s], from standstill, or already `moving`, to standstill, shape (M,).

        With curvature k and its change k' along the curve, the turn rate is k v and its acceleration k' v^2 + k a.
        """
        bends = np.abs(np.gradient(self.headings, self.step)) + 1e-9
        changes = np.abs(np.gradient(np.gradient(self.headings, self.step), self.step)) + 1e-9
        squares = np.minimum(limits.max_speed ** 2, np.minimum((limits.max_turn_rate / bends) ** 2,
                                                               limits.max_turn_acceleration / changes))
        squares[-1] = 0.0
        if not moving:
            squares[0] = 0.0
        spare = np.maximum(limits.max_turn_acceleration - changes * squares,
                           _LEAST_SHARE * limits.max_turn_acceleration) / bends
        gains = 2.0 * self.step * np.minimum(limits.max_acceleration, spare)
        rise = np.concatenate(([0.0], np.cumsum(0.5 * (gains[1:] + gains[:-1]))))
        return np.sqrt(np.maximum(_limit_slope(squares, rise), 0.0))


def driven_legs(path: Polyline, turns: Sequence[float]) -> List[DrivenLeg]:
    """The curve along `path`, one leg between every two stops.

    Parameters
    ----------
    path : Polyline
        The planned path [m].
    turns : sequence of float
        Arc lengths of the vertices that are turned at in place [m].
    """
    ends = [0.0, *turns, path.length]
    integrals = _Integrals(path)
    return [_leg(path, integrals, low, high) for low, high in zip(ends, ends[1:])]


def _leg(path: Polyline, integrals: "_Integrals", low: float, high: float) -> DrivenLeg:
    count = max(_FEWEST, int(np.ceil((high - low) / _STEP)))
    arcs = np.linspace(low, high, count + 1)
    own = path.position(arcs)
    if high <= low:
        return DrivenLeg(arcs, own, np.zeros(len(arcs)))
    points = own.copy()
    bent = integrals.bent(arcs)  # on straight stretches the average is the path itself
    half_widths = np.full(len(arcs), _HALF_WIDTHS[-1])
    half_widths[bent] = _widest(integrals, arcs[bent], own[bent])
    half_widths[0] = half_widths[-1] = 0.0
    half_widths = _limit_slope(half_widths, _WIDENING * (arcs - arcs[0]))
    points[bent] = integrals.average(arcs[bent], half_widths[bent], own[bent])
    directions = np.gradient(points, axis=0)
    headings = np.unwrap(np.arctan2(directions[:, 1], directions[:, 0]))
    departure, arrival = path.heading(low), path.segment_headings[max(path.segment_index(high - 1e-9), 0)]
    headings[0] = headings[1] + _difference(departure, headings[1])
    headings[-1] = headings[-2] + _difference(arrival, headings[-2])
    return DrivenLeg(arcs, points, headings)


def _widest(integrals: "_Integrals", arcs: np.ndarray, own: np.ndarray) -> np.ndarray:
    """The widest averaging at each arc length that leaves the path by `CUT` at most [m], 0 where none does."""
    chosen = np.zeros(len(arcs))
    for half_width in _HALF_WIDTHS:
        averages = integrals.average(arcs, np.full(len(arcs), half_width), own)
        chosen = np.where(np.hypot(*(averages - own).T) <= CUT, half_width, chosen)
    return chosen


def _limit_slope(values: np.ndarray, rise: np.ndarray) -> np.ndarray:
    """The largest values, nowhere above the given ones, that change no faster than `rise` does along the array."""
    forward = np.minimum.accumulate(values - rise) + rise
    return (np.minimum.accumulate((forward + rise)[::-1])[::-1]) - rise


class _Integrals:
    """A polyline integrated twice over its arc length: averages weighted by triangles in three look-ups."""

    def __init__(self, path: Polyline) -> None:
        self._arcs = path.arc_lengths[:-1]
        self._points = path.points[:-1]
        steps = np.diff(path.points, axis=0)
        lengths = np.diff(path.arc_lengths)[:, None]
        self._tangents = steps / lengths
        first = self._points * lengths + 0.5 * self._tangents * lengths ** 2
        self._first = np.vstack([np.zeros((1, 2)), np.cumsum(first, axis=0)[:-1]])
        second = self._first * lengths + self._points * lengths ** 2 / 2.0 + self._tangents * lengths ** 3 / 6.0
        self._second = np.vstack([np.zeros((1, 2)), np.cumsum(second, axis=0)[:-1]])

    def bent(self, arcs: np.ndarray) -> np.ndarray:
        """Which of `arcs` (M,) have a vertex within the widest averaging."""
        vertices = self._arcs[1:]
        low, high = np.searchsorted(vertices, [arcs - _HALF_WIDTHS[-1] - 1e-6, arcs + _HALF_WIDTHS[-1] + 1e-6])
        return high > low

    def average(self, arcs: np.ndarray, half_widths: np.ndarray, own: np.ndarray) -> np.ndarray:
        """Averages (M, 2) around `arcs`; `own`, the positions there, where a half width vanishes."""
        wide = half_widths > 1e-3
        averages = own.copy()
        at, reach = arcs[wide], half_widths[wide]
        sums = self._at(at + reach) - 2.0 * self._at(at) + self._at(at - reach)
        averages[wide] = sums / (reach ** 2)[:, None]
        return averages

    def _at(self, arcs: np.ndarray) -> np.ndarray:
        """The second integral (M, 2); straight on beyond the ends."""
        index = np.clip(np.searchsorted(self._arcs, arcs, side="right") - 1, 0, None)
        offset = (arcs - self._arcs[index])[:, None]
        return (self._second[index] + offset * (self._first[index] + offset * (
            self._points[index] / 2.0 + offset * self._tangents[index] / 6.0)))


def _difference(heading: float, other: float) -> float:
    """`heading` minus `other` within half a turn [rad]."""
    return (heading - other + np.pi) % (2.0 * np.pi) - np.pi


def sampled(legs: Sequence[DrivenLeg], speeds: Sequence[np.ndarray], spacing: float) -> Tuple[np.ndarray, np.ndarray]:
    """Arc lengths and speeds of all legs in one list, thinned to about `spacing` [m], the slowest of each thinned run.

    A stop between two legs is there once.
    """
    arcs: List[float] = [0.0]
    chosen: List[float] = [0.0]
    for leg, along in zip(legs, speeds):
        if leg.arc_lengths[-1] == leg.arc_lengths[0]:
            continue
        every = max(1, int(round(spacing / leg.step)))
        picks = np.arange(min(every, len(along) // 2), len(along) - 1, every)
        arcs += [*leg.arc_lengths[picks], leg.arc_lengths[-1]]
        chosen += [*along[picks], along[-1]]
    return np.array(arcs), np.array(chosen)
