"""The node scenario_runner: a scenario through the nodes, from planning to the verdict."""

import math
import os
import time
from dataclasses import dataclass
from typing import Callable, Set

import rospy
from std_msgs.msg import Float64

from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.cli.simulate import summary
from social_fleet.errors import NotReady, SocialFleetError
from social_fleet.mapping.files import load_map
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.parameters import parameter
from social_fleet.ros import parameters
from social_fleet.ros.fleet_client import FleetClient
from social_fleet.ros.paths import resolve_path
from social_fleet.ros.run_recorder import RunRecorder
from social_fleet.scenario.files import load_scenario
from social_fleet.scenario.recording import Recording
from social_fleet.scenario.report import Report, judge, write_report
from social_fleet.simulation.config import SimulationConfig

_SETTLE = 1.0  # how long to watch the robots after the last arrival [s]
_LOOK = 0.05  # between two looks at how far things are [s, wall time]


@dataclass(frozen=True)
class ScenarioRunnerParameters:
    """Parameters of the node."""

    scenario: str = ""  # the scenario file
    map_file: str = ""  # the map that is published, where it is not the scenario's
    out: str = ""  # folder for report.json and pictures; empty: none are written
    pictures: bool = True  # fleet.png, space_time.png and fleet.gif
    map_frame: str = "map"
    planner: str = "social_planner/plan_path"
    coordinator: str = "fleet_coordinator/coordinate"
    simulator: str = "fake_robots"  # the node whose ~real_time_factor is set once the fleet may go
    real_time_factor: float = parameter(0.0, minimum=0.0)  # 0: as fast as trackers answer
    patience: float = parameter(60.0, above=0.0)  # for nodes to come up, and for a standing clock [s, wall time]


class ScenarioRunner:
    """Plans and coordinates a scenario's fleet, lets it go, waits for its arrival and judges it by its true poses.

    Subscribers
        fleet/ground_truth (geometry_msgs/PoseArray), fleet/progress (Progress).
    Publishers
        SIMULATOR/real_time_factor (std_msgs/Float64).
    Parameters
        `ScenarioRunnerParameters`.
    """

    def __init__(self) -> None:
        self._config = parameters.read_private(ScenarioRunnerParameters)
        self._scenario = load_scenario(resolve_path(self._config.scenario))
        self._out = resolve_path(self._config.out) if self._config.out else ""
        if self._out:
            os.makedirs(self._out, exist_ok=True)
        self._recorder = RunRecorder([robot.name for robot in self._scenario.robots])
        self._factor = rospy.Publisher(f"{self._config.simulator}/real_time_factor", Float64, latch=True, queue_size=1)

    def spin(self) -> int:
        """Run the scenario; 0 when it passed, 1 when not."""
        try:
            report = self.run()
        except SocialFleetError as error:
            rospy.logerr("the scenario %s failed: %s", self._scenario.name, error)
            return 1
        print("\n" + "\n".join(summary(report)), flush=True)
        return 0 if report.passed else 1

    def run(self) -> Report:
        """Plan, coordinate, drive, judge, and write what is wanted of it."""
        begun = time.monotonic()
        fleet = self._schedule()
        ready = time.monotonic()
        grid = load_map(resolve_path(self._config.map_file) if self._config.map_file else self._scenario.map_path)
        self._await_arrival(fleet)
        driven = time.monotonic()
        self._factor.publish(1.0)  # leave the processors to what follows
        recording = self._recorder.recording()
        report = judge(recording, fleet, self._scenario.expect, grid=grid, obstacles=self._scenario.obstacles,
                       scenario=self._scenario.name, wall_time=driven - ready)
        if self._out:
            write_report(report, os.path.join(self._out, "report.json"))
            if self._config.pictures:
                self._draw(grid, fleet, recording)
        rospy.loginfo("wall time: %.1f s until the fleet set off, %.1f s driving, %.1f s for report and pictures",
                      ready - begun, driven - ready, time.monotonic() - driven)
        return report

    def _schedule(self) -> FleetSchedule:
        """Plan, coordinate, and see every tracker take up its schedule."""
        config = self._config
        client = FleetClient(config.planner, config.coordinator, config.map_frame, config.patience)
        names = set(self._recorder.names)
        self._await("trackers that hear odometry", lambda: names - self._recorder.following(0))
        fleet, messages = client.coordinate(self._scenario, [client.plan(spec) for spec in self._scenario.robots])
        self._recorder.begin(messages[0].header.stamp)
        versions = {message.robot: message.version for message in messages}
        self._await("trackers that take up their schedules",
                    lambda: {name for name in names if name not in self._recorder.following(versions[name])})
        self._factor.publish(config.real_time_factor)
        rospy.loginfo("%d robots set off; the last is to arrive after %.1f s", len(fleet.schedules), fleet.makespan)
        return fleet

    def _await(self, what: str, missing: Callable[[], Set[str]]) -> None:
        """Wait until no robot is missing."""
        deadline = time.monotonic() + self._config.patience
        while missing():
            _check_running()
            if time.monotonic() > deadline:
                raise NotReady(f"waited {self._config.patience:g} s in vain for {what}: {', '.join(sorted(missing()))}")
            rospy.rostime.wallsleep(_LOOK)

    def _await_arrival(self, fleet: FleetSchedule) -> None:
        """Wait until all have arrived and stand, simulated time has run out, or it stands still."""
        recorder, patience = self._recorder, self._config.patience
        deadline = SimulationConfig.deadline_factor * fleet.makespan + SimulationConfig.deadline_extra
        deadline += sum(fault.duration for fault in self._scenario.faults)
        told: Set[str] = set()
        finished, moved = math.inf, (recorder.now, time.monotonic())
        while recorder.now < min(deadline, finished + _SETTLE):
            _check_running()
            for name in sorted(recorder.arrived - told):
                rospy.loginfo("%s arrived after %.1f s; scheduled %.1f s", name, recorder.now, fleet[name].arrival_time)
            told |= recorder.arrived
            if len(told) == len(fleet.schedules):
                finished = min(finished, recorder.now)
            if recorder.now > moved[0]:
                moved = (recorder.now, time.monotonic())
            elif time.monotonic() - moved[1] > patience:
                raise NotReady(f"simulated time has stood still for {patience:g} s")
            rospy.rostime.wallsleep(_LOOK)

    def _draw(self, grid: OccupancyGrid, fleet: FleetSchedule, recording: Recording) -> None:
        """Imported only here: the drawing libraries take their time."""
        from social_fleet.scenario.pictures.animation import animate
        from social_fleet.scenario.pictures.map_picture import map_picture
        from social_fleet.scenario.pictures.space_time import space_time_picture
        title = self._scenario.name.replace("_", " ")
        map_picture(grid, fleet, os.path.join(self._out, "fleet.png"), title=title, recording=recording)
        space_time_picture(fleet, os.path.join(self._out, "space_time.png"), title=title, recording=recording)
        animate(grid, fleet, os.path.join(self._out, "fleet.gif"), recording=recording,
                obstacles=self._scenario.obstacles, title=title)


def _check_running() -> None:
    if rospy.is_shutdown():
        raise NotReady("the run was ended from outside")
