"""Clearances and arrivals computed from true poses alone, by code that shares nothing with what moved the robots."""

import math
from typing import List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from social_fleet.coordination.robot import Robot
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.recording import Recording
from social_fleet.simulation.faults import CircleObstacle

TOUCH = 1e-6  # overlaps up to this are rounding [m]
_WALL_SIGHT = 0.5  # clearances to walls are told up to this [m]
_SPACING = 0.01  # of the points on a robot's way where walls are looked for [m]


class Contact(NamedTuple):
    """One stretch of time in which two discs, or a disc and a wall, overlapped."""

    kind: str  # "robots", "wall" or "obstacle"
    robots: Tuple[str, ...]
    time: float  # when it was worst [s]
    clearance: float  # then, surface to surface [m], negative
    position: Tuple[float, float]  # of the first robot then [m]


def pair_clearance(recording: Recording, first: int, second: int, radii: float) -> np.ndarray:
    """Smallest distance of two robots' surfaces within each interval [m], shape (T - 1,), or (1,) of one sample.

    Both move straight and evenly from sample to sample.

    Parameters
    ----------
    first, second : int
        The robots' places in the recording.
    radii : float
        Sum of their radii [m].
    """
    return _least_distance(recording.poses[:, first, :2] - recording.poses[:, second, :2]) - radii


def wall_clearance(recording: Recording, robot: int, radius: float, grid: OccupancyGrid) -> np.ndarray:
    """Smallest distance of a robot's surface to walls, unknown space and the border within each interval [m].

    Shape (T - 1,), or (1,) of one sample; capped at 0.5 m, and never below minus the radius. Looked for at the samples
    and at points between, at most 0.01 m apart: on the way it may be up to 0.005 m less, next to a corner far less.
    """
    points, intervals = _in_steps(recording.poses[:, robot, :2])
    points, places = np.unique(np.round(points, 9), axis=0, return_inverse=True)  # robots stand a lot
    local = grid.to_local(points) / grid.resolution
    limit = (radius + _WALL_SIGHT) / grid.resolution
    distances = _square_distances(grid.blocked, local, limit)[places.ravel()] * grid.resolution
    return np.minimum.reduceat(distances, np.flatnonzero(np.diff(intervals, prepend=-1))) - radius


def obstacle_clearance(recording: Recording, robot: int, radius: float, obstacle: CircleObstacle) -> np.ndarray:
    """Smallest distance of a robot's surface to an obstacle within each interval [m]; infinite while it is absent.

    An interval counts when the obstacle is there at its beginning.
    """
    gaps = _least_distance(recording.poses[:, robot, :2] - (obstacle.x, obstacle.y)) - radius - obstacle.radius
    begins = recording.times[:len(gaps)]
    return np.where((begins >= obstacle.appears) & (begins < obstacle.disappears), gaps, np.inf)


def contacts(recording: Recording, clearances: np.ndarray, kind: str, names: Sequence[str]) -> List[Contact]:
    """The stretches of negative clearance, the worst moment of each."""
    touching = np.pad((clearances < -TOUCH).astype(int), 1, mode="constant")
    begins, ends = np.flatnonzero(np.diff(touching) == 1), np.flatnonzero(np.diff(touching) == -1)
    found = []
    for begin, end in zip(begins, ends):
        worst = int(begin + np.argmin(clearances[begin:end]))
        x, y = recording.poses[worst, recording.index(names[0]), :2]
        found.append(Contact(kind, tuple(names), float(recording.times[worst]), float(clearances[worst]),
                             (float(x), float(y))))
    return found


def arrival_time(recording: Recording, robot: Robot, *, position_tolerance: float,
                 heading_tolerance: float) -> Optional[float]:
    """When the robot came to its goal to stay there [s]; None when it was not there at the end."""
    poses = recording.poses[:, recording.index(robot.name)]
    goal = robot.goal
    there = np.hypot(poses[:, 0] - goal.x, poses[:, 1] - goal.y) <= position_tolerance
    if robot.goal_yaw is not None:
        turn = (poses[:, 2] - goal.yaw + math.pi) % (2.0 * math.pi) - math.pi
        there &= np.abs(turn) <= heading_tolerance
    if not there[-1]:
        return None
    absent = np.flatnonzero(~there)
    return float(recording.times[absent[-1] + 1 if len(absent) else 0])


def tracking_error(recording: Recording, robot: Robot) -> np.ndarray:
    """Distance from the reference [m], shape (T,); from the path where no reference was recorded."""
    index = recording.index(robot.name)
    points = recording.poses[:, index, :2]
    if recording.references is None:
        return np.array([_distance_to_path(robot.path.points, point) for point in points])
    gaps = points - recording.references[:, index]
    return np.nan_to_num(np.hypot(gaps[:, 0], gaps[:, 1]))


def _least_distance(gaps: np.ndarray) -> np.ndarray:
    """Least norm on each straight way between neighbouring rows of `gaps` (T, 2)."""
    if len(gaps) == 1:
        return np.hypot(gaps[:, 0], gaps[:, 1])
    begins, steps = gaps[:-1], np.diff(gaps, axis=0)
    squares = np.maximum((steps ** 2).sum(axis=1), 1e-300)
    shares = np.clip(-(begins * steps).sum(axis=1) / squares, 0.0, 1.0)
    nearest = begins + shares[:, None] * steps
    return np.hypot(nearest[:, 0], nearest[:, 1])


def _distance_to_path(points: np.ndarray, point: np.ndarray) -> float:
    """Distance of `point` from the polyline through `points` [m]."""
    if len(points) == 1:
        return float(np.hypot(*(points[0] - point)))
    return float(_least_distance(points - point).min())


def _in_steps(points: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Points at most `_SPACING` apart on each straight way between neighbours, and which way each one is on."""
    if len(points) == 1:
        return points, np.zeros(1, dtype=int)
    steps = np.diff(points, axis=0)
    counts = np.ceil(np.hypot(steps[:, 0], steps[:, 1]) / _SPACING).astype(int) + 1
    intervals = np.repeat(np.arange(len(steps)), counts)
    places = np.arange(len(intervals)) - np.repeat(np.cumsum(counts) - counts, counts)
    shares = places / np.maximum(counts - 1, 1)[intervals]
    return points[intervals] + shares[:, None] * steps[intervals], intervals


def _square_distances(blocked: np.ndarray, points: np.ndarray, limit: float) -> np.ndarray:
    """Distance [cells] of every point (M, 2) to the nearest blocked closed square, capped at `limit`.

    What lies beyond the map is blocked. All offsets within reach are looked up for all points at once, nearest first.
    """
    reach = int(math.ceil(limit))
    padded = np.pad(blocked, reach + 1, mode="constant", constant_values=True)
    rows, columns = padded.shape
    cells = np.clip(np.floor(points).astype(int) + reach + 1, reach, [columns - reach - 1, rows - reach - 1])
    parts = points - np.floor(points)
    cells, places = np.unique(cells, axis=0, return_inverse=True)
    places = all_places = places.ravel()
    nearest = np.full(len(points), limit)
    offsets = [(i, j) for i in range(-reach, reach + 1) for j in range(-reach, reach + 1)]
    least = {offset: math.hypot(max(abs(offset[0]) - 1, 0), max(abs(offset[1]) - 1, 0)) for offset in offsets}
    open_points = np.arange(len(points))  # those that a square at this offset may still be nearest to
    passed = 0.0
    for i, j in sorted((offset for offset in offsets if least[offset] < limit), key=least.__getitem__):
        blocked_there = padded[cells[:, 1] + j, cells[:, 0] + i]
        if blocked_there.any():
            if least[i, j] > passed:
                passed = least[i, j]
                open_points = open_points[nearest[open_points] > passed]
                places = all_places[open_points]
            hit = open_points[blocked_there[places]]
            aside, above = (np.maximum(np.maximum(offset - parts[hit, axis], parts[hit, axis] - offset - 1.0), 0.0)
                            for axis, offset in enumerate((i, j)))
            nearest[hit] = np.minimum(nearest[hit], np.hypot(aside, above))
    return nearest
