"""The last resort: nothing may stand in the braking path, whatever schedules, maps and other robots say."""

from typing import Optional, Sequence

import numpy as np
from numba import njit

from social_fleet.errors import InvalidParameter
from social_fleet.geometry import Polyline, Pose

_SKIN = 0.02  # what is nearer to a robot that drives straight on is in its way [m]
_NEARER = 0.01  # by which a robot that has come too near may come nearer yet as it drives past, ... [m]
_LEAST = 0.01  # ... and what it keeps in any case [m]
_STEP = 0.05  # between the places on the path that are looked at [m]


class LidarStop:
    """Finds how far a robot may drive along its path by what its lidar sees.

    Parameters
    ----------
    radius : float
        Of the robot's disc [m].
    margin : float
        What is nearer to the swept disc than this is in the way [m].
    standoff : float
        How far before the place where it would come so near the robot is to stand [m]: it has to get round from there.
    reach : float
        How far ahead to look along the path [m]; at least the braking distance at top speed.

    Raises
    ------
    InvalidParameter
        When a length is not positive.
    """

    def __init__(self, radius: float, *, margin: float = 0.03, standoff: float = 0.12,
                 reach: float = 3.0) -> None:
        for value, field in ((radius, "radius"), (margin, "margin"), (standoff, "standoff"), (reach, "reach")):
            if not value > 0.0:
                raise InvalidParameter(f"must be positive, not {value!r}", field=field)
        self.radius = radius
        self.margin = margin
        self.standoff = standoff
        self.reach = reach
        self._path: Optional[Polyline] = None
        self._places = np.zeros((0, 2))
        self._spacing = _STEP

    def follow(self, path: Polyline) -> None:
        """Look along this path from now on."""
        self._path = path
        count = max(int(np.ceil(path.length / _STEP)), 1)
        self._spacing = path.length / count
        self._places = path.position(np.linspace(0.0, path.length, count + 1))

    def horizon(self, points: np.ndarray, arc_length: float, pose: Pose) -> float:
        """The arc length that must not be passed [m], less than `arc_length` where the robot must not move at all.

        Infinite when all is free within reach.

        Parameters
        ----------
        points : (N, 2) array
            What was hit [m, map frame, by the robot's own pose], without what the map explains.
        arc_length : float
            Where the robot is on its path [m].
        pose : Pose
            Where it is [m, rad, map frame]: what is nearer to it than the margin already it may drive past, no nearer.
        """
        if self._path is None or not len(points) or self._spacing <= 0.0:
            return float("inf")
        first = min(max(int(arc_length / self._spacing), 0), len(self._places) - 1)
        last = min(first + int(self.reach / self._spacing) + 2, len(self._places))
        free = _first_blocked(self._places[first:last], np.ascontiguousarray(points, dtype=float), pose.x, pose.y,
                              self.radius, self.margin)
        return float("inf") if free < 0 else (first + free) * self._spacing - self.standoff

    def ahead(self, points: np.ndarray, pose: Pose) -> float:
        """How far the robot could drive straight on [m]; infinite when all is free within reach.

        For motion that is not along the path: on the way back to it, and where the robot is not where it ought to be.
        """
        if not len(points):
            return float("inf")
        return float(_free_ahead(np.ascontiguousarray(points, dtype=float), pose.x, pose.y, pose.yaw,
                                 self.radius, _SKIN))


def points_of_scan(ranges: Sequence[float], angles: Sequence[float], pose: Pose, *, range_max: float) -> np.ndarray:
    """What a scan hit, (N, 2) [m, map frame].

    Parameters
    ----------
    ranges, angles : (B,) arrays
        Of the beams [m], and their directions in the sensor's frame [rad]. Ranges that are not finite, not positive or
        beyond `range_max` are no hits (REP 117).
    pose : Pose
        Of the sensor [m, rad, map frame].
    """
    distances, directions = np.asarray(ranges, dtype=float), np.asarray(angles, dtype=float) + pose.yaw
    hit = np.isfinite(distances) & (distances > 0.0) & (distances <= range_max)
    distances, directions = distances[hit], directions[hit]
    return np.stack((pose.x + distances * np.cos(directions), pose.y + distances * np.sin(directions)), axis=1)


@njit(cache=True)
def _free_ahead(points, x, y, yaw, body, skin):  # type: ignore[no-untyped-def]
    cos, sin = np.cos(yaw), np.sin(yaw)
    free = np.inf
    for point in range(len(points)):
        dx, dy = points[point, 0] - x, points[point, 1] - y
        radius = body + min(max(np.sqrt(dx * dx + dy * dy) - body - _NEARER, 0.5 * _LEAST), skin)
        along, across = cos * dx + sin * dy, cos * dy - sin * dx
        if along > 0.0 and abs(across) < radius:
            free = min(free, max(along - np.sqrt(radius * radius - across * across), 0.0))
    return free


@njit(cache=True)
def _first_blocked(places, points, x, y, radius, margin):  # type: ignore[no-untyped-def]
    """The first of `places` where a point is too near and not being left behind; -1 when there is none."""
    found = -1
    for point in range(len(points)):
        present = np.sqrt((points[point, 0] - x) ** 2 + (points[point, 1] - y) ** 2) - radius
        square = (radius + min(max(present - _NEARER, _LEAST), margin)) ** 2
        before = np.inf
        limit = len(places) if found < 0 else found
        for place in range(limit):
            gap = (places[place, 0] - points[point, 0]) ** 2 + (places[place, 1] - points[point, 1]) ** 2
            if gap < square and gap < before and place + 1 < len(places):
                ahead = (places[place + 1, 0] - points[point, 0]) ** 2 + (places[place + 1, 1] - points[point, 1]) ** 2
                if ahead < gap or place > 0:
                    found = place
                    break
            before = gap
    return found
