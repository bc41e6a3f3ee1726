"""Paths on which a fleet could drive one robot after the other, where the given ones admit no schedule at all.

Each robot in turn drives to its goal while all others stand; those in its way step aside first, and others for them.
Nobody is to drive that way: it is the witness that the windows of these paths have a common order, from which the
program finds a good one. Derivation: doc/coordination.md.
"""

from dataclasses import replace
from typing import Callable, Dict, List, Optional, Sequence, Set, Tuple

import numpy as np

from social_fleet.coordination.crowd import ROOM, Crowd
from social_fleet.coordination.replanning import Replanner, joined, plan_of
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.turns import Turn
from social_fleet.coordination.waiting_places import WaitingPlaces
from social_fleet.geometry import Polyline
from social_fleet.planning.overlays.discs import Disc
from social_fleet.planning.plan import Plan

_MOVES = 12  # that others make for one robot in a row, ...
_DEPTH = 3  # ... each of them perhaps for one that makes way itself, and so on
_FRUITLESS = 20  # times that way is made and nobody arrives, until ...
_RECALLS = 6  # ... those that have arrived are called back, so many times, ...
_RECALLED = 4.0  # ... from so far at the first, twice as far at the second, and so on [m]
_TRIES = 3  # times that way is made for one robot before it is for one whom a goal of another's cuts off

_BESIDE = 0.02  # that ways begin and end outside of what they keep out of, where there is little room [m]

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

    Attributes
    ----------
    turns : list of Turn
        The turns so far.
    """

    def __init__(self, robots: Sequence[Robot], planned: int, replanner: Replanner, safety_distance: Distance,
                 expired: Callable[[], bool]) -> None:
        self._robots = list(robots)
        self._planned = planned
        self._replanner = replanner
        self._expired = expired
        self._crowd = Crowd(robots, planned, np.array([[safety_distance(r, s) for s in robots] for r in robots]))
        self._waiting_places = WaitingPlaces(self._crowd, replanner)
        self._driven: List[List[Plan]] = [[] for _ in robots]
        self._onward: Dict[int, Plan] = {}  # ways from where robots are, of those that do not drive their own path
        self._kept_off: Dict[int, Tuple[int, int]] = {}  # who must not arrive before another's so many-th change
        self._helped = [0] * len(robots)  # how often way was made for each since one arrived
        self._moves_left = 0
        self._recalled: Set[int] = set()  # those that had arrived, until the others have
        self._recalls = 0
        self.turns: List[Turn] = [Turn(index, 0.0, robots[index].path.length) for index in range(planned, len(robots))]
        self._makes_way = not self._crowd.is_blocked_by(planned)
        for index in range(planned, len(robots)):
            self._crowd.move(index, self._crowd.goals[index])

    def find(self) -> Optional[List[Robot]]:
        """The robots with paths that `turns` fit; None when this search knows none."""
        if not self._makes_way:
            return None  # those under way would have to wait for others to make way
        if not self._lead_round_settled():
            return None
        fruitless = 0
        while self._crowd.waiting:
            if self._expired():
                return None
            if self._recalled.issuperset(self._crowd.waiting):
                self._recalled.clear()
            if self._arrive():
                fruitless = 0
                self._helped = [0] * len(self._robots)
            elif fruitless < _FRUITLESS and self._make_way():
                fruitless += 1
            elif self._recall():
                fruitless = 0
            else:
                return None
        return [self._rerouted(index) for index in range(len(self._robots))]

    def _lead_round_settled(self) -> bool:
        """Lead all whose way is barred by one that is under way round its goal; False where there is no way."""
        crowd = self._crowd
        for robot in np.flatnonzero(crowd.blocked()[:, self._planned:].any(axis=1)).tolist():
            way = self._way(robot, crowd.goals[robot], crowd.settled())
            if way is None:
                return False
            self._use(robot, way)
        return True

    def _arrive(self) -> bool:
        """Let one robot drive to its goal, to stay."""
        crowd, blocked, harms = self._crowd, self._crowd.blocked(), self._crowd.harms()
        free = [robot for robot in crowd.waiting if not blocked[robot].any()]
        for robot in sorted(free, key=lambda robot: (harms[:, robot].sum(), robot)):
            if not self._is_kept_off(robot) and not self._expired() and self._settle(robot, harms):
                return True
        for robot in [robot for robot in crowd.waiting if robot not in free]:
            if (not self._is_kept_off(robot) and not self._expired()
                    and self._waiting_places.reaches_goal(robot)):
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

    def _make_way(self) -> bool:
        """Let others step aside so that one robot can drive to its goal, or that it may arrive without harm to them."""
        crowd, blocked, turns = self._crowd, self._crowd.blocked(), self._crowd.turns

        def rank(robot: int) -> Tuple[int, bool, int, int, int]:
            return (self._helped[robot] // _TRIES, self._is_kept_off(robot), self._helped[robot],
                    int(blocked[robot].sum()), robot)

        for robot in sorted((robot for robot in crowd.waiting if robot not in self._recalled), key=rank):
            if self._expired():
                break
            shut = self._waiting_places.shut_out_by(robot)
            if shut is not None:
                self._keep_off(robot, shut)
            self._helped[robot] += 1
            self._moves_left = _MOVES
            if self._is_kept_off(robot):
                other = self._kept_off[robot][0]
                if self._lead_away(other, [], robot):
                    return True
            elif blocked[robot].any() and self._clear(robot, [robot], robot):
                return True
        return crowd.turns > turns  # who has moved may be out of the way of others

    def _clear(self, robot: int, parties: Sequence[int], arriving: int) -> bool:
        """Bring all that stand in a robot's way where they are in no party's."""
        while True:
            blockers = np.flatnonzero(self._crowd.blocked()[robot]).tolist()
            if not any(self._step_aside(other, parties, arriving) for other in blockers):
                return not blockers

    def _step_aside(self, robot: int, parties: Sequence[int], arriving: int) -> bool:
        """Drive out of all parties' ways; best to where one that is then `arriving` does not cut off the goal."""
        if not self._moves_left or self._expired():
            return False
        ways = [self._crowd.ways[party] for party in parties if party != robot]
        places = self._waiting_places
        return (self._park_at_one(robot, places.within_reach(robot, ways, arriving=arriving))
                or self._lead_away(robot, parties, arriving)
                or self._park_at_one(robot, places.within_reach(robot, ways)))

    def _park_at_one(self, robot: int, places: Sequence[np.ndarray]) -> bool:
        for place in places:
            if self._moves_left and self._park(robot, place):
                self._moves_left -= 1
                return True
        return False

    def _lead_away(self, robot: int, parties: Sequence[int], arriving: int) -> bool:
        """As `_step_aside`, to where others have to make way in turn."""
        if len(parties) > _DEPTH or robot in parties[1:]:
            return False
        crowd = self._crowd
        ways = [crowd.ways[party] for party in parties if party != robot]
        for place in self._waiting_places.beyond_others(robot, ways, arriving=arriving):
            if self._expired():
                return False
            there = self._way(robot, place, crowd.settled())
            if there is None or self._way(robot, crowd.goals[robot], crowd.settled(), start=place) is None:
                continue
            before = self._onward.get(robot), crowd.ways[robot]
            self._use(robot, there)
            led = crowd.ways[robot]
            cleared = self._clear(robot, [*parties, robot], arriving)
            if crowd.ways[robot] is not led:
                return False  # it had to make way itself
            self._take_back(robot, *before)
            if cleared and self._park_at_one(robot, [place]):
                return True
        return False

    def _park(self, robot: int, place: np.ndarray) -> bool:
        there = self._way(robot, place, self._crowd.others(robot))
        onward = None if there is None else self._way(robot, self._crowd.goals[robot], self._crowd.settled(),
                                                      start=place)
        if there is None or onward is None:
            return False
        self._use(robot, there)
        self._drive(robot, aside=True)
        self._use(robot, onward)
        return True

    def _recall(self) -> bool:
        """Let those that have arrived near the rest, or near their goals, make way once more."""
        crowd = self._crowd
        if self._recalls == _RECALLS:
            return False
        self._recalls += 1
        ends = np.vstack((crowd.places[crowd.waiting], crowd.goals[crowd.waiting]))
        for robot in crowd.settled():
            near = np.hypot(*(ends - crowd.goals[robot]).T).min() < _RECALLED * self._recalls
            if near and robot < self._planned:
                if not self._driven[robot]:
                    self._driven[robot].append(plan_of(self._robots[robot]))
                self._onward.pop(robot, None)
                crowd.recall(robot)
                self._recalled.add(robot)
        self._kept_off.clear()
        return True

    def _keep_off(self, robot: int, other: int) -> None:
        """Remember that a robot must not arrive before another, as long as nothing changes for that."""
        self._kept_off[robot] = other, self._crowd.changes[other]

    def _is_kept_off(self, robot: int) -> bool:
        other, changes = self._kept_off.get(robot, (robot, -1))
        return robot in self._recalled or changes == self._crowd.changes[other]

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

    def _take_back(self, robot: int, plan: Optional[Plan], way: Polyline) -> None:
        """Undo `_use`."""
        self._crowd.lead(robot, way)
        if plan is None:
            del self._onward[robot]
        else:
            self._onward[robot] = plan

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
            if ends < distance + (ROOM if crowd.aside[other] and other != arrived else 0.0):
                return None
            radius = min(distance + ROOM, max(0.5 * (distance + ends), ends - _BESIDE))
            discs.append(Disc(float(x), float(y), float(radius)))
        return self._replanner.way(self._robots[robot], start, goal, discs)

    def _rerouted(self, index: int) -> Robot:
        robot, plans = self._robots[index], self._driven[index]
        if not plans or len(plans) == 1 and np.array_equal(plans[0].points, robot.path.points):
            return robot
        plan = plans[0]
        stops = list(plan.stops)
        for onward in plans[1:]:
            stops.append(plan.length)
            plan = joined(plan, onward)
        plan = replace(plan, stops=tuple(stops))
        return replace(robot, plan=plan, start_yaw=robot.start_yaw, goal_yaw=robot.goal_yaw)
