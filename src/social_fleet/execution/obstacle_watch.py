"""From what a lidar hits to obstacles with names: what stands still long enough is one, until it is seen to be gone."""

import math
from dataclasses import dataclass
from typing import Callable, Dict, Iterator, List, Mapping, Sequence, Tuple

import numpy as np

from social_fleet.geometry import Pose
from social_fleet.planning.overlays.shapes import DiscObstacle

_GAP = 0.4  # hits farther apart belong to two things [m]
_SMALLEST = 0.1  # radius of an obstacle [m]
_SAME = 0.3  # a thing whose middle has moved by less stands still [m]
_CHANGED = 0.1  # an obstacle that shows itself so much wider, or farther aside, is described anew [m]
_BESIDE = 0.15  # hits so close to an obstacle belong to it [m]
_LEARNING = 0.3  # weight of a new look at a thing
_TOLD = 10.0  # how long it is said that an obstacle is gone, for messages get lost [s]


@dataclass
class _Thing:
    """A disc about neighbouring hits: since when it has stood there, and when it was last seen [s]."""

    x: float
    y: float
    radius: float
    since: float
    seen: float


class ObstacleWatch:
    """One robot's obstacles.

    Parameters
    ----------
    name : str
        Begins the names of its obstacles: the robot's, and what no earlier program of it has used, for a name that was
        seen to be gone is never taken up again.
    settle : float
        How long something has to stand still, or a place to be seen empty, before that counts [s].
    reach : float
        How far from the robot to look [m].

    Attributes
    ----------
    obstacles : dict of str to DiscObstacle
        What it has seen.
    cleared : tuple of str
        What it has lately seen to be gone, of whoever's obstacles.
    """

    def __init__(self, name: str, *, settle: float = 2.0, reach: float = 3.0) -> None:
        self.obstacles: Dict[str, DiscObstacle] = {}
        self._name = name
        self._settle = settle
        self._reach = reach
        self._things: List[_Thing] = []
        self._count = 0
        self._cleared: Dict[str, float] = {}
        self._empty_since: Dict[str, float] = {}

    @property
    def cleared(self) -> Tuple[str, ...]:
        """See the class."""
        return tuple(self._cleared)

    def see(self, now: float, pose: Pose, points: np.ndarray, known: Mapping[str, DiscObstacle],
            visible: Callable[[DiscObstacle], bool]) -> None:
        """Take in one scan.

        Parameters
        ----------
        now : float
            [s].
        pose : Pose
            Where the robot takes itself to be [m, rad, map frame].
        points : (N, 2) array
            Hits [m, map frame] in the order of the beams, without those that the map or other robots explain.
        known : mapping of str to DiscObstacle
            The fleet's obstacles.
        visible : callable
            Whether the robot would see an obstacle if it were still there.
        """
        near = points[np.hypot(points[:, 0] - pose.x, points[:, 1] - pose.y) <= self._reach] if len(points) else points
        self._notice(now, pose, near, known)
        self._miss(now, pose, near, {**known, **self.obstacles}, visible)
        self._cleared = {name: when for name, when in self._cleared.items() if now - when <= _TOLD}

    def forget(self, names: Sequence[str]) -> None:
        """Others have seen that these are gone."""
        for name in names:
            self.obstacles.pop(name, None)

    def _notice(self, now: float, pose: Pose, points: np.ndarray, known: Mapping[str, DiscObstacle]) -> None:
        for x, y, radius in _discs(pose, points):
            thing = min((thing for thing in self._things if math.hypot(thing.x - x, thing.y - y) <= _SAME),
                        key=lambda thing: math.hypot(thing.x - x, thing.y - y), default=None)
            if thing is None:
                self._things.append(_Thing(x, y, radius, now, now))
                continue
            thing.seen = now
            thing.x, thing.y, thing.radius = (old + _LEARNING * (new - old) for old, new in (
                (thing.x, x), (thing.y, y), (thing.radius, radius)))
            if now - thing.since >= self._settle:
                self._name_it(thing, known)
        self._things = [thing for thing in self._things if now - thing.seen <= self._settle]

    def _name_it(self, thing: _Thing, known: Mapping[str, DiscObstacle]) -> None:
        """Make an obstacle of what has stood still, unless there is one that covers it."""
        for name, shape in {**known, **self.obstacles}.items():
            aside = math.hypot(shape.x - thing.x, shape.y - thing.y)
            own = name in self.obstacles and aside <= _SAME
            if aside + abs(thing.radius - shape.radius) <= _CHANGED or (not own and aside + thing.radius
                                                                        <= shape.radius + _CHANGED):
                return
            if own:
                self.obstacles[name] = DiscObstacle(thing.x, thing.y, thing.radius)
                return
        self._count += 1
        self.obstacles[f"{self._name}/{self._count}"] = DiscObstacle(thing.x, thing.y, thing.radius)

    def _miss(self, now: float, pose: Pose, points: np.ndarray, known: Mapping[str, DiscObstacle],
              visible: Callable[[DiscObstacle], bool]) -> None:
        """Obstacles that ought to be seen and are not."""
        for name, shape in known.items():
            if name in self._cleared:
                self.obstacles.pop(name, None)
                continue
            away = math.hypot(shape.x - pose.x, shape.y - pose.y) - shape.radius
            there = len(points) and (np.hypot(points[:, 0] - shape.x, points[:, 1] - shape.y)
                                     <= shape.radius + _BESIDE).any()
            if away > self._reach or there or not visible(shape):
                self._empty_since.pop(name, None)
            elif now - self._empty_since.setdefault(name, now) >= self._settle:
                self._cleared[name] = now
                self._empty_since.pop(name)
                self.obstacles.pop(name, None)
        self._empty_since = {name: since for name, since in self._empty_since.items() if name in known}


def _discs(pose: Pose, points: np.ndarray) -> Iterator[Tuple[float, float, float]]:
    """Discs (x, y, radius) [m] about runs of neighbouring hits, as seen from `pose`.

    Of a disc at distance d to its surface, seen under the angle 2 a, the radius is d sin a / (1 - sin a). What is flat
    is no disc: one half as wide again as the run is the largest that is taken for it.
    """
    if not len(points):
        return
    gaps = np.hypot(*np.diff(points, axis=0).T)
    for run in np.split(points, np.flatnonzero(gaps > _GAP) + 1):
        rays = run - (pose.x, pose.y)
        distances = np.hypot(rays[:, 0], rays[:, 1])
        bearings = np.arctan2(rays[:, 1], rays[:, 0])
        turns = (bearings - bearings[0] + math.pi) % (2.0 * math.pi) - math.pi
        sine = min(math.sin(0.5 * min(float(turns.max() - turns.min()), math.pi)), 0.95)
        width = float(np.hypot(*(run[-1] - run[0])))
        radius = max(min(float(distances.min()) * sine / (1.0 - sine), 0.75 * width), _SMALLEST)
        middle = float(bearings[0] + 0.5 * (turns.max() + turns.min()))
        away = float(distances.min()) + radius
        yield pose.x + away * math.cos(middle), pose.y + away * math.sin(middle), radius
