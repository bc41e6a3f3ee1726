"""Other paths where the given ones admit no schedule: round a parked robot, or aside to let another pass."""

import logging
from dataclasses import replace
from typing import Callable, Dict, Iterator, List, Optional, Sequence, Set, Tuple

import numpy as np

from social_fleet.coordination.encounters import EncounterFinder
from social_fleet.coordination.robot import Robot
from social_fleet.errors import Infeasible, InvalidPose, NoPath
from social_fleet.geometry import Pose
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.overlays.discs import Disc
from social_fleet.planning.overlays.overlay_set import Overlays
from social_fleet.planning.plan import Plan
from social_fleet.planning.planner import SocialPlanner

log = logging.getLogger(__name__)

_ROOM = 0.05  # kept beyond the safety distance, so that rounding does not undo a repair [m]
_SPACING = 1.5  # between places aside that are tried [m]
_PLACES = 6  # places aside that are tried for one robot
_ASIDE_REACH = 25.0  # how far from its start a robot steps aside at most, as the crow flies [m]


Option = Tuple[str, Robot, Tuple[Disc, ...]]
"""What a robot does to let others pass, the robot with that path, and the discs that it now avoids."""


class Replanner:
    """What repair needs of a planner; `PlannerReplanner` searches in this process."""

    def detour(self, robot: Robot, avoid: Sequence[Disc]) -> Optional[Robot]:
        """`robot` with a path whose centre line keeps out of the discs; None when there is none."""
        raise NotImplementedError

    def aside(self, robot: Robot, others: Sequence[Robot], distance: float, avoid: Sequence[Disc]) -> Iterator[Robot]:
        """`robot` with paths by way of places at least `distance` [m] from the paths of `others`, nearest first."""
        raise NotImplementedError


class PlannerReplanner(Replanner):
    """Replans with one planner for each radius.

    Parameters
    ----------
    planner_for : callable
        The planner for robots of a radius [m].
    overlays : OverlaySet, mapping of names to shapes, or sequence of shapes
        Obstacles that the map does not hold.
    """

    def __init__(self, planner_for: Callable[[float], SocialPlanner], *, overlays: Overlays = ()) -> None:
        self._planner_for = planner_for
        self._overlays = overlays

    def detour(self, robot: Robot, avoid: Sequence[Disc]) -> Optional[Robot]:
        """See `Replanner`."""
        plan = self._plan(robot, _end(robot.start, robot.start_yaw), _end(robot.goal, robot.goal_yaw), avoid)
        return None if plan is None else _with_plan(robot, plan)

    def aside(self, robot: Robot, others: Sequence[Robot], distance: float, avoid: Sequence[Disc]) -> Iterator[Robot]:
        """See `Replanner`."""
        for place in self._places(robot, others, distance):
            to_place = self._plan(robot, _end(robot.start, robot.start_yaw), place, avoid)
            onward = None if to_place is None else self._plan(robot, place, _end(robot.goal, robot.goal_yaw), avoid)
            if to_place is not None and onward is not None:
                yield _with_plan(robot, _joined(to_place, onward))

    def _plan(self, robot: Robot, start: Sequence[float], goal: Sequence[float],
              avoid: Sequence[Disc]) -> Optional[Plan]:
        try:
            return self._planner_for(robot.body_radius).plan(start, goal, avoid=avoid, overlays=self._overlays)
        except (NoPath, InvalidPose):
            return None

    def _places(self, robot: Robot, others: Sequence[Robot], distance: float) -> List[Tuple[float, float]]:
        """Free places near the robot's start that keep clear of the others' paths, nearest first, apart."""
        planner = self._planner_for(robot.body_radius)
        return (self._places_in(planner.way, robot, others, distance)
                or self._places_in(planner.space, robot, others, distance))

    @staticmethod
    def _places_in(space: ConfigurationSpace, robot: Robot, others: Sequence[Robot],
                   distance: float) -> List[Tuple[float, float]]:
        from scipy.spatial import cKDTree
        stride = max(1, int(round(0.3 / space.grid.resolution)))
        rows, columns = np.nonzero(space.free[::stride, ::stride])
        places = space.grid.centres(np.stack((rows, columns), axis=1) * stride)
        reach = np.hypot(*(places - robot.path.points[0]).T)
        places, reach = places[reach < _ASIDE_REACH], reach[reach < _ASIDE_REACH]
        kept_clear = np.vstack([other.path.position(np.arange(0.0, other.path.length + 0.1, 0.1)) for other in others])
        clear = cKDTree(kept_clear).query(places)[0] >= distance + 0.1
        places, reach = places[clear], reach[clear]
        chosen: List[Tuple[float, float]] = []
        for x, y in places[np.argsort(reach, kind="stable")]:
            if all(np.hypot(x - other[0], y - other[1]) >= _SPACING for other in chosen):
                chosen.append((float(x), float(y)))
            if len(chosen) == _PLACES:
                break
        return chosen


class Repairs:
    """The repairs of one fleet, in order; remembers what was tried, so that it ends.

    Parameters
    ----------
    finder : EncounterFinder
        Knows the safety distance of each pair.
    replanner : Replanner
    feasible : callable
        Whether some robots have a schedule among themselves.
    limit : int
        Greatest number of paths replanned.
    """

    def __init__(self, finder: EncounterFinder, replanner: Replanner,
                 feasible: Callable[[Sequence[Robot]], bool], limit: int) -> None:
        self._finder = finder
        self._replanner = replanner
        self._feasible = feasible
        self._limit = limit
        self._avoided: Dict[str, Tuple[Disc, ...]] = {}
        self._tried: Set[Tuple[str, str, str]] = set()
        self.notes: List[str] = []

    def mend(self, planned: Sequence[Robot], fleet: Sequence[Robot], error: Infeasible) -> List[Robot]:
        """`planned` with one path changed so that the robots named in `error` have a schedule among themselves.

        Raises
        ------
        Infeasible
            `error` itself, when nothing is left to try.
        """
        if len(self.notes) >= self._limit:
            raise error
        concerned = [robot for robot in fleet if robot.name in error.robots]
        movable = [robot for robot in planned if robot.name in error.robots]
        best = (self._shortest(self._detours, movable, concerned)
                or self._shortest(self._asides, movable, concerned))
        if best is None:
            raise error
        extra, how, changed, avoided = best
        self._avoided[changed.name] = avoided
        self.notes.append(f"{changed.name} {how} ({extra:+.1f} m)")
        log.info("repair: %s", self.notes[-1])
        return [changed if robot.name == changed.name else robot for robot in planned]

    def _shortest(self, ways: Callable[[Robot, Sequence[Robot]], Iterator[Option]], movable: Sequence[Robot],
                  concerned: Sequence[Robot]) -> Optional[Tuple[float, str, Robot, Tuple[Disc, ...]]]:
        """The change of path that helps and costs the least length, with that length [m]."""
        best: Optional[Tuple[float, str, Robot, Tuple[Disc, ...]]] = None
        for robot in movable:
            others = [other for other in concerned if other.name != robot.name]
            for how, changed, avoided in ways(robot, others):
                extra = changed.path.length - robot.path.length
                if (best is None or extra < best[0]) and self._feasible(others + [changed]):
                    best = extra, how, changed, avoided
        return best

    def _detours(self, robot: Robot, others: Sequence[Robot]) -> Iterator[Option]:
        """Paths round where another stands, each tried once."""
        known = self._avoided.get(robot.name, ())
        for other in others:
            discs = self._discs_in_the_way(robot, other)
            choices = [("the start", discs[:1]), ("the goal", discs[1:]), ("start and goal", discs)]
            for what, chosen in choices:
                found = tuple(disc for disc in chosen if disc is not None)
                if len(found) != len(chosen) or not self._first_try(robot, other, what):
                    continue
                changed = self._replanner.detour(robot, known + found)
                if changed is not None:
                    yield f"drives round {what} of {other.name}", changed, known + found

    def _asides(self, robot: Robot, others: Sequence[Robot]) -> Iterator[Option]:
        """Paths by way of a place where the others do not come, tried once."""
        known = self._avoided.get(robot.name, ())
        names = ", ".join(other.name for other in others)
        distance = max(self._finder.safety_distance(robot, other) for other in others)
        if self._first_try(robot, others[0], "aside " + names):
            for changed in self._replanner.aside(robot, others, distance + _ROOM, known):
                yield f"steps aside for {names}", changed, known

    def _first_try(self, robot: Robot, other: Robot, what: str) -> bool:
        key = robot.name, other.name, f"{what} {robot.path.length:.3f} {other.path.length:.3f}"
        if key in self._tried:
            return False
        self._tried.add(key)
        return True

    def _discs_in_the_way(self, robot: Robot, other: Robot) -> List[Optional[Disc]]:
        """Discs round the other's start and goal, None where the robot's path keeps clear of it or starts in it."""
        distance = self._finder.safety_distance(robot, other) + _ROOM
        discs: List[Optional[Disc]] = []
        for x, y in (other.path.points[0], other.path.points[-1]):
            nearest = robot.path.position(robot.path.project((x, y), 0.0, robot.path.length))
            ends = robot.path.points[[0, -1]] - (x, y)
            blocked = np.hypot(*(nearest - (x, y))) < distance <= np.hypot(ends[:, 0], ends[:, 1]).min()
            discs.append(Disc(float(x), float(y), distance) if blocked else None)
        return discs


def _end(pose: Pose, yaw: Optional[float]) -> Tuple[float, ...]:
    """A start or goal as the planner takes it: without a heading where any will do."""
    return pose[:2] if yaw is None else pose


def _with_plan(robot: Robot, plan: Plan) -> Robot:
    return replace(robot, plan=plan)


def _joined(first: Plan, second: Plan) -> Plan:
    """Two plans driven one after the other."""
    return replace(second, points=np.vstack((first.points, second.points[1:])), length=first.length + second.length,
                   social_cost=first.social_cost + second.social_cost, cost=first.cost + second.cost,
                   cells=np.vstack((first.cells, second.cells)), expanded=first.expanded + second.expanded,
                   search_time=first.search_time + second.search_time, start_yaw=first.start_yaw)
