"""Encounter windows: the stretches of two paths where the robots' discs could touch (3.3.1).

For either order of the two robots a window knows what the second has to wait for, point by point: it may be at an arc
length only once the first has passed a matching one and stays clear of it from there on. This is exact for every shape
of window, whatever speeds the robots drive at: see doc/coordination.md.
"""

from dataclasses import dataclass, replace
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np

from social_fleet.coordination.conflict_regions import LINK, Links, conflict_regions, cut_into_links
from social_fleet.coordination.robot import Robot

SHORT = 2.0
"""A window whose arcs are both shorter than this is an intersection [m]."""

_STAIR = 0.5  # how far the first robot's mark may run ahead of what is needed, to save rows [m]
_SETBACK = 1.0  # by which a window that runs along, or against, the other path may depart from that [m]


@dataclass(frozen=True)
class Order:
    """What the second robot waits for in one window when `leader` goes first.

    Attributes
    ----------
    leader, follower : int
        Positions in the fleet.
    at : (K,) array
        Arc lengths of the follower that it may not pass ... [m], ascending.
    clear : (K,) array
        ... before the leader has passed these of its own [m], ascending.
    possible : bool
        False when the leader would have to pass the follower standing at its start, or the follower the leader
        standing at its goal.
    """

    leader: int
    follower: int
    at: np.ndarray
    clear: np.ndarray
    possible: bool


@dataclass(frozen=True)
class Encounter:
    """One window of two robots: its extent on both paths [m], its kind, and both orders.

    `r_ends` and `s_ends` say whether the robot's start, and whether its goal, lie in the other's way.
    """

    r: int
    s: int
    kind: str
    r_extent: Tuple[float, float]
    s_extent: Tuple[float, float]
    r_ends: Tuple[bool, bool]
    s_ends: Tuple[bool, bool]
    r_first: Order
    s_first: Order

    @property
    def orders(self) -> Tuple[Order, Order]:
        """Both orders: r first, then s first."""
        return self.r_first, self.s_first

    def placed(self, r: int, s: int) -> "Encounter":
        """The same window of two robots at other positions in a fleet."""
        return replace(self, r=r, s=s, r_first=replace(self.r_first, leader=r, follower=s),
                       s_first=replace(self.s_first, leader=s, follower=r))


class EncounterFinder:
    """Finds the windows of a fleet, pair by pair, and remembers them until a robot's path changes.

    Parameters
    ----------
    tracking_tolerance : float
        How far a robot may be from where its schedule says [m]; windows keep twice that between two discs.
    """

    def __init__(self, tracking_tolerance: float) -> None:
        self.tolerance = tracking_tolerance
        self._links: Dict[str, Links] = {}
        self._robots: Dict[str, Robot] = {}
        self._known: Dict[Tuple[str, str], Tuple[Encounter, ...]] = {}

    def safety_distance(self, r: Robot, s: Robot) -> float:
        """Distance between two robots' centres below which they count as in each other's way [m]."""
        return r.body_radius + s.body_radius + 2.0 * self.tolerance

    def find(self, robots: Sequence[Robot], *, fixed: int = 0) -> List[Encounter]:
        """All windows of `robots`; pairs among the last `fixed` ones are left out."""
        self._remember(robots)
        encounters: List[Encounter] = []
        for r, s in self._near_pairs(robots, fixed):
            encounters += [encounter.placed(r, s) for encounter in self.between(robots[r], robots[s])]
        return encounters

    def between(self, r: Robot, s: Robot) -> Tuple[Encounter, ...]:
        """The windows of two robots alone, as robots 0 and 1."""
        self._remember([r, s])
        names = r.name, s.name
        if names not in self._known:
            found = _windows(self._links[r.name], self._links[s.name], self.safety_distance(r, s))
            self._known[names] = tuple(_encounter(0, 1, *window) for window in found)
        return self._known[names]

    def learn(self, r: Robot, s: Robot, windows: Sequence[Encounter]) -> None:
        """Take the windows of two robots from elsewhere: what `between` gave for the same two robots."""
        self._remember([r, s])
        self._known[r.name, s.name] = tuple(windows)

    def _remember(self, robots: Sequence[Robot]) -> None:
        """Forget what is known of robots that are not the same as before."""
        for robot in robots:
            if self._robots.get(robot.name) is not robot:
                self._forget(robot.name)
                self._robots[robot.name] = robot
                self._links[robot.name] = cut_into_links(robot.path)

    def _forget(self, name: str) -> None:
        for pair in [pair for pair in self._known if name in pair]:
            del self._known[pair]

    def _near_pairs(self, robots: Sequence[Robot], fixed: int) -> List[Tuple[int, int]]:
        """Pairs whose bounding boxes come within the safety distance, in the fleet's order."""
        lows = np.array([robot.path.points.min(axis=0) for robot in robots])
        highs = np.array([robot.path.points.max(axis=0) for robot in robots])
        reach = np.array([robot.body_radius for robot in robots]) + self.tolerance
        rows, columns = np.triu_indices(len(robots), 1)
        planned = rows < len(robots) - fixed
        rows, columns = rows[planned], columns[planned]
        gaps = np.maximum(np.maximum(lows[rows] - highs[columns], lows[columns] - highs[rows]), 0.0)
        near = np.hypot(gaps[:, 0], gaps[:, 1]) < reach[rows] + reach[columns]
        return list(zip(rows[near].tolist(), columns[near].tolist()))


def _windows(r: Links, s: Links, distance: float) -> List[Tuple]:
    runs, labels = conflict_regions(r, s, distance)
    return [(r, s, runs[labels == label]) for label in range(int(labels.max(initial=-1)) + 1)]


def _encounter(r: int, s: int, r_links: Links, s_links: Links, runs: np.ndarray) -> Encounter:
    rows, lows, highs = runs.T
    r_extent = float(r_links.starts[rows[0]]), float(r_links.ends[rows[-1]])
    s_extent = float(s_links.starts[lows.min()]), float(s_links.ends[highs.max()])
    r_ends = bool(rows[0] == 0), bool(rows[-1] == len(r_links.starts) - 1)
    s_ends = bool(lows.min() == 0), bool(highs.max() == len(s_links.starts) - 1)
    by_low = np.argsort(lows, kind="stable")
    r_first = _staircase(s_links.starts[lows[by_low]], r_links.ends[np.maximum.accumulate(rows[by_low])])
    s_first = _staircase(r_links.starts[rows], s_links.ends[np.maximum.accumulate(highs)])
    return Encounter(r, s, _kind(runs, r_extent, s_extent), r_extent, s_extent, r_ends, s_ends,
                     Order(r, s, *r_first, possible=not (s_ends[0] or r_ends[1])),
                     Order(s, r, *s_first, possible=not (r_ends[0] or s_ends[1])))


def _staircase(at: np.ndarray, clear: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Fewer steps that ask for at least as much: each holds what is needed up to the next."""
    starts = [0]
    for index in range(1, len(at)):
        if at[index] > at[starts[-1]] and clear[index] - clear[starts[-1]] > _STAIR:
            starts.append(index)
    lasts = np.array(starts[1:] + [len(at)]) - 1
    return at[starts], clear[lasts]


def _kind(runs: np.ndarray, r_extent: Tuple[float, float], s_extent: Tuple[float, float]) -> str:
    """3.3.1's kind; what is neither short nor monotone is read as an intersection, one robot at a time."""
    lengths = r_extent[1] - r_extent[0], s_extent[1] - s_extent[0]
    if max(lengths) < SHORT or min(lengths) <= 0.0:
        return "intersection"
    _, starts = np.unique(runs[:, 0], return_index=True)
    lows, highs = np.minimum.reduceat(runs[:, 1], starts), np.maximum.reduceat(runs[:, 2], starts)
    if _rises(lows) and _rises(highs):
        return "same_direction"
    if _rises(-lows) and _rises(-highs):
        return "opposite_direction"
    return "intersection"


def _rises(links: np.ndarray) -> bool:
    """Whether positions on the other path rise from link to link, but for small setbacks."""
    return bool((np.maximum.accumulate(links) - links <= _SETBACK / LINK).all())


def contradiction(encounter: Encounter, robots: Sequence[Robot]) -> Optional[str]:
    """Why neither order of a window is possible, as a sentence; None when one is."""
    if encounter.r_first.possible or encounter.s_first.possible:
        return None
    return " and ".join(forced_reasons(encounter, robots))


def forced_reasons(encounter: Encounter, robots: Sequence[Robot]) -> List[str]:
    """What the starts and goals within a window demand, one clause each; empty when there are none."""
    r, s = robots[encounter.r].name, robots[encounter.s].name
    clauses = []
    for first, second, ends in ((r, s, encounter.r_ends), (s, r, encounter.s_ends)):
        if ends[0]:
            clauses.append(f"{first} starts in the way of {second}")
        if ends[1]:
            clauses.append(f"{first} ends in the way of {second}")
    return clauses
