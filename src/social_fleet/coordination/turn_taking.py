"""Paths on which a fleet could drive one robot after the other, where the given ones admit no schedule at all.

Each robot in turn drives to its goal while all others stand; one that blocks the rest steps aside first. Nobody is to
drive that way: it is the witness that the windows of these paths have a common order, from which the program finds a
good one. Derivation: doc/coordination.md.
"""

from dataclasses import replace
from typing import Callable, Dict, Iterable, Iterator, List, Optional, Sequence, Tuple, Union

import numpy as np

from social_fleet.coordination.replanning import Replanner, clear_of, joined, nearest_apart
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.turns import Turn
from social_fleet.geometry import Polyline
from social_fleet.planning.overlays.discs import Disc
from social_fleet.planning.plan import Plan
from social_fleet.planning.regions import Regions

_ROOM = 0.12  # kept beyond the safety distance: more than a link, so that windows end where robots stand [m]
_ASIDES = 3  # times that one robot steps aside at most
_PLACES = 3  # at the hub that are tried for it each time, ...
_APART = 1.5  # ... and between them [m]
_MOST = 25  # ... or anywhere, ...
_CLOSE, _FAR_APART = 5, 5.0  # ... where, after so many, they are so far apart [m]

Distance = Callable[[Robot, Robot], float]


class TurnTaking:
    """Finds paths and turns for a fleet.

    Parameters
    ----------
    robots : sequence of Robot
        All of them, with the paths that they would like to drive.
    planned : int
        How many of them may be given other paths; the rest, those under way, have the first turns.
    replanner : Replanner
    safety_distance : callable
        Of two robots [m].
    expired : callable
        Whether to give up.
    attempt : int
        Which of the parts of the map that robots could wait in to try: 0 for the one that holds most of them.

    Attributes
    ----------
    turns : list of Turn
        The turns so far.
    """

    def __init__(self, robots: Sequence[Robot], planned: int, replanner: Replanner, safety_distance: Distance,
                 expired: Callable[[], bool], *, attempt: int = 0) -> None:
        self._robots = list(robots)
        self._replanner = replanner
        self._expired = expired
        self._attempt = attempt
        count = len(robots)
        self._distances = np.array([[safety_distance(r, s) for s in robots] for r in robots])
        self._places = np.array([robot.path.points[0] for robot in robots])
        self._goals = np.array([robot.path.points[-1] for robot in robots])
        self._driven: List[List[Plan]] = [[] for _ in robots]
        self._onward: Dict[int, Plan] = {}  # ways from where robots are, of those that do not drive their own path
        self._ways: List[Polyline] = [robot.path for robot in robots]
        self._asides = [0] * count
        self._aside = np.zeros(count, dtype=bool)  # who stands at a place aside
        self._hub: Optional[np.ndarray] = None
        self._known: Dict[Tuple[str, float], Tuple[int, Regions]] = {}
        self._moves = [0] * count
        self._kept_off: Dict[int, Tuple[int, int]] = {}  # who waits for whom to move on from its so many-th place
        self._waiting: List[int] = list(range(planned))
        self.turns: List[Turn] = [Turn(index, 0.0, robots[index].path.length) for index in range(planned, count)]
        self._near = np.array([_gaps(way, self._places) for way in self._ways])  # of every way to every place [m]
        self._ends = np.array([_gaps(way, self._goals) for way in self._ways])  # ... and to every goal
        self._makes_way = not (self._near < self._distances)[planned:, :planned].any()
        for index in range(planned, count):
            self._move(index, self._goals[index])

    def find(self) -> Optional[List[Robot]]:
        """The robots with paths that `turns` fit; None when this search knows none."""
        if not self._makes_way:
            return None  # those under way would have to wait for others to make way
        while self._waiting:
            if self._expired() or not (self._arrive() or self._step_aside()):
                return None
        return [self._rerouted(index) for index in range(len(self._robots))]

    def _arrive(self) -> bool:
        """Let one robot drive to its goal, for good."""
        blocked, harms = self._blocked(), self._harms()
        free = [robot for robot in self._waiting if not blocked[robot].any()]
        for robot in sorted(free, key=lambda robot: (harms[:, robot].sum(), robot)):
            if not self._is_kept_off(robot) and self._settle(robot, harms):
                return True
        for robot in self._reaching(robot for robot in self._waiting
                                    if robot not in free and not self._is_kept_off(robot)):
            way = self._way(robot, self._goals[robot], self._others(robot))
            if way is not None and self._settle(robot, harms, way):
                return True
        return False

    def _settle(self, robot: int, harms: np.ndarray, way: Optional[Plan] = None) -> bool:
        """Drive to the goal if the others still reach theirs then."""
        shut = self._shut_out(robot)
        if shut is not None:
            self._keep_off(robot, shut)
            return False
        detours = {}
        settled = [*self._settled(), robot]
        for other in np.flatnonzero(harms[:, robot]).tolist():
            detour = self._way(other, self._goals[other], settled, arrived=robot)
            if detour is None:
                self._keep_off(robot, other)
                return False
            detours[other] = detour
        if way is not None:
            self._use(robot, way)
        self._drive(robot)
        self._waiting.remove(robot)
        self._aside[robot] = False
        for other, detour in detours.items():
            self._use(other, detour)
        return True

    def _reaching(self, robots: Iterable[int]) -> Iterator[int]:
        """Those of some robots that perhaps reach their goals now, round those that stand."""
        for robot in robots:
            if self._regions("standing", robot).of(self._goals[[robot]])[0] in self._around(robot):
                yield robot

    def _step_aside(self) -> bool:
        """Let one robot that is in the way of others drive where it is in nobody's, nor they in its."""
        if self._hub is None:
            self._hub = self._most_room()
        blocked = self._blocked()
        candidates = [robot for robot in self._waiting if self._asides[robot] < _ASIDES]
        candidates.sort(key=lambda robot: (-blocked[:, robot].sum(), robot))
        for robot in candidates:
            if blocked[:, robot].any() or not self._at_hub(self._places[[robot]], robot)[0]:
                for place in self._places_for(robot, at_hub=True):
                    if self._park(robot, place):
                        return True
        return any(self._park(robot, place, strict=True) for robot in candidates
                   for place in self._places_for(robot, at_hub=False))

    def _most_room(self) -> np.ndarray:
        """A place in the part that most robots could wait in, all goals occupied."""
        widest = max(self._waiting, key=lambda robot: (self._robots[robot].body_radius, robot))
        regions = self._regions("goals", widest)
        here = regions.of(self._places[self._waiting])
        room = self._replanner.standing_room(self._robots[widest])
        labels = regions.holding(room)
        counts = np.bincount(labels[labels > 0])
        held = np.bincount(here[here > 0], minlength=len(counts))[:len(counts)]
        ranked = [part for part in np.lexsort((counts, held))[::-1] if counts[part]]
        inside = room[labels == ranked[self._attempt % len(ranked)]]
        return inside[np.argmin(np.hypot(*(inside - inside.mean(axis=0)).T))]

    def _at_hub(self, places: np.ndarray, robot: int) -> np.ndarray:
        """Which of some places a robot could drive to from the hub if all goals were occupied (M,) bool."""
        assert self._hub is not None
        regions = self._regions("goals", robot)
        return regions.holding(places) == regions.of(self._hub[None])

    def _regions(self, closed: str, robot: int) -> Regions:
        """What robots of one size reach from where when all goals are closed, all that stand, or those settled."""
        radius = self._robots[robot].body_radius
        state = {"goals": 0, "standing": len(self.turns), "settled": len(self._waiting)}[closed]
        if (closed, radius) not in self._known or self._known[closed, radius][0] != state:
            owners = self._settled() if closed == "settled" else range(len(self._robots))
            places = self._goals if closed == "goals" else self._places
            discs = [self._disc(robot, other, places[other]) for other in owners]
            self._known[closed, radius] = state, self._replanner.regions(self._robots[robot], discs)
        return self._known[closed, radius][1]

    def _around(self, robot: int) -> np.ndarray:
        """The parts that a robot reaches when it leaves its place, round those that stand."""
        return self._regions("standing", robot).touching(self._disc(robot, robot, self._places[robot]))

    def _places_for(self, robot: int, *, at_hub: bool) -> List[np.ndarray]:
        """Where a robot could wait, in nobody's way; at the hub or, in greater choice, anywhere it gets to now."""
        room = self._replanner.standing_room(self._robots[robot])
        if at_hub:
            room = room[self._at_hub(room, robot)]
        room = room[np.isin(self._regions("standing", robot).holding(room), self._around(robot))]
        ways = [self._ways[other] for other in self._waiting if other != robot]
        room = room[clear_of(room, ways, self._distances[robot].max() + _ROOM)]
        gaps = np.hypot(*(room[:, None] - self._places[self._others(robot)]).T).T
        room = room[(gaps >= self._distances[robot, self._others(robot)] + _ROOM).all(axis=1)]
        here = self._places[robot]
        return nearest_apart(room, here, apart=lambda count: _APART if at_hub or count < _CLOSE else _FAR_APART,
                             most=_PLACES if at_hub else _MOST, besides=[here])

    def _park(self, robot: int, place: np.ndarray, *, strict: bool = False) -> bool:
        there = self._way(robot, place, self._others(robot))
        onward = None if there is None else self._way(robot, self._goals[robot], self._settled(), start=place)
        if there is None or onward is None:
            return False
        if strict:
            passed = _gaps(Polyline(onward.points), self._goals) < self._distances[robot]
            if (passed & self._harms()[:, robot]).any():
                return False
        self._use(robot, there)
        self._drive(robot)
        self._use(robot, onward)
        self._asides[robot] += 1
        self._aside[robot] = True
        return True

    def _keep_off(self, robot: int, other: int) -> None:
        """Remember that a robot must not arrive before another, as long as that stays where it is."""
        self._kept_off[robot] = other, self._moves[other]

    def _is_kept_off(self, robot: int) -> bool:
        other, moves = self._kept_off.get(robot, (robot, -1))
        return moves == self._moves[other]

    def _shut_out(self, robot: int) -> Optional[int]:
        """Whose place or goal is cut off from the rest when a robot stands at its goal; None when none is."""
        places = self._places.copy()
        places[robot] = self._goals[robot]
        settled = [*self._settled(), robot]
        others = [other for other in self._waiting if other != robot]
        for radius in sorted({self._robots[other].body_radius for other in others}):
            alike = [other for other in others if self._robots[other].body_radius == radius]
            if not self._regions("settled", alike[0]).may_be_cut_by(self._disc(alike[0], robot, self._goals[robot])):
                continue
            regions = self._replanner.regions(self._robots[alike[0]], [
                self._disc(alike[0], other, places[other]) for other in settled])
            labels = regions.of(np.vstack((places[alike], self._goals[alike])))
            lost = np.flatnonzero(labels != np.argmax(np.bincount(labels)))
            if len(lost):
                return alike[lost[0] % len(alike)]
        return None

    def _drive(self, robot: int) -> None:
        """Take a turn along the way at hand."""
        low = sum(part.length for part in self._driven[robot])
        if robot in self._onward:
            self._driven[robot].append(self._onward[robot])
        self.turns.append(Turn(robot, low, low + self._ways[robot].length))
        self._move(robot, self._ways[robot].points[-1])

    def _move(self, robot: int, place: np.ndarray) -> None:
        self._places[robot] = place
        self._moves[robot] += 1
        self._near[:, robot] = [_gaps(way, place[None])[0] for way in self._ways]

    def _use(self, robot: int, plan: Plan) -> None:
        self._onward[robot] = plan
        self._ways[robot] = Polyline(plan.points)
        self._near[robot] = _gaps(self._ways[robot], self._places)
        self._ends[robot] = _gaps(self._ways[robot], self._goals)

    def _blocked(self) -> np.ndarray:
        """Whose way who stands in now (R, R): row by row, the others in the way of one that still has to arrive."""
        return self._within(self._near, np.where(self._aside, _ROOM, 0.0))

    def _harms(self) -> np.ndarray:
        """Whose way whose goal is in (R, R), likewise."""
        return self._within(self._ends)

    def _within(self, gaps: np.ndarray, more: Union[float, np.ndarray] = 0.0) -> np.ndarray:
        near = (gaps < self._distances + more) & ~np.eye(len(self._robots), dtype=bool)
        near[self._settled()] = False
        return near

    def _settled(self) -> List[int]:
        """Those that stand at their goals for good."""
        return [robot for robot in range(len(self._robots)) if robot not in self._waiting]

    def _others(self, robot: int) -> List[int]:
        return [other for other in range(len(self._robots)) if other != robot]

    def _disc(self, robot: int, other: int, place: np.ndarray) -> Disc:
        """What a robot keeps out of when another stands at a place."""
        return Disc(float(place[0]), float(place[1]), float(self._distances[robot, other] + _ROOM))

    def _way(self, robot: int, goal: np.ndarray, parked: Sequence[int], *, start: Optional[np.ndarray] = None,
             arrived: Optional[int] = None) -> Optional[Plan]:
        """A way from where a robot is, or from `start`, clear of parked ones, of which one counts as arrived."""
        start = self._places[robot] if start is None else start
        discs = []
        for other in parked:
            x, y = self._goals[other] if other == arrived else self._places[other]
            distance = self._distances[robot, other]
            ends = min(np.hypot(*(start - (x, y))), np.hypot(*(goal - (x, y))))
            if ends < distance:
                return None
            discs.append(Disc(float(x), float(y), float(min(distance + _ROOM, 0.5 * (distance + ends)))))
        return self._replanner.way(self._robots[robot], start, goal, discs)

    def _rerouted(self, index: int) -> Robot:
        robot, plans = self._robots[index], self._driven[index]
        if not plans:
            return robot
        plan = plans[0]
        stops: List[float] = []
        for onward in plans[1:]:
            stops.append(plan.length)
            plan = joined(plan, onward)
        plan = replace(plan, stops=tuple(stops))
        return replace(robot, plan=plan, start_yaw=robot.start_yaw, goal_yaw=robot.goal_yaw)


def _gaps(way: Polyline, places: np.ndarray) -> np.ndarray:
    """Distances of some places from a way (M,) [m]."""
    if len(way.points) == 1:
        return np.hypot(*(places - way.points[0]).T)
    starts, steps = way.points[:-1], np.diff(way.points, axis=0)
    offsets = places[:, None] - starts
    shares = np.einsum("pij,ij->pi", offsets, steps) / np.einsum("ij,ij->i", steps, steps)
    nearest = offsets - np.clip(shares, 0.0, 1.0)[:, :, None] * steps
    return np.hypot(nearest[:, :, 0], nearest[:, :, 1]).min(axis=1)
