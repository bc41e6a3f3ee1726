"""From promises to new schedules: always some, if only that robots stay where they have promised to stop."""

import logging
import math
from dataclasses import dataclass, field, replace
from typing import Callable, Dict, FrozenSet, List, Mapping, Optional, Tuple

import numpy as np

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.repair import PlannerReplanner
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import Schedule
from social_fleet.errors import Infeasible, InvalidGoal, InvalidInput, InvalidStart, NoPath, SocialFleetError
from social_fleet.execution.recovery.messages import Assignment
from social_fleet.execution.recovery.decision import SIMULTANEOUS, Need
from social_fleet.execution.recovery.remaining import ContinuingReplanner, Remaining, joined
from social_fleet.geometry import Pose
from social_fleet.planning.overlays.shapes import DiscObstacle
from social_fleet.planning.planner import SocialPlanner

log = logging.getLogger(__name__)

_SPARE_CELLS = (0.1, 0.5, 1.0, 2.0)  # tried one after the other
_SMALLEST = 0.05  # radius of an obstacle [m]
_LONGEST_REST = 60.0  # that a robot is expected to stand on at the most [s]


@dataclass(frozen=True)
class Options:
    """How schedules are made; see `coordinate`."""

    time_margin: float = 1.0
    tracking_tolerance: float = 0.1
    time_limit: float = 5.0
    repairs: int = 10


@dataclass
class Request:
    """What is to be planned in one exchange.

    Attributes
    ----------
    version : int
        Of the exchange.
    now : float
        [s].
    remaining : list of Remaining
        All robots that take part.
    need : Need
        Whom to plan anew.
    rests : mapping of str to float
        For how long robots are expected to stand on before they move [s].
    obstacles : mapping of str to DiscObstacle
        What the map does not hold.
    standing : mapping of str to tuple of DiscObstacle
        The places of robots that do not move, by their names: others are led round them.
    doubtful : frozenset of str
        Obstacles where a silent robot may be, but was not seen: driven through where there is no other way, for the
        lidar sees it if it is there.
    silent : frozenset of str
        Those among them that take no part, and cannot be waited for.
    give_up : frozenset of str
        Robots that need not wait any longer for a way to their goals.
    """

    version: int
    now: float
    remaining: List[Remaining]
    need: Need
    rests: Mapping[str, float] = field(default_factory=dict)
    obstacles: Mapping[str, DiscObstacle] = field(default_factory=dict)
    standing: Mapping[str, Tuple[DiscObstacle, ...]] = field(default_factory=dict)
    doubtful: FrozenSet[str] = frozenset()
    silent: FrozenSet[str] = frozenset()
    give_up: FrozenSet[str] = frozenset()


class Replanning:
    """Makes assignments for all that take part in an exchange.

    Parameters
    ----------
    planner_for : callable
        The planner for robots of a radius [m].
    options : Options
        Of the coordination.
    """

    def __init__(self, planner_for: Callable[[float], SocialPlanner], options: Options = Options()) -> None:
        self._planner_for = planner_for
        self._options = options

    def assignments(self, request: Request) -> Dict[str, Assignment]:
        """One for every robot that takes part."""
        job = _Job(request, self._planner_for, self._options)
        try:
            schedules = job.schedules()
        except (SocialFleetError, ValueError) as error:
            log.warning("exchange %d: no schedule, %s", request.version, error)
            schedules = _as_before(request) or job.all_staying()
        peers = tuple(item.report.name for item in request.remaining)
        result = {}
        for item in request.remaining:
            name = item.report.name
            reason = job.reasons.get(name, "")
            errand = item.report.errand
            result[name] = Assignment(
                item.report.session, replace(schedules[name], peers=tuple(peer for peer in peers if peer != name)),
                origin=0.0 if schedules[name].robot.committed is None else job.origin(item, schedules[name]),
                errand=0 if errand is None else errand.number, reason=reason,
                final=bool(reason) and (name in request.give_up or (item.report.final
                                                                    and reason == item.report.unserved)),
                temporary=name in job.temporary)
        return result


class _Job:
    """One call of `Replanning.assignments`."""

    def __init__(self, request: Request, planner_for: Callable[[float], SocialPlanner], options: Options) -> None:
        self.request = request
        self.options = options
        self.reasons: Dict[str, str] = {}
        self.temporary: List[str] = []
        self._planner_for = planner_for
        self._kept: Dict[str, Remaining] = {}
        self._unchanged: Dict[str, Schedule] = {}

    def schedules(self) -> Dict[str, Schedule]:
        """All robots', coordinated; raises what `coordinate` raises when even staying does not help."""
        robots = {item.report.name: self._robot(item) for item in self.request.remaining}
        by_name = {item.report.name: item for item in self.request.remaining}
        self._make_room(robots, by_name)
        free = set(by_name) if self.request.need.mode == SIMULTANEOUS else self.request.need.robots
        while True:
            former = [schedule for name, robot in robots.items() if name not in free and name in self._kept
                      for schedule in [by_name[name].former(robot)] if schedule is not None]
            replanner = ContinuingReplanner(PlannerReplanner(
                self._planner_for, overlays=self.request.obstacles), list(by_name.values()))
            try:
                fleet = coordinate(list(robots.values()), former=former, time_margin=self.options.time_margin,
                                   tracking_tolerance=self.options.tracking_tolerance,
                                   time_limit=self.options.time_limit, replanner=replanner,
                                   repairs=self.options.repairs, version=self.request.version)
                return dict(fleet.by_name)
            except Infeasible as error:
                self._let_stay(error, robots, by_name)

    def _let_stay(self, error: Infeasible, robots: Dict[str, Robot], by_name: Mapping[str, Remaining]) -> None:
        """Leave one of those that contradict each other where it has promised to stop."""
        moving = [name for name in error.robots if robots[name].path.length > by_name[name].committed + 1e-6]
        if not moving:
            raise error
        chosen = max(moving, key=lambda name: (name in self.request.need.robots, -robots[name].weight, name))
        self._stay(chosen, str(error), robots, by_name)

    def _stay(self, name: str, reason: str, robots: Dict[str, Robot], by_name: Mapping[str, Remaining]) -> None:
        self.reasons[name] = reason
        self._kept.pop(name, None)
        robots[name] = by_name[name].staying(self.request.now)

    def _make_room(self, robots: Dict[str, Robot], by_name: Mapping[str, Remaining]) -> None:
        """Nobody ends where another does: those that are there stay, those with the later errand wait."""
        changed = True
        while changed:
            changed = False
            for one in sorted(robots):
                for other in sorted(robots):
                    if one < other and self._crowded(robots[one], robots[other]):
                        movable = [name for name in (one, other)
                                   if robots[name].path.length > by_name[name].committed + 1e-6]
                        if not movable:
                            continue
                        chosen = max(movable, key=lambda name: (_errand_number(by_name[name]), name))
                        rest = other if chosen == one else one
                        self._stay(chosen, f"robot {rest} is to stand at the goal of {chosen}", robots, by_name)
                        changed = True

    def _crowded(self, one: Robot, other: Robot) -> bool:
        gap = one.path.points[-1] - other.path.points[-1]
        return bool(np.hypot(*gap) < one.body_radius + other.body_radius + 2.0 * self.options.tracking_tolerance)

    def _robot(self, item: Remaining) -> Robot:
        """A robot with its path: what is left of the present one where that does, else another, else none."""
        report, name = item.report, item.report.name
        depart = self.request.now + min(self.request.rests.get(name, 0.0), _LONGEST_REST)
        if report.errand is None:
            return item.staying(depart)
        anew = name in self.request.need.new_paths or report.errand.number != report.serving
        if report.unserved and report.errand.number == report.serving and not anew:
            self.reasons[name] = report.unserved
            return item.staying(depart)
        if name in self.request.give_up and report.blocked > 0.0:
            self.reasons[name] = f"something has held {name} up for {report.blocked:.0f} s, and no way round it helped"
            return item.staying(depart)
        obstructed = self._obstructed(item)
        if item.schedule is not None and not anew and not obstructed:
            self._kept[name] = item
            return item.robot(item.way, depart=depart, goal_yaw=item.goal_yaw)
        try:
            plan = self._planned(item)
        except (NoPath, InvalidInput) as error:
            usable = item.schedule is not None and self._leads_there(item) and not (obstructed & self.request.silent)
            reason = f"{name} has no way to its goal: {getattr(error, 'message', error)}"
            if usable and name not in self.request.give_up:
                self._kept[name] = item
                return item.robot(item.way, depart=depart, goal_yaw=item.goal_yaw)
            self.reasons[name] = reason
            return item.staying(depart)
        if plan.temporary:
            self.temporary.append(name)
        return item.robot(joined(item.prefix, plan.path), depart=depart, goal_yaw=plan.goal_yaw)

    def _planned(self, item: Remaining):  # type: ignore[no-untyped-def]
        report = item.report
        assert report.errand is not None
        others = {f"{name} {number}": shape for name, shapes in self.request.standing.items()
                  if name != report.name and name not in self.request.silent  # whose places are among the obstacles
                  for number, shape in enumerate(shapes)}
        overlays = {**self.request.obstacles, **others}
        planner = self._planner_for(report.body.radius)
        certain = {name: shape for name, shape in overlays.items() if name not in self.request.doubtful}
        for attempt in (overlays, certain):
            # it may stand nearer to an obstacle than a plan may begin; and obstacles are blocked cells to the planner
            for cells in _SPARE_CELLS:
                shrunk = {name: _beside(shape, item.end, report.body.radius, cells * planner.grid.resolution)
                          for name, shape in attempt.items()}
                try:
                    return planner.plan(item.end, report.errand.goal, overlays=shrunk)
                except InvalidStart as error:
                    failure: SocialFleetError = error
                except (InvalidGoal, NoPath) as error:
                    failure = error
                    break
        raise failure

    def _obstructed(self, item: Remaining) -> FrozenSet[str]:
        """Robots that stand for good in the way that is left, behind what the robot is committed to."""
        way, radius = item.way, item.report.body.radius
        beyond = way.slice(item.committed, way.length) if way.length > item.committed else None
        if beyond is None:
            return frozenset()
        points = beyond.position(np.linspace(0.0, beyond.length, int(beyond.length / 0.1) + 2))
        return frozenset(
            name for name, shapes in self.request.standing.items() for shape in shapes if name != item.report.name
            and (np.hypot(points[:, 0] - shape.x, points[:, 1] - shape.y) < shape.radius + radius - 0.05).any())

    def _leads_there(self, item: Remaining) -> bool:
        """Whether the present path ends at the goal of the errand."""
        assert item.schedule is not None and item.report.errand is not None
        end, goal = item.schedule.robot.path.points[-1], item.report.errand.goal
        return math.hypot(end[0] - goal[0], end[1] - goal[1]) < 1e-6

    def all_staying(self) -> Dict[str, Schedule]:
        """Everybody goes as far as promised, and stands."""
        result = {}
        for item in self.request.remaining:
            robot = item.staying(self.request.now)
            self.reasons[item.report.name] = "no schedule was found for the fleet"
            times = self.request.now + np.array([0.0, 2.0 * robot.path.length / robot.max_speed + 1.0])
            arcs = np.array([0.0, robot.path.length])
            result[robot.name] = Schedule(robot, arcs, times, version=self.request.version)
        return result

    def origin(self, item: Remaining, schedule: Schedule) -> float:
        """Where the new path begins on the one that the robot follows [m]."""
        unchanged = item.schedule is not None and schedule.robot.path is item.schedule.robot.path
        return 0.0 if unchanged else item.origin


def _as_before(request: Request) -> Optional[Dict[str, Schedule]]:
    """The schedules that are in force, under a new version; None where robots follow different ones, or none."""
    schedules = {item.report.name: item.schedule for item in request.remaining}
    if len({None if schedule is None else schedule.version for schedule in schedules.values()}) != 1:
        return None
    result = {}
    for item in request.remaining:
        schedule = item.schedule
        if schedule is None or item.report.lapsed:
            return None
        rules = tuple(replace(rule, other_version=request.version) if rule.other in schedules else rule
                      for rule in schedule.precedences)
        if any(rule.other not in schedules for rule in rules if rule.at > item.origin):
            return None
        result[item.report.name] = replace(schedule, precedences=rules, version=request.version,
                                           robot=_committed(schedule.robot, item.origin + item.committed))
    return result


def _beside(shape: DiscObstacle, pose: Pose, radius: float, spare: float) -> DiscObstacle:
    """An obstacle no larger than leaves a robot room to stand at `pose`, and `spare` [m] more."""
    room = math.hypot(shape.x - pose.x, shape.y - pose.y) - radius - spare
    return shape if shape.radius <= room else DiscObstacle(shape.x, shape.y, max(room, _SMALLEST))


def _committed(robot: Robot, bound: float) -> Robot:
    changed = replace(robot, committed=bound)
    object.__setattr__(changed, "path", robot.path)
    return changed


def _errand_number(item: Remaining) -> Tuple[int, str]:
    return (0 if item.report.errand is None else item.report.errand.number, item.report.name)
