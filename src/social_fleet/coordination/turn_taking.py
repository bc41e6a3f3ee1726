"""Paths on which a fleet could drive one robot after the other, where the given ones admit no schedule at all.

Each robot in turn drives to its goal while all others stand; one that blocks the rest steps aside first. Nobody is to
drive that way: it is the witness that the windows of these paths have a common order, from which the program finds a
good one. Derivation: doc/coordination.md.
"""

from dataclasses import replace
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np

from social_fleet.coordination.crowd import ROOM, Crowd, gaps
from social_fleet.coordination.replanning import Replanner, joined
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.turns import Turn
from social_fleet.coordination.waiting_places import WaitingPlaces
from social_fleet.geometry import Polyline
from social_fleet.planning.overlays.discs import Disc
from social_fleet.planning.plan import Plan

_ASIDES, _MOST_ASIDES = 2, 8  # times that one robot steps aside, at first, and at most where nothing else helps

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
        Which of the parts of the map that robots could wait in to try: 0 for the roomiest.
    patience : int, optional
        How often robots may step aside between two arrivals.

    Attributes
    ----------
    turns : list of Turn
        The turns so far.
    """

    def __init__(self, robots: Sequence[Robot], planned: int, replanner: Replanner, safety_distance: Distance,
                 expired: Callable[[], bool], *, attempt: int = 0, patience: Optional[int] = None) -> None:
        self._robots = list(robots)
        self._replanner = replanner
        self._expired = expired
        self._patience = patience
        self._crowd = Crowd(robots, planned, np.array([[safety_distance(r, s) for s in robots] for r in robots]))
        self._waiting_places = WaitingPlaces(self._crowd, replanner, attempt)
        self._driven: List[List[Plan]] = [[] for _ in robots]
        self._onward: Dict[int, Plan] = {}  # ways from where robots are, of those that do not drive their own path
        self._asides = [0] * len(robots)
        self._allowed = _ASIDES
        self._kept_off: Dict[int, Tuple[int, int]] = {}  # who waits for whom to move on from its so many-th place
        self._passed: Dict[Tuple[int, int, int], np.ndarray] = {}  # whose goals one passes from a part of the map
        self.turns: List[Turn] = [Turn(index, 0.0, robots[index].path.length) for index in range(planned, len(robots))]
        self._makes_way = not self._crowd.is_blocked_by(planned)
        for index in range(planned, len(robots)):
            self._crowd.move(index, self._crowd.goals[index])

    def find(self) -> Optional[List[Robot]]:
        """The robots with paths that `turns` fit; None when this search knows none."""
        if not self._makes_way:
            return None  # those under way would have to wait for others to make way
        fruitless = 0
        while self._crowd.waiting:
            if self._expired() or self._patience is not None and fruitless > self._patience:
                return None
            if self._arrive():
                fruitless = 0
            elif self._step_aside():
                fruitless += 1
            elif self._allowed < _MOST_ASIDES:
                self._allowed += 1
            else:
                return None
        return [self._rerouted(index) for index in range(len(self._robots))]

    def _arrive(self) -> bool:
        """Let one robot drive to its goal, for good."""
        crowd, blocked, harms = self._crowd, self._crowd.blocked(), self._crowd.harms()
        free = [robot for robot in crowd.waiting if not blocked[robot].any()]
        for robot in sorted(free, key=lambda robot: (harms[:, robot].sum(), robot)):
            if not self._is_kept_off(robot) and self._settle(robot, harms):
                return True
        for robot in [robot for robot in crowd.waiting if robot not in free]:
            if not self._is_kept_off(robot) and self._waiting_places.reaches_goal(robot):
                way = self._way(robot, crowd.goals[robot], crowd.others(robot))
                if way is not None and self._settle(robot, harms, way):
                    return True
        return False

    def _settle(self, robot: int, harms: np.ndarray, way: Optional[Plan] = None) -> bool:
        """Drive to the goal if the others still reach theirs then."""
        crowd = self._crowd
        shut = self._waiting_places.shut_out_by(robot)
        if shut is not None:
            self._keep_off(robot, shut)
            return False
        detours = {}
        settled = [*crowd.settled(), robot]
        for other in np.flatnonzero(harms[:, robot]).tolist():
            detour = self._way(other, crowd.goals[other], settled, arrived=robot)
            if detour is None:
                self._keep_off(robot, other)
                return False
            detours[other] = detour
        if way is not None:
            self._use(robot, way)
        self._drive(robot)
        crowd.waiting.remove(robot)
        for other, detour in detours.items():
            self._use(other, detour)
        return True

    def _step_aside(self) -> bool:
        """Let one robot that is in the way of others drive where it is in nobody's, nor they in its."""
        crowd, places = self._crowd, self._waiting_places
        blocked = crowd.blocked()
        candidates = [robot for robot in crowd.waiting if self._asides[robot] < self._allowed]
        candidates.sort(key=lambda robot: (-blocked[:, robot].sum(), robot))
        for robot in candidates:
            if blocked[:, robot].any() or not places.at_home(crowd.places[[robot]], robot)[0]:
                if any(self._park(robot, place) for place in places.off_ways(robot)):
                    return True
        for robot in candidates:
            if not self._asides[robot] and any(self._park(robot, place) for place in places.beside_passages(robot)):
                return True
        return any(self._park(robot, place) for robot in candidates for place in places.anywhere(robot)
                   if not self._is_harmed_from(robot, place))

    def _park(self, robot: int, place: np.ndarray) -> bool:
        there = self._way(robot, place, self._crowd.others(robot))
        onward = None if there is None else self._way(robot, self._crowd.goals[robot], self._crowd.settled(),
                                                      start=place)
        if there is None or onward is None:
            return False
        self._use(robot, there)
        self._drive(robot, aside=True)
        self._use(robot, onward)
        self._asides[robot] += 1
        return True

    def _is_harmed_from(self, robot: int, place: np.ndarray) -> bool:
        """Whether from a place it would pass the goal of one whose way passes its own, or get to its goal not at all.

        What it passes from one part between the goals is looked up once, until somebody arrives.
        """
        crowd = self._crowd
        key = robot, self._waiting_places.part(robot, place), len(crowd.waiting)
        if not key[1] or key not in self._passed:
            onward = self._way(robot, crowd.goals[robot], crowd.settled(), start=place)
            self._passed[key] = (np.ones(len(self._robots), dtype=bool) if onward is None else
                                 gaps(Polyline(onward.points), crowd.goals) < crowd.distances[robot])
        return bool((self._passed[key] & crowd.harms()[:, robot]).any())

    def _keep_off(self, robot: int, other: int) -> None:
        """Remember that a robot must not arrive before another, as long as that stays where it is."""
        self._kept_off[robot] = other, self._crowd.moves[other]

    def _is_kept_off(self, robot: int) -> bool:
        other, moves = self._kept_off.get(robot, (robot, -1))
        return moves == self._crowd.moves[other]

    def _drive(self, robot: int, *, aside: bool = False) -> None:
        """Take a turn along the way at hand."""
        low = sum(part.length for part in self._driven[robot])
        if robot in self._onward:
            self._driven[robot].append(self._onward[robot])
        way = self._crowd.ways[robot]
        self.turns.append(Turn(robot, low, low + way.length))
        self._crowd.move(robot, way.points[-1], aside=aside)

    def _use(self, robot: int, plan: Plan) -> None:
        self._onward[robot] = plan
        self._crowd.lead(robot, Polyline(plan.points))

    def _way(self, robot: int, goal: np.ndarray, parked: Sequence[int], *, start: Optional[np.ndarray] = None,
             arrived: Optional[int] = None) -> Optional[Plan]:
        """A way from where a robot is, or from `start`, clear of parked ones, of which one counts as arrived."""
        crowd = self._crowd
        start = crowd.places[robot] if start is None else start
        discs = []
        for other in parked:
            x, y = crowd.goals[other] if other == arrived else crowd.places[other]
            distance = crowd.distances[robot, other]
            ends = min(np.hypot(*(start - (x, y))), np.hypot(*(goal - (x, y))))
            if ends < distance:
                return None
            discs.append(Disc(float(x), float(y), float(min(distance + ROOM, 0.5 * (distance + ends)))))
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
