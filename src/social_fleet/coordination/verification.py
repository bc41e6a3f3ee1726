"""The independent judge of schedules: how close any two discs come, over all time.

Every schedule is motion in straight lines between breaks (its knots, and the moments at which it passes a vertex of its
path), standing before the first and after the last. Between the breaks of two robots their offset is linear in time, so
its smallest length has a closed form. Nothing here comes from the search for encounter windows.
"""

import itertools
from dataclasses import dataclass
from typing import Iterable, List, Sequence, Tuple, Union

import numpy as np

from social_fleet.coordination.schedule import FleetSchedule, Schedule

Passage = Tuple[str, str, float, float]


@dataclass(frozen=True)
class ClearanceReport:
    """Smallest clearance, surface to surface, of every pair of robots.

    Attributes
    ----------
    pairs : tuple of (name, name, clearance, time)
        The clearance [m], negative where discs overlap, and when it is reached first [s]; worst first.
    """

    pairs: Tuple[Passage, ...]

    @property
    def min_clearance(self) -> float:
        """The smallest clearance of all [m]; infinite for fewer than two robots."""
        return self.pairs[0][2] if self.pairs else float("inf")

    @property
    def safe(self) -> bool:
        """Whether no two discs overlap at any time."""
        return self.min_clearance >= 0.0


def verify(fleet: Union[FleetSchedule, Sequence[Schedule]]) -> ClearanceReport:
    """Check schedules for contact, all pairs and all times from minus to plus infinity.

    Parameters
    ----------
    fleet
        A coordinated fleet, or any schedules on one clock.

    Returns
    -------
    ClearanceReport
    """
    schedules: Iterable[Schedule] = fleet.schedules if isinstance(fleet, FleetSchedule) else fleet
    tracks = [(schedule.name, schedule.robot.body_radius) + _track(schedule) for schedule in schedules]
    pairs: List[Passage] = []
    for (r, r_radius, r_times, r_points), (s, s_radius, s_times, s_points) in itertools.combinations(tracks, 2):
        distance, when = _closest_approach(r_times, r_points, s_times, s_points)
        pairs.append((r, s, distance - r_radius - s_radius, when))
    return ClearanceReport(tuple(sorted(pairs, key=lambda pair: (pair[2], pair[:2]))))


def _track(schedule: Schedule) -> Tuple[np.ndarray, np.ndarray]:
    """Times [s] and positions [m] of the breaks of a schedule's motion."""
    path = schedule.robot.path
    arcs, times = schedule.arc_lengths, schedule.times
    breaks = [times]
    for low, high, start, end in zip(arcs[:-1], arcs[1:], times[:-1], times[1:]):
        passed = path.arc_lengths[np.searchsorted(path.arc_lengths, low, "right"):
                                  np.searchsorted(path.arc_lengths, high, "left")]
        if len(passed):
            breaks.append(start + (passed - low) / (high - low) * (end - start))
    moments = np.unique(np.concatenate(breaks))
    along = np.interp(moments, times, arcs)
    return moments, np.stack([np.interp(along, path.arc_lengths, path.points[:, axis]) for axis in (0, 1)], axis=1)


def _closest_approach(r_times: np.ndarray, r_points: np.ndarray,
                      s_times: np.ndarray, s_points: np.ndarray) -> Tuple[float, float]:
    """Smallest distance between two tracks [m], and its first time [s]."""
    moments = np.unique(np.concatenate((r_times, s_times)))
    offsets = np.stack([np.interp(moments, r_times, r_points[:, axis]) - np.interp(moments, s_times, s_points[:, axis])
                        for axis in (0, 1)], axis=1)
    distances = np.hypot(offsets[:, 0], offsets[:, 1])
    best = int(np.argmin(distances))
    smallest, when = float(distances[best]), float(moments[best])
    steps = np.diff(offsets, axis=0)
    squares = np.einsum("ij,ij->i", steps, steps)
    moving = squares > 0.0
    if not moving.any():
        return smallest, when
    share = np.clip(-np.einsum("ij,ij->i", offsets[:-1], steps)[moving] / squares[moving], 0.0, 1.0)
    nearest = offsets[:-1][moving] + share[:, None] * steps[moving]
    distances = np.hypot(nearest[:, 0], nearest[:, 1])
    best = int(np.argmin(distances))
    if distances[best] < smallest:
        smallest = float(distances[best])
        when = float(moments[:-1][moving][best] + share[best] * np.diff(moments)[moving][best])
    return smallest, when
