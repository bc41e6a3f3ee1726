"""New ways for robots of a fleet: round others, aside, or from where they stand, as repair asks for them."""

from dataclasses import replace
from typing import Callable, Dict, Iterator, List, Optional, Sequence, Tuple

import numpy as np

from social_fleet.coordination.robot import Robot
from social_fleet.errors import InvalidPose, NoPath
from social_fleet.geometry import Polyline, Pose
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.overlays.discs import Disc
from social_fleet.planning.overlays.overlay_set import Overlays
from social_fleet.planning.plan import Plan
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.regions import Regions

_RASTER = 0.3  # spacing of places to stand [m]
_SPACING = 1.5  # between places aside that are tried [m]
_SAMPLES = 0.1  # spacing of the points that stand for a path [m]
_PLACES = 6  # places aside that are tried for one robot
_ASIDE_REACH = 25.0  # how far from its start a robot steps aside at most, as the crow flies [m]


class Replanner:
    """What repair needs of a planner; `PlannerReplanner` searches in this process.

    Attributes
    ----------
    leads_anywhere : bool
        Whether it has `way`, `regions` and `standing_room`, which fleets that take turns need.
    """

    leads_anywhere = False

    def detour(self, robot: Robot, avoid: Sequence[Disc]) -> Optional[Robot]:
        """`robot` with a path whose centre line keeps out of the discs; None when there is none."""
        raise NotImplementedError

    def aside(self, robot: Robot, others: Sequence[Robot], distance: float, avoid: Sequence[Disc]) -> Iterator[Robot]:
        """`robot` with paths by way of places at least `distance` [m] from the paths of `others`, nearest first."""
        raise NotImplementedError

    def way(self, robot: Robot, start: np.ndarray, goal: np.ndarray, avoid: Sequence[Disc]) -> Optional[Plan]:
        """A path for `robot` between two places [m], in its own headings at its own ends; None when there is none."""
        raise NotImplementedError

    def regions(self, robot: Robot, avoid: Sequence[Disc]) -> Regions:
        """What `robot` can reach from where when its centre has to keep out of the discs."""
        raise NotImplementedError

    def standing_room(self, robot: Robot) -> np.ndarray:
        """Where `robot` fits, on a coarse raster (M, 2) [m]."""
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

    leads_anywhere = True

    def __init__(self, planner_for: Callable[[float], SocialPlanner], *, overlays: Overlays = ()) -> None:
        self._planner_for = planner_for
        self._overlays = overlays
        self._room: Dict[float, np.ndarray] = {}

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
                yield _with_plan(robot, joined(to_place, onward))

    def way(self, robot: Robot, start: np.ndarray, goal: np.ndarray, avoid: Sequence[Disc]) -> Optional[Plan]:
        """See `Replanner`."""
        at_start, at_goal = (start == robot.path.points[0]).all(), (goal == robot.path.points[-1]).all()
        return self._plan(robot, _end(robot.start, robot.start_yaw) if at_start else tuple(start),
                          _end(robot.goal, robot.goal_yaw) if at_goal else tuple(goal), avoid)

    def regions(self, robot: Robot, avoid: Sequence[Disc]) -> Regions:
        """See `Replanner`."""
        planner = self._planner_for(robot.body_radius)
        return Regions(planner.grid, planner.lattice, avoid)

    def standing_room(self, robot: Robot) -> np.ndarray:
        """See `Replanner`."""
        radius = robot.body_radius
        if radius not in self._room:
            self._room[radius] = _raster(self._planner_for(radius).way)
        return self._room[radius]

    def _places(self, robot: Robot, others: Sequence[Robot], distance: float) -> List[Tuple[float, float]]:
        """Free places near the robot's start that keep clear of the others' paths, nearest first, apart."""
        return (self._nearest(self.standing_room(robot), robot, others, distance)
                or self._nearest(_raster(self._planner_for(robot.body_radius).space), robot, others, distance))

    @staticmethod
    def _nearest(places: np.ndarray, robot: Robot, others: Sequence[Robot],
                 distance: float) -> List[Tuple[float, float]]:
        reach = np.hypot(*(places - robot.path.points[0]).T)
        places = places[reach < _ASIDE_REACH]
        places = places[sure_gaps(places, [other.path for other in others]) >= distance]
        return [(float(x), float(y)) for x, y in nearest_apart(places, robot.path.points[0], apart=_SPACING,
                                                               most=_PLACES)]

    def _plan(self, robot: Robot, start: Sequence[float], goal: Sequence[float],
              avoid: Sequence[Disc]) -> Optional[Plan]:
        try:
            return self._planner_for(robot.body_radius).plan(start, goal, avoid=avoid, overlays=self._overlays)
        except (NoPath, InvalidPose):
            return None


def _raster(space: ConfigurationSpace) -> np.ndarray:
    """Where a robot fits, coarsely (M, 2) [m]."""
    stride = max(1, int(round(_RASTER / space.grid.resolution)))
    rows, columns = np.nonzero(space.free[::stride, ::stride])
    return space.grid.centres(np.stack((rows, columns), axis=1) * stride)


def sure_gaps(places: np.ndarray, ways: Sequence[Polyline]) -> np.ndarray:
    """How far some places (M, 2) [m] are from the nearest of some ways at least (M,) [m]; infinite without ways."""
    from scipy.spatial import cKDTree
    if not ways:
        return np.full(len(places), np.inf)
    samples = np.vstack([way.position(np.arange(0.0, way.length + _SAMPLES, _SAMPLES)) for way in ways])
    return cKDTree(samples).query(places)[0] - _SAMPLES


def nearest_apart(places: np.ndarray, origin: np.ndarray, *, apart: float, most: int,
                  besides: Sequence[np.ndarray] = ()) -> List[np.ndarray]:
    """Of some places (M, 2) [m] the nearest to `origin`, `apart` [m] from each other and from `besides`."""
    chosen: List[np.ndarray] = []
    for place in places[np.argsort(np.hypot(*(places - origin).T), kind="stable")]:
        if all(np.hypot(*(place - other)) >= apart for other in (*besides, *chosen)):
            chosen.append(place)
        if len(chosen) == most:
            break
    return chosen


def _end(pose: Pose, yaw: Optional[float]) -> Tuple[float, ...]:
    """A start or goal as the planner takes it: without a heading where any will do."""
    return pose[:2] if yaw is None else pose


def _with_plan(robot: Robot, plan: Plan) -> Robot:
    return replace(robot, plan=plan)


def plan_of(robot: Robot) -> Plan:
    """The robot's path as a plan; where it was given as points, one without a social cost [m]."""
    if isinstance(robot.plan, Plan):
        return robot.plan
    length = robot.path.length
    return Plan(robot.path.points, length, 0.0, length, 0, 0.0, "given", robot.body_radius)


def joined(first: Plan, second: Plan) -> Plan:
    """Two plans driven one after the other."""
    return replace(second, points=np.vstack((first.points, second.points[1:])), length=first.length + second.length,
                   social_cost=first.social_cost + second.social_cost, cost=first.cost + second.cost,
                   cells=np.vstack((first.cells, second.cells)), expanded=first.expanded + second.expanded,
                   search_time=first.search_time + second.search_time, start_yaw=first.start_yaw)
