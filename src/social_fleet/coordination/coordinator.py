"""Coordination of a fleet's timing: from paths to schedules that keep all robots apart (3.3)."""

import logging
import math
import time
from dataclasses import replace
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple, TypeVar

import numpy as np

from social_fleet.coordination.encounters import Encounter, EncounterFinder, Order, contradiction, forced_reasons
from social_fleet.coordination.event_graph import Motion
from social_fleet.coordination.former_orders import FormerOrders
from social_fleet.coordination.options import OUT_OF_TIME, check_options
from social_fleet.coordination.order_search import Contradiction
from social_fleet.coordination.paper_program import solve_as_printed
from social_fleet.coordination.program import ExactProgram, Solution
from social_fleet.coordination.repair import Repairs
from social_fleet.coordination.replanning import Replanner
from social_fleet.coordination.request import check_fleet
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import EncounterWindow, FleetSchedule, Precedence, Schedule
from social_fleet.coordination.solvers import find_solver
from social_fleet.coordination.timing import Timing, nominal_timing
from social_fleet.coordination.turns import Turn, sides_of
from social_fleet.errors import Infeasible, TimedOut

log = logging.getLogger(__name__)

_Result = TypeVar("_Result")

_PATIENCE = 5.0  # for any schedule on given paths, while the robots could take turns instead [s]


def coordinate(robots: Sequence[Robot], *, mode: str = "simultaneous", fixed: Sequence[Schedule] = (),
               former: Sequence[Schedule] = (),
               formulation: str = "exact", objective: str = "sum_of_completion", time_margin: float = 1.0,
               tracking_tolerance: float = 0.1, gap: float = 1e-3, effort: int = 1, time_limit: float = 30.0,
               solver: Optional[str] = None, replanner: Optional[Replanner] = None, repairs: int = 50,
               partial: bool = False, version: int = 1, finder: Optional[EncounterFinder] = None) -> FleetSchedule:
    """Schedules for `robots` along their paths such that no two discs ever touch.

    Parameters
    ----------
    robots : sequence of Robot
        The robots to schedule, in any order: the result depends on their names only.
    mode : str
        ``simultaneous`` or ``unified``: all at once, round what is `fixed`; ``sequential``: one after the other in
        the given order, each round those before it.
    fixed : sequence of Schedule
        Schedules already under way, on the same clock, in any order. Their motion is not changed, but their robots may
        get to wait for a planned one: see `FleetSchedule.amended`.
    former : sequence of Schedule
        Schedules of some of `robots` that were in force, along the present paths: these robots keep their order among
        each other.
    formulation : str
        ``exact``, safe at any speed, or ``paper``: Eq. 5-8 as printed, which may let robots touch.
    objective : str
        ``sum_of_completion``: the arrivals, each times its robot's weight; or ``makespan``: the last of them.
    gap : float
        Relative distance to the proven bound at which a schedule is good enough; 0 for the optimum.
    effort : int
        How often search and proof take turns where the gap stays open: a large fleet's schedule gets better with more.
    time_margin : float
        delta, the time between one robot's leaving a window and the next one's entering [s].
    tracking_tolerance : float
        How far a robot may be from where its schedule says [m].
    time_limit : float
        Wall time for everything [s].
    solver : str, optional
        ``highs``, ``cbc`` or another of PuLP's; by default the best that is there.
    replanner : Replanner, optional
        Finds other paths where these admit no schedule; without one that is an error.
    repairs : int
        Greatest number of repairs: of one path each, or of all that have to make way in turn.
    partial : bool
        Where no schedule serves all, leave robots out, one by one, until the rest have one: see
        `FleetSchedule.unserved`. They count as standing at their starts for ever; one that would there be in the way
        of a `fixed` schedule cannot be left out.
    version : int
        Stamped on the schedules.
    finder : EncounterFinder, optional
        One that knows some windows already; of the same `tracking_tolerance`.

    Returns
    -------
    FleetSchedule
        In the order of `robots`.

    Raises
    ------
    InvalidScenario
        Two robots of one name, touching starts or goals, touching schedules under way, or an option out of range.
    InvalidParameter
        No such solver.
    Infeasible
        No schedule on these paths; the message names the robots and why.
    TimedOut, SolverFailed
    """
    check_options(mode=mode, formulation=formulation, objective=objective, effort=effort, repairs=repairs, gap=gap,
                  time_margin=time_margin, tracking_tolerance=tracking_tolerance, time_limit=time_limit)
    check_fleet(robots, fixed, tracking_tolerance)
    find_solver(solver, time_limit)
    job = _Job(fixed, finder or EncounterFinder(tracking_tolerance), time.monotonic() + time_limit, replanner, _Options(
        time_margin, objective == "makespan", gap, effort, solver, repairs, partial, version), FormerOrders(former))
    if formulation == "paper":
        return job.run_as_printed(robots)
    if mode == "sequential":
        return job.run_one_by_one(robots)
    return job.run(robots)


class _Options(NamedTuple):
    """How a call of `coordinate` wants its schedule; see there."""

    margin: float
    makespan: bool
    gap: float
    effort: int
    solver: Optional[str]
    repairs: int
    partial: bool
    version: int


class _Job:
    """One call of `coordinate`."""

    def __init__(self, fixed: Sequence[Schedule], finder: EncounterFinder, deadline: float,
                 replanner: Optional[Replanner], options: "_Options", former: FormerOrders) -> None:
        self.fixed = sorted(fixed, key=lambda schedule: schedule.name)
        self.given = {schedule.name: schedule for schedule in fixed}
        self.deadline = deadline
        self.replanner = replanner
        self.finder = finder
        self.options = options
        self.former = former
        self.unserved: Dict[str, str] = {}
        self._timings: Dict[str, Tuple[Robot, Timing]] = {}

    def run(self, robots: Sequence[Robot]) -> FleetSchedule:
        """All robots at once, repaired where needed."""
        planned = sorted(robots, key=lambda robot: robot.name)
        spent = {"encounters": 0.0, "solve": 0.0, "repair": 0.0}
        mender = None if self.replanner is None else Repairs(
            self.finder, self.replanner, self._feasible, limit=self.options.repairs,
            expired=lambda: time.monotonic() > self.deadline)
        while True:
            fleet = planned + [schedule.robot for schedule in self.fixed]
            encounters = _timed(spent, "encounters", lambda: self.former.applied(
                self.finder.find(fleet, fixed=len(self.fixed)), fleet))
            try:
                turns = () if mender is None else mender.turns
                patience = _PATIENCE if mender is not None and mender.may_take_turns(planned) else math.inf
                solution = _timed(spent, "solve", lambda: self._solve(planned, encounters, turns=turns,
                                                                      patience=patience))
                break
            except Infeasible as error:
                if time.monotonic() > self.deadline:
                    raise
                reason = error
            except TimedOut:
                if math.isinf(patience) or time.monotonic() > self.deadline:
                    raise
                reason = _undecided(planned)
            planned = _timed(spent, "repair", lambda: self._mended(mender, planned, fleet, encounters, reason))
        schedules = self._schedules(fleet, encounters, solution)
        windows = [_window(fleet, encounter, order) for encounter, order in zip(encounters, solution.orders)]
        return FleetSchedule(
            tuple(schedules[robot.name] for robot in robots if robot.name in schedules), tuple(windows), "exact",
            objective=solution.objective, gap=_gap(solution.objective, solution.bound),
            planning_time=spent["repair"], encounter_time=spent["encounters"], solve_time=spent["solve"],
            message="" if mender is None else "; ".join(mender.notes), amended=self._amended(),
            unserved=tuple(sorted(self.unserved.items())))

    def run_one_by_one(self, robots: Sequence[Robot]) -> FleetSchedule:
        """Each robot round those before it; anew where one that is left out stands in the way of those before."""
        while True:
            begun, parts = list(self.fixed), []
            for robot in robots:
                if robot.name not in self.unserved:
                    parts.append(self.run([robot]))
                    self.fixed += parts[-1].schedules
            standing = [schedule for schedule in self.fixed[len(begun):] if schedule.name in self.unserved]
            driven = [schedule for schedule in self.fixed if schedule.name not in self.unserved]
            if not any(self._is_in_the_way(schedule.robot, driven) for schedule in standing):
                break
            self.fixed = begun + standing
        latest = {schedule.name: schedule for schedule in self.fixed}
        return FleetSchedule(
            tuple(latest[robot.name] for robot in robots if robot.name not in self.unserved),
            tuple(window for part in parts for window in part.windows), "exact",
            objective=_total([part.objective for part in parts], self.options.makespan),
            gap=max((part.gap for part in parts), default=0.0),
            planning_time=sum(part.planning_time for part in parts),
            encounter_time=sum(part.encounter_time for part in parts),
            solve_time=sum(part.solve_time for part in parts),
            message="; ".join(part.message for part in parts if part.message), amended=self._amended(),
            unserved=tuple(sorted(self.unserved.items())))

    def run_as_printed(self, robots: Sequence[Robot]) -> FleetSchedule:
        """Eq. 5-8 of the paper, all windows at once."""
        if time.monotonic() > self.deadline:
            raise TimedOut(OUT_OF_TIME)
        planned = sorted(robots, key=lambda robot: robot.name)
        fleet = planned + [schedule.robot for schedule in self.fixed]
        spent = {"encounters": 0.0, "solve": 0.0}
        encounters = _timed(spent, "encounters", lambda: self.finder.find(fleet, fixed=len(self.fixed)))
        result = _timed(spent, "solve", lambda: solve_as_printed(
            fleet, self.fixed, encounters, margin=self.options.margin, solver=self.options.solver,
            deadline=self.deadline))
        schedules = {robot.name: Schedule(robot, arcs, times, version=self.options.version)
                     for robot, (arcs, times) in zip(planned, result.knots)}
        windows = [_window(fleet, encounter, encounter.orders[side])
                   for encounter, side in zip(encounters, result.sides)]
        return FleetSchedule(tuple(schedules[robot.name] for robot in robots), tuple(windows), "paper",
                             objective=result.objective,
                             gap=_gap(result.objective, result.bound),
                             encounter_time=spent["encounters"], solve_time=spent["solve"])

    def _solve(self, planned: Sequence[Robot], encounters: Sequence[Encounter], *, alone: bool = False,
               turns: Sequence[Turn] = (), patience: float = math.inf) -> Solution:
        fixed = [] if alone else self.fixed
        fleet = list(planned) + [schedule.robot for schedule in fixed]
        contradictory = [encounter for encounter in encounters if contradiction(encounter, fleet)]
        if contradictory:
            raise _infeasible(contradictory[:1], fleet)
        motions = [Motion(self._timing(robot), robot.depart, weight=robot.weight) for robot in planned]
        known = sides_of(turns, fleet, encounters) if turns else None
        motions += [Motion(Timing(schedule.arc_lengths, schedule.times), 0.0, fixed=True) for schedule in fixed]
        try:
            return ExactProgram(motions, encounters, margin=self.options.margin, makespan=self.options.makespan,
                                gap=self.options.gap, effort=self.options.effort, solver=self.options.solver,
                                known=known).solve(deadline=self.deadline, patience=patience)
        except Contradiction as error:
            raise _infeasible([encounters[window] for window in error.windows], fleet) from error

    def _mended(self, mender: Optional[Repairs], planned: Sequence[Robot],
                fleet: Sequence[Robot], encounters: Sequence[Encounter], error: Infeasible) -> List[Robot]:
        """The robots with other paths; or without one of them, where that is allowed."""
        try:
            if mender is None:
                raise error
            contradictions = sum(contradiction(encounter, fleet) is not None for encounter in encounters)
            return mender.mend(planned, fleet, error, contradictions=contradictions)
        except Infeasible:
            if not self.options.partial:
                raise
        given = [schedule for schedule in self.fixed if schedule.name in self.given]
        candidates = [robot for robot in planned if robot.name in error.robots
                      and not self._is_in_the_way(_standing(robot), given)]
        if not candidates:
            raise error
        named = [name for pair in error.pairs for name in pair]
        left = max(candidates, key=lambda robot: (-self._blocks(robot, fleet, error), named.count(robot.name),
                                                  -robot.weight, robot.name))
        log.warning("%s stays where it is: %s", left.name, error)
        self.unserved[left.name] = str(error)
        self.fixed.append(Schedule(_standing(left), np.zeros(1), np.zeros(1), version=self.options.version))
        return [robot for robot in planned if robot.name != left.name]

    def _blocks(self, robot: Robot, fleet: Sequence[Robot], error: Infeasible) -> int:
        """In how many of the contradictory windows a robot would stand in the way even if it never left its start."""
        others = {name for pair in error.pairs if robot.name in pair for name in pair} - {robot.name}
        return sum(window.r_ends[0] for other in fleet if other.name in others
                   for window in self.finder.between(robot, other))

    def _is_in_the_way(self, standing: Robot, driven: Sequence[Schedule]) -> bool:
        """Whether one that never moves is in the way of schedules that are settled: nothing keeps those from it."""
        finder = EncounterFinder(self.finder.tolerance)
        return any(finder.between(standing, schedule.robot) for schedule in driven)

    def _feasible(self, robots: Sequence[Robot]) -> bool:
        """Whether a few robots have a schedule among themselves; fixed ones count as still to be planned."""
        few = sorted(robots, key=lambda robot: robot.name)
        try:
            self._solve(few, self.former.applied(EncounterFinder(self.finder.tolerance).find(few), few), alone=True)
        except Infeasible:
            return False
        return True

    def _timing(self, robot: Robot) -> Timing:
        known, timing = self._timings.get(robot.name, (None, None))
        if known is not robot or timing is None:
            timing = nominal_timing(robot.path, robot.limits, start_yaw=robot.start_yaw, goal_yaw=robot.goal_yaw)
            self._timings[robot.name] = robot, timing
        return timing

    def _schedules(self, fleet: Sequence[Robot], encounters: Sequence[Encounter],
                   solution: Solution) -> Dict[str, Schedule]:
        version = self.options.version
        versions = [version] * (len(fleet) - len(self.fixed)) + [schedule.version for schedule in self.fixed]
        precedences: Dict[int, List[Precedence]] = {}
        for order in solution.orders:
            precedences.setdefault(order.follower, []).extend(
                Precedence(float(at), fleet[order.leader].name, float(clear), versions[order.leader])
                for at, clear in zip(order.at, order.clear))
        schedules = {}
        for index in range(len(fleet) - len(self.fixed)):
            robot = fleet[index]
            arcs, times = solution.paces[index].knots(self._timing(robot))
            schedules[robot.name] = Schedule(robot, arcs, times, _sorted(precedences.get(index, [])), version)
        for place, schedule in enumerate(self.fixed):
            kept = [rule for rule in schedule.precedences if rule.other not in schedules]
            waits = precedences.get(len(fleet) - len(self.fixed) + place, [])
            self.fixed[place] = replace(schedule, precedences=_sorted(kept + waits))
        return schedules

    def _amended(self) -> Tuple[Schedule, ...]:
        """The given fixed schedules whose precedences changed."""
        return tuple(schedule for schedule in self.fixed if schedule.name in self.given
                     and schedule.precedences != self.given[schedule.name].precedences)


def _standing(robot: Robot) -> Robot:
    """The same robot, parked at its start for ever."""
    return Robot(robot.name, robot.path.points[:1], robot.max_speed, robot.body_radius)


def _sorted(rules: Sequence[Precedence]) -> Tuple[Precedence, ...]:
    return tuple(sorted(rules, key=lambda rule: (rule.at, rule.other, rule.other_at)))


def _timed(spent: Dict[str, float], what: str, work: Callable[[], _Result]) -> _Result:
    begun = time.perf_counter()
    try:
        return work()
    finally:
        spent[what] += time.perf_counter() - begun


def _total(objectives: Sequence[float], makespan: bool) -> float:
    return max(objectives, default=0.0) if makespan else sum(objectives)


def _gap(objective: float, bound: float) -> float:
    return max(objective - bound, 0.0) / objective if objective > 0.0 else 0.0


def _window(fleet: Sequence[Robot], encounter: Encounter, order: Order) -> EncounterWindow:
    return EncounterWindow(fleet[encounter.r].name, fleet[encounter.s].name, encounter.kind,
                           encounter.r_extent[0], encounter.r_extent[1], encounter.s_extent[0], encounter.s_extent[1],
                           first=fleet[order.leader].name)


def _undecided(planned: Sequence[Robot]) -> Infeasible:
    """That no schedule was found on these paths; that there is none is not known."""
    return Infeasible("no schedule was found on these paths; allow more time, or send fewer robots at once",
                      robots=[robot.name for robot in planned])


def _infeasible(encounters: Sequence[Encounter], fleet: Sequence[Robot]) -> Infeasible:
    """The contradiction of some windows as a sentence."""
    clauses = []
    for encounter in encounters:
        r, s = fleet[encounter.r], fleet[encounter.s]
        x, y = r.path.position(sum(encounter.r_extent) / 2.0)
        reasons = " and ".join(forced_reasons(encounter, fleet)) or f"{r.name} and {s.name} cannot pass each other"
        clauses.append(f"{reasons} near ({x:.1f}, {y:.1f})")
    names = sorted({fleet[index].name for encounter in encounters for index in (encounter.r, encounter.s)})
    return Infeasible(
        "no schedule on these paths: " + "; ".join(clauses) + ". Give one of them another path, start or goal",
        robots=names, pairs=[(fleet[encounter.r].name, fleet[encounter.s].name) for encounter in encounters])
