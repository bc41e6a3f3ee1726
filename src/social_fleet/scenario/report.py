"""The report of a run: who arrived when, how close they came, and whether that is what was expected."""

from dataclasses import asdict, dataclass
from itertools import combinations
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.errors import InvalidScenario
from social_fleet.files import PathLike, write_json
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario import judge as judging
from social_fleet.scenario.judge import Contact
from social_fleet.scenario.recording import Recorder, Recording
from social_fleet.scenario.scenario import Expect
from social_fleet.simulation.faults import CircleObstacle

__all__ = ["Recorder", "Recording", "Report", "RobotReport", "judge", "write_report"]

POSITION_TOLERANCE = 0.05  # of an arrival [m]
HEADING_TOLERANCE = 0.1  # [rad]


@dataclass(frozen=True)
class RobotReport:
    """How one robot did."""

    name: str
    arrived: bool
    arrival_time: Optional[float]  # [s]; None when it did not
    scheduled_time: float  # [s]
    path_length: float  # [m]
    max_tracking_error: float  # [m]
    tracking_error_95: float  # 95th percentile while under way [m]
    replans: int = 0


@dataclass(frozen=True)
class Report:
    """How a fleet did; the fields are those of report.json.

    Attributes
    ----------
    passed : bool
        Whether the expectations were met.
    failures : tuple of str
        Why not, as sentences.
    makespan, sum_of_completion : float, optional
        Last arrival and sum of all [s]; None when a robot did not arrive.
    collisions : tuple of Contact
        Of robots with each other, with walls and with obstacles.
    min_clearance : float, optional
        Smallest distance of two robots' surfaces over all pairs and times [m]; None for fewer than two robots.
    min_wall_clearance : float, optional
        Smallest distance of a robot's surface to a wall [m], told up to 0.5 m; None without a map.
    robots : tuple of RobotReport
        One by one.
    wall_time, simulated_time : float
        How long the run took, and how long it was [s].
    """

    scenario: str
    passed: bool
    failures: Tuple[str, ...]
    makespan: Optional[float]
    sum_of_completion: Optional[float]
    collisions: Tuple[Contact, ...]
    min_clearance: Optional[float]
    min_wall_clearance: Optional[float]
    robots: Tuple[RobotReport, ...]
    wall_time: float
    simulated_time: float

    def to_dict(self) -> Dict[str, Any]:
        """As report.json has it."""
        values = asdict(self)
        values["collisions"] = [contact._asdict() for contact in self.collisions]
        return values


def write_report(report: Report, path: PathLike) -> None:
    """Write report.json, whole or not at all.

    Raises
    ------
    InvalidInput
        When the file cannot be created.
    """
    write_json(path, report.to_dict())


def judge(recording: Recording, fleet: FleetSchedule, expect: Expect = Expect(), *,
          grid: Optional[OccupancyGrid] = None, obstacles: Sequence[CircleObstacle] = (), scenario: str = "",
          wall_time: float = 0.0, replans: Optional[Mapping[str, int]] = None,
          position_tolerance: float = POSITION_TOLERANCE, heading_tolerance: float = HEADING_TOLERANCE) -> Report:
    """Judge a run by the true poses alone.

    Parameters
    ----------
    recording : Recording
        True poses; between samples robots are taken to move straight and evenly.
    fleet : FleetSchedule
        Paths, radii, goals and scheduled times.
    expect : Expect
        What makes the run pass.
    grid, obstacles
        What robots must not touch besides each other.
    scenario, wall_time, replans
        For the report: a name; how long the run took [s]; replans by robot.
    position_tolerance, heading_tolerance : float
        Of an arrival [m, rad].

    Raises
    ------
    InvalidScenario
        When the recording lacks a robot of the fleet, or `expect` names a robot that is not in it.
    """
    names = [schedule.name for schedule in fleet.schedules]
    missing = sorted(set(names) - set(recording.names))
    if missing:
        raise InvalidScenario(f"the recording lacks robot {missing[0]}", field="robots")
    strangers = sorted(set(expect.arrived or ()) - set(names))
    if strangers:
        raise InvalidScenario(f"there is no robot {strangers[0]}; known are {', '.join(names)}", field="expect.arrived")
    robots = tuple(_robot_report(recording, fleet, name, (replans or {}).get(name, 0), position_tolerance,
                                 heading_tolerance) for name in names)
    found, min_clearance = _robot_contacts(recording, fleet)
    wall_contacts, min_wall_clearance = _wall_contacts(recording, fleet, grid)
    found += wall_contacts + _obstacle_contacts(recording, fleet, obstacles)
    found.sort(key=lambda contact: (contact.time, contact.robots))
    failures = _failures(robots, found, expect)
    times = [robot.arrival_time for robot in robots if robot.arrival_time is not None]
    complete = len(times) == len(robots)
    return Report(scenario, not failures, tuple(failures), max(times, default=0.0) if complete else None,
                  sum(times) if complete else None, tuple(found), min_clearance, min_wall_clearance, robots, wall_time,
                  recording.duration)


def _failures(robots: Sequence[RobotReport], found: Sequence[Contact], expect: Expect) -> List[str]:
    """What went against the expectations, as sentences."""
    failures = []
    for robot in robots:
        if expect.arrived is None or robot.name in expect.arrived:
            lateness = (robot.arrival_time or 0.0) - robot.scheduled_time
            if not robot.arrived:
                failures.append(f"robot {robot.name} did not arrive")
            elif expect.max_lateness is not None and abs(lateness) > expect.max_lateness:
                word = "late" if lateness > 0.0 else "early"
                failures.append(f"robot {robot.name} was {abs(lateness):.2f} s {word}, more than "
                                f"{expect.max_lateness:g} s")
        if expect.max_tracking_error is not None and robot.max_tracking_error > expect.max_tracking_error:
            failures.append(f"robot {robot.name} was {robot.max_tracking_error:.3f} m off its reference, more than "
                            f"{expect.max_tracking_error:g} m")
    if len(found) > expect.collisions:
        failures += [_sentence(contact) for contact in found]
    return failures


def _robot_report(recording: Recording, fleet: FleetSchedule, name: str, replans: int, position_tolerance: float,
                  heading_tolerance: float) -> RobotReport:
    schedule = fleet[name]
    robot = schedule.robot
    arrival = judging.arrival_time(recording, robot, position_tolerance=position_tolerance,
                                   heading_tolerance=heading_tolerance)
    errors = judging.tracking_error(recording, robot)
    under_way = errors[recording.times <= (recording.times[-1] if arrival is None else arrival)]
    return RobotReport(name, arrival is not None, arrival, schedule.arrival_time, robot.path.length,
                       float(errors.max()), float(np.percentile(under_way, 95)), replans)


def _robot_contacts(recording: Recording, fleet: FleetSchedule) -> Tuple[List[Contact], Optional[float]]:
    found: List[Contact] = []
    smallest: Optional[float] = None
    for first, second in combinations((schedule.robot for schedule in fleet.schedules), 2):
        gaps = judging.pair_clearance(recording, recording.index(first.name), recording.index(second.name),
                                      first.body_radius + second.body_radius)
        smallest = float(gaps.min()) if smallest is None else min(smallest, float(gaps.min()))
        found += judging.contacts(recording, gaps, "robots", (first.name, second.name))
    return found, smallest


def _wall_contacts(recording: Recording, fleet: FleetSchedule,
                   grid: Optional[OccupancyGrid]) -> Tuple[List[Contact], Optional[float]]:
    found: List[Contact] = []
    smallest: Optional[float] = None
    if grid is not None:
        for robot in (schedule.robot for schedule in fleet.schedules):
            gaps = judging.wall_clearance(recording, recording.index(robot.name), robot.body_radius, grid)
            smallest = float(gaps.min()) if smallest is None else min(smallest, float(gaps.min()))
            found += judging.contacts(recording, gaps, "wall", (robot.name,))
    return found, smallest


def _obstacle_contacts(recording: Recording, fleet: FleetSchedule,
                       obstacles: Sequence[CircleObstacle]) -> List[Contact]:
    found: List[Contact] = []
    for obstacle in obstacles:
        for robot in (schedule.robot for schedule in fleet.schedules):
            gaps = judging.obstacle_clearance(recording, recording.index(robot.name), robot.body_radius, obstacle)
            found += judging.contacts(recording, gaps, "obstacle", (robot.name,))
    return found


def _sentence(contact: Contact) -> str:
    whom = {"robots": f"robots {' and '.join(contact.robots)} touched",
            "wall": f"robot {contact.robots[0]} touched a wall",
            "obstacle": f"robot {contact.robots[0]} touched an obstacle"}[contact.kind]
    x, y = contact.position
    return f"{whom} at {contact.time:.2f} s near ({x:.2f}, {y:.2f}), {-contact.clearance:.3f} m deep"
