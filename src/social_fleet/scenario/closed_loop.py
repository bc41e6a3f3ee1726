"""The closed loop without ROS: trackers drive simulated robots and tell each other how far they are."""

import math
import time
from typing import Callable, Dict, List, Optional, Sequence, Tuple

from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.execution.config import TrackerConfig
from social_fleet.execution.gate import ReportedProgress
from social_fleet.execution.tracker import Tracker
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.lookout import Lookout
from social_fleet.scenario.recording import Recorder, Recording
from social_fleet.scenario.report import Report, judge
from social_fleet.scenario.scenario import Expect, Scenario
from social_fleet.simulation.config import SimulationConfig
from social_fleet.simulation.faults import CircleObstacle, Fault
from social_fleet.simulation.world import World

_UNKNOWN = (math.nan, math.nan)
_SETTLE = 1.0  # how long to watch the robots after the last arrival [s]


def simulate(fleet: FleetSchedule, grid: Optional[OccupancyGrid] = None, *,
             config: SimulationConfig = SimulationConfig(), tracker: TrackerConfig = TrackerConfig(),
             obstacles: Sequence[CircleObstacle] = (), faults: Sequence[Fault] = (),
             expect: Expect = Expect(), scenario: str = "",
             progress: Optional[Callable[[float], None]] = None) -> Tuple[Report, Recording]:
    """Drive a coordinated fleet until all have arrived or the deadline has passed.

    Parameters
    ----------
    fleet : FleetSchedule
        What the robots are to drive.
    grid : OccupancyGrid, optional
        The map; contacts with its walls are judged when it is given.
    config, tracker
        Parameters of the simulated robots and of their trackers.
    obstacles, faults
        What is in the way, and what goes wrong.
    expect : Expect
        What makes the run pass.
    scenario : str
        Name for the report.
    progress : callable, optional
        Called now and then with the arc length that all robots have driven, as a share of all paths.

    Returns
    -------
    Report, Recording
        The verdict, from true poses alone, and those poses.

    Raises
    ------
    InvalidScenario
        When two robots have one name, or a fault or an expectation names a robot that is not there.
    """
    began = time.perf_counter()
    run = ClosedLoop(fleet, grid, config=config, tracker=tracker, obstacles=obstacles, faults=faults)
    deadline = config.deadline_factor * fleet.makespan + config.deadline_extra
    deadline += sum(fault.duration for fault in faults)
    settled = 0.0
    while run.now < deadline and settled < _SETTLE:
        run.step()
        settled = settled + config.period if run.finished else 0.0
        if progress is not None and run.world.clock.tick % 50 == 0:
            progress(run.share)
    recording = run.recorder.recording()
    report = judge(recording, fleet, expect, grid=grid, obstacles=obstacles, scenario=scenario,
                   wall_time=time.perf_counter() - began)
    return report, recording


def simulate_scenario(scenario: Scenario, fleet: FleetSchedule, grid: OccupancyGrid, *,
                      config: SimulationConfig = SimulationConfig(), tracker: TrackerConfig = TrackerConfig(),
                      progress: Optional[Callable[[float], None]] = None) -> Tuple[Report, Recording]:
    """Drive `fleet`, the coordinated schedules of `scenario`, with the scenario's obstacles, faults and expectations.

    Parameters and results are those of `simulate`.
    """
    return simulate(fleet, grid, config=config, tracker=tracker, obstacles=scenario.obstacles, faults=scenario.faults,
                    expect=scenario.expect, scenario=scenario.name, progress=progress)


class ClosedLoop:
    """Trackers, simulated robots, and messages that take one period.

    Attributes
    ----------
    world : World
        The simulated robots.
    trackers : dict of str to Tracker
        By robot.
    recorder : Recorder
        Collects true poses and references from the first moment on.
    """

    def __init__(self, fleet: FleetSchedule, grid: Optional[OccupancyGrid] = None, *,
                 config: SimulationConfig = SimulationConfig(), tracker: TrackerConfig = TrackerConfig(),
                 obstacles: Sequence[CircleObstacle] = (), faults: Sequence[Fault] = ()) -> None:
        robots = [schedule.robot for schedule in fleet.schedules]
        self.world = World(robots, grid, obstacles=obstacles, faults=faults, config=config)
        self.trackers: Dict[str, Tracker] = {schedule.name: Tracker(schedule, tracker) for schedule in fleet.schedules}
        self._heard: Dict[str, ReportedProgress] = {}
        self._length = sum(robot.path.length for robot in robots)
        self._lookouts = {robot.name: Lookout(robot, obstacles) for robot in robots} if obstacles else {}
        self.recorder = Recorder([robot.name for robot in robots])
        self._record()

    @property
    def now(self) -> float:
        """Present time [s]."""
        return self.world.clock.now

    @property
    def finished(self) -> bool:
        """Whether every robot stands at its goal."""
        return all(tracker.arrived for tracker in self.trackers.values())

    @property
    def share(self) -> float:
        """Share of all paths that is driven."""
        driven = sum(tracker.progress for tracker in self.trackers.values())
        return driven / self._length if self._length > 0.0 else 1.0

    def step(self) -> None:
        """One control period: every tracker acts on what it heard before, then the world moves."""
        now = self.now
        heard: Dict[str, ReportedProgress] = {}
        for name, tracker in self.trackers.items():
            pose = self.world.localise(name)
            horizon = self._lookouts[name].horizon(now, tracker.progress) if self._lookouts else math.inf
            command = tracker.step(now, pose, self._heard, horizon=horizon)
            self.world.robots[name].command(command.speed, command.turn_rate)
            heard[name] = tracker.report(now)
        self._heard = heard
        self.world.step()
        self._record()

    def _record(self) -> None:
        references: List[Tuple[float, float]] = []
        for tracker in self.trackers.values():
            reference = tracker.reference
            references.append(_UNKNOWN if reference is None else (reference.x, reference.y))
        self.recorder.add(self.now, [robot.pose for robot in self.world.robots.values()], references)
