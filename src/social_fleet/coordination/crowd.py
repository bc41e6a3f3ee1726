"""Robots of a fleet that drive one at a time: who stands where, who still has to arrive, and who is in whose way."""

from typing import List, Sequence, Union

import numpy as np

from social_fleet.coordination.robot import Robot
from social_fleet.geometry import Polyline
from social_fleet.planning.overlays.discs import Disc

ROOM = 0.12
"""Kept beyond the safety distance: more than a link, so that windows end where robots stand [m]."""


class Crowd:
    """The fleet between two turns.

    Parameters
    ----------
    robots : sequence of Robot
        With the paths that they would like to drive.
    planned : int
        How many of them have to arrive yet; the rest are settled.
    distances : (R, R) array
        What each two of them keep between their centres [m].

    Attributes
    ----------
    places, goals : (R, 2) arrays
        Where each stands and where it is to arrive [m].
    waiting : list of int
        Those that have to arrive yet.
    aside : (R,) bool array
        Who stands at a place to wait.
    ways : list of Polyline
        How each would drive on to its goal.
    turns : int
        How often one has moved so far.
    changes : list of int
        How often each has moved or got another way.
    """

    def __init__(self, robots: Sequence[Robot], planned: int, distances: np.ndarray) -> None:
        self.robots = list(robots)
        self.distances = distances
        self.places = np.array([robot.path.points[0] for robot in robots])
        self.goals = np.array([robot.path.points[-1] for robot in robots])
        self.waiting: List[int] = list(range(planned))
        self.aside = np.zeros(len(robots), dtype=bool)
        self.ways: List[Polyline] = [robot.path for robot in robots]
        self.turns = 0
        self.changes = [0] * len(robots)
        self._near = np.array([gaps(way, self.places) for way in self.ways])  # of every way to every place [m] ...
        self._ends = np.array([gaps(way, self.goals) for way in self.ways])  # ... and to every goal

    def move(self, robot: int, place: np.ndarray, *, aside: bool = False) -> None:
        """Let a robot stand elsewhere from now on."""
        self.places[robot] = place
        self.aside[robot] = aside
        self.turns += 1
        self.changes[robot] += 1
        self._near[:, robot] = [gaps(way, place[None])[0] for way in self.ways]

    def lead(self, robot: int, way: Polyline) -> None:
        """Let a robot drive another way from where it stands."""
        self.ways[robot] = way
        self.changes[robot] += 1
        self._near[robot] = gaps(way, self.places)
        self._ends[robot] = gaps(way, self.goals)

    def recall(self, robot: int) -> None:
        """Let one that has arrived count as still to arrive: it may make way, and drive back."""
        self.waiting = sorted([*self.waiting, robot])
        self.lead(robot, Polyline(self.goals[[robot]]))

    def passing(self, robot: int, places: np.ndarray) -> np.ndarray:
        """How many of the others' ways lead past some places too near for a robot to stand there (M,)."""
        counts = np.zeros(len(places), dtype=int)
        for other in self.waiting:
            if other != robot:
                counts += gaps(self.ways[other], places) < self.distances[robot, other] + ROOM
        return counts

    def blocked(self) -> np.ndarray:
        """Whose way who stands in now (R, R): row by row, the others in the way of one that still has to arrive."""
        return self._within(self._near, np.where(self.aside, ROOM, 0.0))

    def harms(self) -> np.ndarray:
        """Whose way whose goal is in (R, R), likewise."""
        return self._within(self._ends)

    def is_blocked_by(self, waiting: int) -> bool:
        """Whether one of the rest would have to wait for one of the first so many to make way."""
        return bool((self._near < self.distances)[waiting:, :waiting].any())

    def _within(self, found: np.ndarray, more: Union[float, np.ndarray] = 0.0) -> np.ndarray:
        near = (found < self.distances + more) & ~np.eye(len(self.robots), dtype=bool)
        near[self.settled()] = False
        return near

    def settled(self) -> List[int]:
        """Those that stand at their goals for good."""
        return [robot for robot in range(len(self.robots)) if robot not in self.waiting]

    def others(self, robot: int) -> List[int]:
        """All but one."""
        return [other for other in range(len(self.robots)) if other != robot]

    def disc(self, robot: int, other: int, place: np.ndarray) -> Disc:
        """What a robot keeps out of when another stands at a place."""
        return Disc(float(place[0]), float(place[1]), float(self.distances[robot, other] + ROOM))


def gaps(way: Polyline, places: np.ndarray) -> np.ndarray:
    """Distances of some places from a way (M,) [m]."""
    if len(way.points) == 1:
        return np.hypot(*(places - way.points[0]).T)
    starts, steps = way.points[:-1], np.diff(way.points, axis=0)
    offsets = places[:, None] - starts
    shares = np.einsum("pij,ij->pi", offsets, steps) / np.einsum("ij,ij->i", steps, steps)
    nearest = offsets - np.clip(shares, 0.0, 1.0)[:, :, None] * steps
    return np.hypot(nearest[:, :, 0], nearest[:, :, 1]).min(axis=1)
