"""A scenario with faults from beginning to end: driven, judged, and reported like any other run."""

import time
from dataclasses import dataclass
from typing import Callable, Dict, List, Mapping, Optional, Tuple

import numpy as np

from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.execution.config import TrackerConfig
from social_fleet.execution.recovery.config import RecoveryConfig
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.fleet import FleetPlanner
from social_fleet.scenario.fleet_run import FleetRun, drive, longest_fault
from social_fleet.scenario.recording import Recording
from social_fleet.scenario.report import Report, RobotReport
from social_fleet.scenario.scenario import Expect, Scenario
from social_fleet.scenario.verdict import Verdict, judge_faulty_run

_PATIENCE = 300.0  # beyond the makespan, three times, and the last fault [s]: then a wait is one without end


@dataclass(frozen=True)
class FaultyRun:
    """What came of it.

    Attributes
    ----------
    verdict : Verdict
        By what was recorded alone.
    recording : Recording
        True motion.
    decisions : tuple of str
        Of the dispatcher, with times.
    replans : dict of str to int
        By robot.
    gave_up : dict of str to str
        Robots that gave their errands up, and why.
    wall_time : float
        Of the drive [s].
    """

    verdict: Verdict
    recording: Recording
    decisions: Tuple[str, ...]
    replans: Dict[str, int]
    gave_up: Mapping[str, str]
    wall_time: float


def drive_scenario(scenario: Scenario, fleet: FleetSchedule, grid: OccupancyGrid, *,
                   planners: Optional[FleetPlanner] = None, tracker: TrackerConfig = TrackerConfig(),
                   recovery: RecoveryConfig = RecoveryConfig(),
                   progress: Optional[Callable[[float], None]] = None) -> FaultyRun:
    """Drive a scenario until nothing more is to be expected, and judge the run.

    Parameters
    ----------
    fleet : FleetSchedule
        What the robots set out with.
    planners : FleetPlanner, optional
        For new paths; by default with the scenario's overrides.
    progress : callable, optional
        Told a share of the longest that the run may take.
    """
    begun = time.perf_counter()
    run = FleetRun(scenario, fleet, grid, planners or FleetPlanner(grid, scenario.planner), tracker=tracker,
                   recovery=recovery)
    deadline = 3.0 * fleet.makespan + longest_fault(scenario.faults) + _PATIENCE
    drive(run, deadline=deadline, progress=None if progress is None else _shares(progress, deadline))
    spent = time.perf_counter() - begun
    recording = run.recorder.recording()
    verdict = judge_faulty_run(scenario, recording, np.array(run.commands), grid, run.gave_up)
    return FaultyRun(verdict, recording, tuple(run.decisions), dict(run.replans), run.gave_up, spent)


def _shares(progress: Callable[[float], None], deadline: float) -> Callable[[float], None]:
    return lambda now: progress(min(now / deadline, 1.0))


def report_of(scenario: Scenario, fleet: FleetSchedule, run: FaultyRun) -> Report:
    """The run as report.json has it, by the scenario's expectations."""
    verdict = run.verdict
    robots = tuple(_robot_report(fleet, name, run) for name in fleet.by_name)
    times = list(verdict.arrivals.values())
    complete = len(times) == len(robots)
    failures = _failures(scenario.expect, robots, run)
    return Report(scenario.name, not failures, tuple(failures), max(times, default=0.0) if complete else None,
                  sum(times) if complete else None, verdict.contacts, verdict.min_clearance, None, robots,
                  run.wall_time, verdict.duration)


def _robot_report(fleet: FleetSchedule, name: str, run: FaultyRun) -> RobotReport:
    recording = run.recording
    index = recording.index(name)
    errors = np.zeros(1)
    if recording.references is not None:
        gaps = recording.poses[:, index, :2] - recording.references[:, index]
        known = np.hypot(gaps[:, 0], gaps[:, 1])
        errors = known[np.isfinite(known)] if np.isfinite(known).any() else errors
    schedule, arrival = fleet[name], run.verdict.arrivals.get(name)
    return RobotReport(name, arrival is not None, arrival, schedule.arrival_time, schedule.robot.path.length,
                       float(errors.max()), float(np.percentile(errors, 95)), run.replans.get(name, 0))


def _failures(expect: Expect, robots: Tuple[RobotReport, ...], run: FaultyRun) -> List[str]:
    failures = []
    for robot in robots:
        if not robot.arrived and (expect.arrived is None or robot.name in expect.arrived):
            why = run.gave_up.get(robot.name, "")
            failures.append(f"robot {robot.name} did not arrive" + (f": {why}" if why else ""))
        lateness = (robot.arrival_time or 0.0) - robot.scheduled_time
        if robot.arrived and expect.max_lateness is not None and lateness > expect.max_lateness:
            failures.append(f"robot {robot.name} was {lateness:.2f} s late, more than {expect.max_lateness:g} s")
        if expect.max_tracking_error is not None and robot.max_tracking_error > expect.max_tracking_error:
            failures.append(f"robot {robot.name} was {robot.max_tracking_error:.3f} m off its reference, more than "
                            f"{expect.max_tracking_error:g} m")
    contacts = [failure for failure in run.verdict.failures if " touch " in failure]
    if len(contacts) > expect.collisions:
        failures += contacts
    waits = [failure for failure in run.verdict.failures if failure.endswith("waits without end")]
    return failures + waits + list(run.verdict.exceeded)
