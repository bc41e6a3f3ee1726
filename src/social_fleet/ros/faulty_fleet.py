"""The node faulty_fleet: a scenario with faults through the nodes, from the first goal to the verdict."""

import math
import os
import time
from dataclasses import dataclass, field
from typing import Any, Callable, Dict, List, Optional, Set

import actionlib
import genpy
import numpy as np
import rospy
from geometry_msgs.msg import PoseArray
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from std_msgs.msg import Float64

from social_fleet.errors import NotReady, SocialFleetError
from social_fleet.files import write_json
from social_fleet.geometry import Pose
from social_fleet.mapping.files import load_map
from social_fleet.msg import NavigationStatus, RobotReport, Schedule
from social_fleet.parameters import parameter
from social_fleet.ros import conversions, parameters
from social_fleet.ros.paths import resolve_path
from social_fleet.ros.robot_programs import RobotPrograms, body_parameters
from social_fleet.scenario.files import load_scenario
from social_fleet.scenario.recording import Recording
from social_fleet.scenario.verdict import Verdict, judge_faulty_run
from social_fleet.simulation.faults import DISPATCHER, Fault

_LOOK = 0.05  # between two looks at what is due [s, wall time]
_SETTLE = 1.0  # how long all must have come to an end [s]
_TRACKER, _NAVIGATOR, _COORDINATOR = "trajectory_tracker", "navigator", "fleet_coordinator"


@dataclass(frozen=True)
class FaultyFleetParameters:
    """Parameters of the node; `tracker` and `navigator` beside them are mappings of parameters for all of these."""

    scenario: str = ""  # the scenario file
    out: str = ""  # folder for run.json and recording.npz; empty: none are written
    map_frame: str = "map"
    simulator: str = "fake_robots"  # the node whose ~real_time_factor is set once the fleet may go
    real_time_factor: float = parameter(3.0, above=0.0)
    deadline: float = parameter(600.0, above=0.0)  # then a wait is one without end [s]
    patience: float = parameter(90.0, above=0.0)  # for programs to come up, and for a standing clock [s, wall time]


@dataclass
class _Heard:
    """What has come in."""

    truth: List[PoseArray] = field(default_factory=list)
    states: Dict[str, NavigationStatus] = field(default_factory=dict)
    reports: Dict[str, RobotReport] = field(default_factory=dict)
    time_zero: Optional[genpy.Time] = None
    now: float = -math.inf  # of the latest true poses, on the clock of faults [s]


class FaultyFleet:
    """Starts the robots' programs and the coordinator, sends goals, and ends and starts programs as the faults say.

    What befalls the robots' bodies and their localisation is the simulator's part. A robot that is ``silent`` has its
    tracker stopped for that time: there is no other way to cut it off.

    Subscribers
        fleet/ground_truth (geometry_msgs/PoseArray), fleet/navigation (NavigationStatus), fleet/schedules (Schedule),
        fleet/reports (RobotReport).
    Publishers
        SIMULATOR/real_time_factor (std_msgs/Float64).
    Parameters
        `FaultyFleetParameters`.
    """

    def __init__(self) -> None:
        self._config, others = parameters.split_private(FaultyFleetParameters)
        self._given = {_TRACKER: others.pop("tracker", {}), _NAVIGATOR: others.pop("navigator", {})}
        self._scenario = load_scenario(resolve_path(self._config.scenario))
        self.names = [spec.name for spec in self._scenario.robots]
        self._bodies = {spec.name: body_parameters(spec) for spec in self._scenario.robots}
        self._goals = {spec.name: spec.goal for spec in self._scenario.robots}
        self._programs = RobotPrograms()
        self._clients: Dict[str, actionlib.SimpleActionClient] = {}
        self._sent: Dict[str, float] = {}  # when a robot's last goal was sent [s]
        self._former: Dict[str, int] = {}  # number of the goal that a robot had then
        self._pending = sorted((fault for fault in self._scenario.faults if fault.kind == "errand"),
                               key=lambda fault: fault.at)
        self._silent: Set[str] = set()
        self._heard = _Heard()
        self._factor = rospy.Publisher(f"{self._config.simulator}/real_time_factor", Float64, latch=True, queue_size=1)
        rospy.Subscriber("fleet/ground_truth", PoseArray, self._hear_truth, queue_size=1000, tcp_nodelay=True)
        rospy.Subscriber("fleet/schedules", Schedule, self._hear_schedule, queue_size=100)
        rospy.Subscriber("fleet/navigation", NavigationStatus, self._hear_state, queue_size=100)
        rospy.Subscriber("fleet/reports", RobotReport, self._hear_report, queue_size=100)

    def _hear_truth(self, message: PoseArray) -> None:
        if self._heard.time_zero is not None:
            self._heard.truth.append(message)
            self._heard.now = (message.header.stamp - self._heard.time_zero).to_sec()

    def _hear_schedule(self, message: Schedule) -> None:
        """Faults count from the first schedule's time zero, as the simulator has it."""
        if self._heard.time_zero is None:
            self._heard.time_zero = message.header.stamp

    def _hear_state(self, message: NavigationStatus) -> None:
        self._heard.states[message.robot] = message

    def _hear_report(self, message: RobotReport) -> None:
        self._heard.reports[message.robot] = message

    def spin(self) -> int:
        """Run the scenario; 0 when it passed, 1 when not."""
        try:
            verdict = self.run()
        except SocialFleetError as error:
            rospy.logerr("the scenario %s failed: %s", self._scenario.name, error)
            return 1
        for failure in verdict.failures:
            rospy.logerr("%s", failure)
        rospy.loginfo("%s: %d arrived, %d excused, %d stranded, %d contacts, smallest clearance %s m",
                      "passed" if verdict.passed else "FAILED", len(verdict.arrived), len(verdict.excused),
                      len(verdict.stranded), len(verdict.contacts), verdict.min_clearance)
        return 0 if verdict.passed else 1

    def run(self) -> Verdict:
        """Start, drive, judge, and write what is wanted of it."""
        self._programs.start("", _COORDINATOR, {})
        joining = {fault.robot for fault in self._scenario.faults if fault.kind == "join"}
        for name in self.names:
            if name not in joining:
                self._start(name)
        present = set(self.names) - joining
        self._await("trackers", lambda: present - set(self._heard.reports))
        begun = time.monotonic()
        self._factor.publish(self._config.real_time_factor)
        for name in sorted(present):
            self._send(name)
        self._await("a first schedule", lambda: set() if self._heard.time_zero is not None else {"all"})
        self._drive()
        verdict, recording = self._judged()
        if self._config.out:
            os.makedirs(resolve_path(self._config.out), exist_ok=True)
            out = resolve_path(self._config.out)
            write_json(os.path.join(out, "run.json"), {**verdict.to_dict(), "gave_up": self._gave_up(),
                                                       "wall_time": time.monotonic() - begun})
            np.savez_compressed(os.path.join(out, "recording.npz"), times=recording.times, poses=recording.poses)
        return verdict

    def _start(self, name: str) -> None:
        self._programs.start(name, _TRACKER, {**self._given[_TRACKER], **self._bodies[name]})
        self._programs.start(name, _NAVIGATOR, self._given[_NAVIGATOR])
        self._clients[name] = actionlib.SimpleActionClient(f"{name}/move_base", MoveBaseAction)

    def _send(self, name: str) -> None:
        """Send a robot to its present goal, once its navigator is up."""
        self._await(f"the navigator of {name}", lambda: set() if self._clients[name].wait_for_server(
            rospy.Duration.from_sec(0.05)) else {name})
        self._former[name] = self._heard.states[name].number if name in self._heard.states else 0
        self._sent[name] = self._heard.now
        x, y, yaw = (*self._goals[name], 0.0)[:3]
        self._clients[name].send_goal(MoveBaseGoal(conversions.pose_to_stamped(Pose(x, y, yaw),
                                                                               self._config.map_frame)))

    def _drive(self) -> None:
        """Let happen what is due until all robots have come to an end."""
        settled, moved = math.inf, (self._heard.now, time.monotonic())
        while self._heard.now < self._config.deadline and self._heard.now - settled < _SETTLE:
            if rospy.is_shutdown():
                raise NotReady("the run was ended from outside")
            self._befall(self._heard.now)
            settled = min(settled, self._heard.now) if self._is_settled() else math.inf
            if self._heard.now > moved[0]:
                moved = (self._heard.now, time.monotonic())
            elif time.monotonic() - moved[1] > self._config.patience:
                raise NotReady(f"simulated time has stood still for {self._config.patience:g} s")
            rospy.rostime.wallsleep(_LOOK)
        self._factor.publish(1.0)

    def _befall(self, now: float) -> None:
        """Programs that end, stop, go on or start, and goals that change."""
        for name in self.names:
            faults = [fault for fault in self._scenario.faults if fault.robot == name]
            self._end_or_start(name, faults, now)
            silent = any(fault.kind == "silent" and fault.active(now) for fault in faults)
            if silent != (name in self._silent):
                self._silent ^= {name}
                self._programs.pause(name, _TRACKER, silent)
        self._befall_coordinator(now)
        while self._pending and self._pending[0].at <= now:
            fault = self._pending.pop(0)
            self._goals[fault.robot] = fault.goal
            if fault.robot in self._clients:
                self._send(fault.robot)

    def _end_or_start(self, name: str, faults: List[Fault], now: float) -> None:
        dead = any(fault.kind == "dead" and fault.active(now) for fault in faults)
        down = dead or any(fault.kind == "restart" and fault.active(now) for fault in faults)
        joins = any(fault.kind == "join" and now < fault.at for fault in faults)
        if dead and self._programs.runs(name, _NAVIGATOR):
            self._programs.kill(name, _NAVIGATOR)
        if down and self._programs.runs(name, _TRACKER):
            self._programs.kill(name, _TRACKER)
        elif not down and not joins and name not in self._clients:
            self._start(name)
            self._send(name)
        elif not down and not joins and not self._programs.runs(name, _TRACKER):
            self._programs.again(name, _TRACKER)

    def _befall_coordinator(self, now: float) -> None:
        faults = [fault for fault in self._scenario.faults if fault.robot == DISPATCHER]
        down = any(fault.kind == "restart" and fault.active(now) for fault in faults)
        silent = any(fault.kind == "silent" and fault.active(now) for fault in faults)
        if down and self._programs.runs("", _COORDINATOR):
            self._programs.kill("", _COORDINATOR)
        elif not down and not self._programs.runs("", _COORDINATOR):
            self._programs.again("", _COORDINATOR)
        if silent != (DISPATCHER in self._silent):
            self._silent ^= {DISPATCHER}
            self._programs.pause("", _COORDINATOR, silent)

    def _is_dead(self, name: str) -> bool:
        return any(fault.robot == name and fault.kind == "dead" and fault.active(self._heard.now)
                   for fault in self._scenario.faults)

    def _is_settled(self) -> bool:
        """Whether nothing more is to be expected of any robot."""
        return not self._pending and all(self._is_dead(name) or self._has_ended(name) for name in self.names)

    def _has_ended(self, name: str) -> bool:
        state = self._heard.states.get(name)
        return (name in self._sent and state is not None and state.number > self._former[name]
                and state.state in (NavigationStatus.SUCCEEDED, NavigationStatus.ABORTED))

    def _gave_up(self) -> Dict[str, str]:
        return {name: state.reason for name, state in self._heard.states.items()
                if name in self._sent and state.number > self._former[name]
                and state.state == NavigationStatus.ABORTED}

    def _judged(self) -> Any:
        """The verdict by true poses, and those."""
        messages = list(self._heard.truth)
        zero = self._heard.time_zero
        times = np.array([(message.header.stamp - zero).to_sec() for message in messages])
        poses = np.array([[conversions.pose_from_message(pose) for pose in message.poses] for message in messages])
        keep = (times >= 0.0) & np.append(True, np.diff(times) > 0.0)
        recording = Recording(tuple(self.names), times[keep], poses[keep])
        unknown = np.full((int(keep.sum()), len(self.names), 2), np.nan)
        grid = load_map(self._scenario.map_path)
        return judge_faulty_run(self._scenario, recording, unknown, grid, self._gave_up()), recording

    def _await(self, what: str, missing: Callable[[], Set[str]]) -> None:
        """Wait until nothing is missing."""
        deadline = time.monotonic() + self._config.patience
        while missing():
            if rospy.is_shutdown():
                raise NotReady("the run was ended from outside")
            if time.monotonic() > deadline:
                raise NotReady(f"waited {self._config.patience:g} s in vain for {what}: {', '.join(sorted(missing()))}")
            rospy.rostime.wallsleep(_LOOK)
