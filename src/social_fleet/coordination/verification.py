"""The independent judge of schedules: how close any two discs come, over all time.

Every schedule is motion in straight lines between breaks (its knots, and the moments at which it passes a vertex of its
path), standing before the first and after the last. Between the breaks of two robots their offset is linear in time, so
its smallest length has a closed form. Nothing here comes from the search for encounter windows.
"""

import itertools
from dataclasses import dataclass
from typing import Iterable, List, Sequence, Tuple, Union

import numpy as np
from numba import njit

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
    vertices = path.arc_lengths[(path.arc_lengths > arcs[0]) & (path.arc_lengths < arcs[-1])]
    knot = np.searchsorted(arcs, vertices, side="right") - 1  # the last one not beyond the vertex
    share = (vertices - arcs[knot]) / (arcs[knot + 1] - arcs[knot])
    moments = np.unique(np.concatenate((times, times[knot] + share * (times[knot + 1] - times[knot]))))
    along = np.interp(moments, times, arcs)
    return moments, np.stack([np.interp(along, path.arc_lengths, path.points[:, axis]) for axis in (0, 1)], axis=1)


@njit(cache=True)
def _closest_approach(r_times, r_points, s_times, s_points):  # type: ignore[no-untyped-def]
    """Smallest distance between two tracks [m], and its first time [s]: break by break of either, in closed form."""
    r, s = 0, 0
    time = min(r_times[0], s_times[0])
    x, y = r_points[0, 0] - s_points[0, 0], r_points[0, 1] - s_points[0, 1]
    smallest, when = x * x + y * y, time
    while r < len(r_times) or s < len(s_times):
        upcoming = np.inf
        if r < len(r_times):
            upcoming = r_times[r]
        if s < len(s_times):
            upcoming = min(upcoming, s_times[s])
        r_x, r_y = _position(r_times, r_points, r, upcoming)
        s_x, s_y = _position(s_times, s_points, s, upcoming)
        step_x, step_y = r_x - s_x - x, r_y - s_y - y
        square = step_x * step_x + step_y * step_y
        share = 1.0
        if square > 0.0:
            share = min(max(-(x * step_x + y * step_y) / square, 0.0), 1.0)
        near_x, near_y = x + share * step_x, y + share * step_y
        if near_x * near_x + near_y * near_y < smallest:
            smallest, when = near_x * near_x + near_y * near_y, time + share * (upcoming - time)
        x, y, time = r_x - s_x, r_y - s_y, upcoming
        while r < len(r_times) and r_times[r] <= upcoming:
            r += 1
        while s < len(s_times) and s_times[s] <= upcoming:
            s += 1
    return np.sqrt(smallest), when


@njit(cache=True)
def _position(times, points, upcoming, time):  # type: ignore[no-untyped-def]
    """Where a track is at `time`, whose break `upcoming` is the first not before it; it stands before and after all."""
    if upcoming == 0:
        return points[0, 0], points[0, 1]
    if upcoming == len(times):
        return points[upcoming - 1, 0], points[upcoming - 1, 1]
    share = (time - times[upcoming - 1]) / (times[upcoming] - times[upcoming - 1])
    return (points[upcoming - 1, 0] + share * (points[upcoming, 0] - points[upcoming - 1, 0]),
            points[upcoming - 1, 1] + share * (points[upcoming, 1] - points[upcoming - 1, 1]))
