"""Encounter windows: the stretches of two paths where the robots' discs could touch (3.3.1).

For either order of the two robots a window knows what the second has to wait for, point by point: it may be at an arc
length only once the first has passed a matching one and stays clear of it from there on. This is exact for every shape
of window, whatever speeds the robots drive at: see doc/coordination.md.
"""

from dataclasses import dataclass
from typing import Dict, Iterator, List, Optional, Sequence, Tuple

import numpy as np

from social_fleet.coordination.conflict_regions import Links, cut_into_links
from social_fleet.coordination.robot import Robot, safety_distance
from social_fleet.coordination.schedule import KINDS
from social_fleet.coordination.window_rows import WindowRows, window_rows

_LEAST = 0.04  # what two discs keep that got closer than they should [m]


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
        first, second = self.r_first, self.s_first
        return Encounter(r, s, self.kind, self.r_extent, self.s_extent, self.r_ends, self.s_ends,
                         Order(r, s, first.at, first.clear, first.possible),
                         Order(s, r, second.at, second.clear, second.possible))


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
        self._placed: Dict[Tuple[int, int], Tuple[Tuple[Encounter, ...], Tuple[Encounter, ...]]] = {}

    def safety_distance(self, r: Robot, s: Robot) -> float:
        """Distance between two robots' centres below which they count as in each other's way [m]."""
        return safety_distance(r.body_radius, s.body_radius, self.tolerance)

    def find(self, robots: Sequence[Robot], *, fixed: int = 0) -> List[Encounter]:
        """All windows of `robots`; pairs among the last `fixed` ones are left out."""
        self._remember(robots)
        encounters: List[Encounter] = []
        for r, s in self._near_pairs(robots, fixed):
            windows = self.between(robots[r], robots[s])
            if windows:
                encounters += self._at(r, s, windows)
        return encounters

    def _at(self, r: int, s: int, windows: Tuple[Encounter, ...]) -> Tuple[Encounter, ...]:
        """Windows placed in a fleet; the same as last time where they are the same."""
        source, placed = self._placed.get((r, s), ((), ()))
        if source is not windows:
            placed = tuple(encounter.placed(r, s) for encounter in windows)
            self._placed[r, s] = windows, placed
        return placed

    def between(self, r: Robot, s: Robot) -> Tuple[Encounter, ...]:
        """The windows of two robots alone, as robots 0 and 1."""
        self._remember([r, s])
        names = r.name, s.name
        if names not in self._known:
            rows = window_rows(self._links_of(r), self._links_of(s), self.safety_distance(r, s),
                               stops=(r.stops, s.stops), committed=_commitments(r, s),
                               least=r.body_radius + s.body_radius + _LEAST)
            self._known[names] = tuple(_encounters(rows))
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

    def _links_of(self, robot: Robot) -> Links:
        if robot.name not in self._links:
            self._links[robot.name] = cut_into_links(robot.path, border=robot.committed or 0.0)
        return self._links[robot.name]

    def _forget(self, name: str) -> None:
        self._links.pop(name, None)
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


def _commitments(r: Robot, s: Robot) -> Optional[Tuple[float, float]]:
    """What two robots are committed to [m]; None when neither is under way."""
    if r.committed is None and s.committed is None:
        return None
    return r.committed or 0.0, s.committed or 0.0


def _encounters(rows: WindowRows) -> Iterator[Encounter]:
    """The windows of two robots, 0 and 1."""
    extents, ends, starts = rows.extents.tolist(), rows.ends.tolist(), rows.starts.tolist()
    for window, kind in enumerate(rows.kinds.tolist()):
        r_low, r_high, s_low, s_high = extents[window]
        r_start, r_goal, s_start, s_goal = ends[window]
        low, middle, high = starts[2 * window:2 * window + 3]
        yield Encounter(
            0, 1, KINDS[kind], (r_low, r_high), (s_low, s_high), (r_start, r_goal), (s_start, s_goal),
            Order(0, 1, rows.at[low:middle], rows.clear[low:middle], possible=not (s_start or r_goal)),
            Order(1, 0, rows.at[middle:high], rows.clear[middle:high], possible=not (r_start or s_goal)))


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
