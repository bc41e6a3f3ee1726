"""From promises to new schedules: always some, if only that robots stay where they have promised to stop."""

import logging
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Callable, Dict, Mapping, Optional, Tuple

import numpy as np

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.replanning import PlannerReplanner
from social_fleet.coordination.robot import Robot, safety_distance
from social_fleet.coordination.schedule import Schedule
from social_fleet.errors import Infeasible, SocialFleetError
from social_fleet.execution.recovery.decision import SIMULTANEOUS
from social_fleet.execution.recovery.messages import Assignment
from social_fleet.execution.recovery.remaining import ContinuingReplanner, Remaining
from social_fleet.execution.recovery.ways import Request, Ways
from social_fleet.planning.planner import SocialPlanner

__all__ = ["Options", "Replanning", "Request"]

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Options:
    """How schedules are made; see `coordinate`."""

    time_margin: float = 1.0
    tracking_tolerance: float = 0.1
    time_limit: float = 5.0
    repairs: int = 10


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
        """One for every robot that takes part; none where all are dead."""
        if not request.remaining:
            return {}
        job = _Job(request, self._planner_for, self._options)
        before = None
        try:
            schedules = job.schedules()
        except (SocialFleetError, ValueError) as error:
            log.warning("exchange %d: no schedule, %s", request.version, error)
            before = job.as_before()
            schedules = job.all_staying() if before is None else before
        peers = [item.report.name for item in request.remaining]
        return {item.report.name: self._assignment(
            item, replace(schedules[item.report.name], peers=tuple(sorted(set(peers) - {item.report.name}))), job,
            0.0 if before is not None else item.origin) for item in request.remaining}

    @staticmethod
    def _assignment(item: Remaining, schedule: Schedule, job: "_Job", origin: float) -> Assignment:
        report, name = item.report, item.report.name
        reason = job.ways.reasons.get(name, "")
        final = name in job.request.give_up or (report.final and reason == report.unserved)
        return Assignment(report.session, schedule, origin, 0 if report.errand is None else report.errand.number,
                          reason, bool(reason) and final, name in job.ways.temporary)


class _Job:
    """One call of `Replanning.assignments`."""

    def __init__(self, request: Request, planner_for: Callable[[float], SocialPlanner], options: Options) -> None:
        self.request = request
        self.options = options
        self.ways = Ways(request, planner_for)
        self._planner_for = planner_for
        self._by_name = {item.report.name: item for item in request.remaining}

    def schedules(self) -> Dict[str, Schedule]:
        """All robots', coordinated; raises what `coordinate` raises when even staying does not help."""
        robots = {name: self.ways.robot(item) for name, item in self._by_name.items()}
        self._make_room(robots)
        free = set(robots) if self.request.need.mode == SIMULTANEOUS else self.request.need.robots
        replanner = ContinuingReplanner(PlannerReplanner(self._planner_for, overlays=self.request.obstacles),
                                        self.request.remaining)
        while True:
            former = [self._by_name[name].former(robot) for name, robot in robots.items()
                      if name not in free and name in self.ways.kept]
            try:
                fleet = coordinate(list(robots.values()), former=[schedule for schedule in former if schedule],
                                   time_margin=self.options.time_margin,
                                   tracking_tolerance=self.options.tracking_tolerance,
                                   time_limit=self.options.time_limit, replanner=replanner,
                                   repairs=self.options.repairs, version=self.request.version)
                return dict(fleet.by_name)
            except Infeasible as error:
                self._let_stay(error, robots)

    def _let_stay(self, error: Infeasible, robots: Dict[str, Robot]) -> None:
        """Leave one of those that contradict each other where it has promised to stop."""
        moving = [name for name in error.robots if self._moves(robots[name])]
        if not moving:
            raise error
        chosen = max(moving, key=lambda name: (name in self.request.need.robots, -robots[name].weight, name))
        robots[chosen] = self.ways.stays(self._by_name[chosen], str(error))

    def _make_room(self, robots: Dict[str, Robot]) -> None:
        """Nobody ends where another does: those that are there stay, those with the later errand wait."""
        pair = self._crowded_pair(robots)
        while pair is not None:
            chosen = max((name for name in pair if self._moves(robots[name])),
                         key=lambda name: (_errand_number(self._by_name[name]), name))
            rest = pair[0] if chosen == pair[1] else pair[1]
            robots[chosen] = self.ways.stays(self._by_name[chosen],
                                             f"robot {rest} is to stand at the goal of {chosen}")
            pair = self._crowded_pair(robots)

    def _crowded_pair(self, robots: Mapping[str, Robot]) -> Optional[Tuple[str, str]]:
        """Two robots that would end too close to each other, one of which at least need not; None: no such two."""
        for one, other in combinations(sorted(robots), 2):
            gap = robots[one].path.points[-1] - robots[other].path.points[-1]
            needed = safety_distance(robots[one].body_radius, robots[other].body_radius,
                                     self.options.tracking_tolerance)
            if np.hypot(*gap) < needed and (self._moves(robots[one]) or self._moves(robots[other])):
                return one, other
        return None

    def _moves(self, robot: Robot) -> bool:
        """Whether it goes farther than it has promised to stop."""
        return robot.path.length > self._by_name[robot.name].committed + 1e-6

    def as_before(self) -> Optional[Dict[str, Schedule]]:
        """The schedules in force, under a new version.

        None where robots follow different ones, lapsed or have none, or where one would drive to a goal that was taken
        back.
        """
        result: Dict[str, Schedule] = {}
        for name, item in self._by_name.items():
            schedule = item.schedule
            if schedule is None or item.report.lapsed or schedule.version != next(iter(
                    self._by_name.values())).report.version:
                return None
            if item.report.errand is None and item.way.length > item.committed + 1e-6:
                return None
            rules = tuple(replace(rule, other_version=self.request.version) for rule in schedule.precedences
                          if rule.other in self._by_name)
            if any(rule.other not in self._by_name for rule in schedule.precedences if rule.at > item.origin):
                return None
            result[name] = replace(schedule, precedences=rules, version=self.request.version,
                                   robot=replace(schedule.robot, committed=item.origin + item.committed))
        self._explain()
        return result

    def _explain(self) -> None:
        """Who has a new errand, or needed another path, does not get it this time."""
        self.ways.reasons.clear()
        self.ways.temporary.clear()
        for name, item in self._by_name.items():
            errand = item.report.errand
            new = errand is not None and errand.number != item.report.serving
            if new or name in self.request.need.new_paths:
                self.ways.reasons[name] = "no schedule was found for the fleet"
            elif item.report.unserved:
                self.ways.reasons[name] = item.report.unserved

    def all_staying(self) -> Dict[str, Schedule]:
        """Everybody goes as far as promised, and stands."""
        result = {}
        for item in self.request.remaining:
            robot = self.ways.stays(item, "no schedule was found for the fleet")
            times = self.request.now + np.array([0.0, 2.0 * robot.path.length / robot.max_speed + 1.0])
            arcs = np.array([0.0, robot.path.length])
            result[robot.name] = Schedule(robot, arcs, times, version=self.request.version)
        return result


def _errand_number(item: Remaining) -> Tuple[int, str]:
    return (0 if item.report.errand is None else item.report.errand.number, item.report.name)
