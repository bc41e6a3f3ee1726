"""Small fleets for tests of coordination, and an independent look at what two robots do."""

from typing import Any, List, Sequence

import numpy as np

from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import Schedule


def robot(name: str, *points: Sequence[float], **limits: Any) -> Robot:
    """A robot on the path through `points` [m]."""
    return Robot(name, np.array(points, dtype=float), **limits)


def street_fleet(count: int, seed: int) -> List[Robot]:
    """Robots on a grid of streets 10 m apart: along a column to the street, along it, along a column to the goal.

    Speeds 0.2-1.2 m/s, radii 0.2-0.4 m; starts, and goals, are at least 1 m apart, so that no two discs touch.
    """
    rng = np.random.RandomState(seed)
    starts, goals = _places(count, rng), _places(count, rng)
    fleet = []
    for index, (start, goal) in enumerate(zip(starts, goals)):
        street = 10.0 * round(start[1] / 10.0)
        fleet.append(robot(f"robot_{index:02d}", start, (start[0], street), (goal[0], street), goal,
                           max_speed=rng.uniform(0.2, 1.2), radius=rng.uniform(0.2, 0.4)))
    return fleet


def random_path(rng: np.random.RandomState, vertices: int, size: float) -> np.ndarray:
    """Vertices anywhere in a square [m]: crossings with others and with itself, U-turns, shared corners."""
    points = rng.uniform(0.0, size, (vertices, 2))
    if rng.rand() < 0.5:
        points = np.round(points)
        points[1::2, 0] = points[0:len(points) - 1:2, 0][:len(points[1::2])]
    return points


def smallest_distance(r: Schedule, s: Schedule, step: float = 0.01) -> float:
    """Distance between two robots' centres [m], sampled densely over all time."""
    times = np.arange(min(r.times[0], s.times[0]) - step, max(r.times[-1], s.times[-1]) + 2.0 * step, step)
    return float(np.hypot(*(r.position(times) - s.position(times)).T).min())


def _places(count: int, rng: np.random.RandomState) -> np.ndarray:
    places: List[np.ndarray] = []
    while len(places) < count:
        place = rng.randint(0, 41, 2).astype(float)
        if all(np.hypot(*(place - other)) >= 1.0 for other in places):
            places.append(place)
    return np.array(places)
