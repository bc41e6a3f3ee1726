"""The closed loop with everything that can go wrong: robots, dispatcher, and a network between them."""

import math
from dataclasses import replace
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np

from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.execution.config import TrackerConfig
from social_fleet.execution.recovery.config import RecoveryConfig
from social_fleet.execution.recovery.dispatcher import Dispatcher
from social_fleet.execution.recovery.messages import Assignment, Body, Directive, Errand, Report
from social_fleet.execution.recovery.replanning import Options, Replanning
from social_fleet.execution.tracker import Tracker
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.agent import Agent
from social_fleet.scenario.fleet import FleetPlanner
from social_fleet.scenario.recording import Recorder
from social_fleet.scenario.scenario import Scenario
from social_fleet.simulation.faults import DISPATCHER, Fault
from social_fleet.simulation.network import Network
from social_fleet.simulation.world import World

_THINKING = 0.5  # what a plan of the fleet takes, in simulated time [s]
_DISPATCH = 0.1  # period of the dispatcher [s]


class FleetRun:
    """Agents drive simulated robots, a dispatcher keeps them supplied, and messages get lost.

    Parameters
    ----------
    scenario : Scenario
        Robots, obstacles, faults, network.
    fleet : FleetSchedule
        What the robots set out with; those that join later have none.
    grid : OccupancyGrid
        The map.
    planners : FleetPlanner
        Plan anew.
    tracker, recovery
        Parameters.

    Attributes
    ----------
    world : World
        The simulated robots.
    agents : dict of str to Agent
        The programs of the robots, those that run.
    dispatcher : Dispatcher, optional
        None while it is down.
    recorder : Recorder
        True poses and references from the first moment on.
    commands : list of (R, 2) arrays
        Speed [m/s] and turn rate [rad/s] that every robot was commanded, per period.
    """

    def __init__(self, scenario: Scenario, fleet: FleetSchedule, grid: OccupancyGrid, planners: FleetPlanner, *,
                 tracker: TrackerConfig = TrackerConfig(), recovery: RecoveryConfig = RecoveryConfig()) -> None:
        config = scenario.simulation_config
        self.scenario = scenario
        self.recovery = recovery
        self._tracker = tracker
        self.world = World([schedule.robot for schedule in fleet.schedules], grid, obstacles=scenario.obstacles,
                           faults=scenario.faults, config=config)
        self._network = Network(scenario.network)
        self._replanning = Replanning(planners.for_radius, Options(
            time_margin=scenario.coordination.time_margin,
            tracking_tolerance=scenario.coordination.tracking_tolerance))
        self._bodies = {schedule.name: Body(schedule.robot.body_radius, schedule.robot.limits, schedule.robot.weight)
                        for schedule in fleet.schedules}
        self.names = tuple(schedule.name for schedule in fleet.schedules)
        self.errands: Dict[str, Errand] = {spec.name: Errand(1, tuple(spec.goal)) for spec in scenario.robots}
        self.agents: Dict[str, Agent] = {}
        self._sessions = {name: 0 for name in self.names}
        self.dispatcher: Optional[Dispatcher] = Dispatcher(self._replanning, recovery)
        self.decisions: List[str] = []
        self.replans: Dict[str, int] = {}
        self._counted: Tuple[Optional[Dispatcher], int, Dict[str, int]] = (None, 0, {})
        self._outbox: List[Tuple[float, Directive]] = []
        self._dispatched = -math.inf
        self._pending = sorted((fault for fault in scenario.faults if fault.kind == "errand"),
                               key=lambda fault: fault.at)
        self._joins = {fault.robot: fault.at for fault in scenario.faults if fault.kind == "join"}
        self.recorder = Recorder(self.names)
        self.commands: List[np.ndarray] = []
        self._start(fleet)
        self._record()

    @property
    def now(self) -> float:
        """Present time [s]."""
        return self.world.clock.now

    @property
    def settled(self) -> bool:
        """Whether nothing more is to be expected of any robot: it stands at its goal, has given up, or is dead."""
        return not self._pending and all(
            self.world.befalls(name, "dead") or (name in self.agents and self.agents[name].settled)
            for name in self.names)

    @property
    def gave_up(self) -> Dict[str, str]:
        """Robots whose present errand was given up, and why."""
        return {name: agent.given_up for name, agent in self.agents.items() if agent.given_up}

    def step(self) -> None:
        """One control period."""
        now = self.now
        self._change(now)
        self._deliver(now)
        if self.dispatcher is not None and now - self._dispatched >= _DISPATCH - 1e-9:
            self._dispatch(now)
        discs = self._discs()
        commands = np.full((len(self.names), 2), np.nan)
        for index, name in enumerate(self.names):
            agent = self.agents.get(name)
            if agent is None:
                continue
            command = agent.step(now, self.world.localise(name), self.world.robots[name].pose, discs, index)
            self.world.robots[name].command(command.speed, command.turn_rate)
            commands[index] = command
            report = agent.news(now)
            if report is not None and not self.world.befalls(name, "silent"):
                self._network.send(now, [other for other in self.names if other != name] + [DISPATCHER], report)
        self.world.step()
        self.commands.append(commands)
        self._record()

    def _start(self, fleet: FleetSchedule) -> None:
        """All robots have their first schedules; those that join later are not there yet."""
        joining = self._joins
        for name in self.names:
            if name in joining:
                continue
            agent = self._agent(name)
            peers = tuple(other for other in self.names if other not in joining and other != name)
            schedule = replace(fleet[name], peers=peers)
            agent.member.tracker.follow(schedule)
            agent.member.assignment = Assignment(0, schedule, errand=1)
            agent.member.greet(0.0)

    def _agent(self, name: str) -> Agent:
        agent = Agent(name, self._bodies[name], Tracker(config=self._tracker), self._sessions[name], self.recovery,
                      self.world.grid)
        agent.member.errand = self.errands[name]
        self.agents[name] = agent
        return agent

    def _change(self, now: float) -> None:
        """Programs that end or start, and errands that come."""
        for name in self.names:
            down = self.world.befalls(name, "restart", "dead") or self._joins_later(name, now)
            if down and name in self.agents:
                del self.agents[name]
                self._sessions[name] += 1
            elif not down and name not in self.agents:
                self._agent(name)
        if self.world.befalls(DISPATCHER, "restart"):
            self.dispatcher = None
            self._outbox.clear()
        elif self.dispatcher is None:
            self.dispatcher = Dispatcher(self._replanning, self.recovery)
        while self._pending and self._pending[0].at <= now:
            fault = self._pending.pop(0)
            self.errands[fault.robot] = Errand(self.errands[fault.robot].number + 1, tuple(fault.goal))
            if fault.robot in self.agents:
                self.agents[fault.robot].member.errand = self.errands[fault.robot]

    def _joins_later(self, name: str, now: float) -> bool:
        return name in self._joins and now < self._joins[name]

    def _deliver(self, now: float) -> None:
        for receiver, message in self._network.arrived(now):
            if receiver == DISPATCHER:
                if self.dispatcher is not None and not self.world.befalls(DISPATCHER, "silent"):
                    self.dispatcher.hear(message)
            elif receiver in self.agents and not self.world.befalls(receiver, "silent"):
                if isinstance(message, Report):
                    self.agents[receiver].hear_report(message)
                else:
                    self.agents[receiver].hear(message)
                    for report in self.agents[receiver].member.remembered(message):
                        self._network.send(now, [DISPATCHER], report)

    def _dispatch(self, now: float) -> None:
        assert self.dispatcher is not None
        self._dispatched = now
        planned = len(self.dispatcher.assignments)
        directive = self.dispatcher.step(now)
        self._count()
        if directive is not None:
            thought = _THINKING if len(directive.assignments) > planned else 0.0
            self._outbox.append((max([now + thought, *(due for due, _ in self._outbox)]), directive))
        while self._outbox and self._outbox[0][0] <= now:
            if not self.world.befalls(DISPATCHER, "silent"):
                self._network.send(now, self.names, self._outbox[0][1])
            self._outbox.pop(0)

    def _count(self) -> None:
        """Keep what dispatchers decided beyond their lives."""
        dispatcher = self.dispatcher
        assert dispatcher is not None
        known, count, replans = self._counted
        if known is not dispatcher:
            count, replans = 0, {}
        self.decisions += [f"{self.now:.1f} s: {decision}" for decision in dispatcher.decisions[count:]]
        for name, number in dispatcher.replans.items():
            self.replans[name] = self.replans.get(name, 0) + number - replans.get(name, 0)
        self._counted = dispatcher, len(dispatcher.decisions), dict(dispatcher.replans)

    def _discs(self) -> np.ndarray:
        """True discs of all robots, then of present obstacles, (D, 3) [m]."""
        discs = [(robot.pose.x, robot.pose.y, robot.radius) for robot in self.world.robots.values()]
        discs += [(obstacle.x, obstacle.y, obstacle.radius) for obstacle in self.world.present_obstacles()]
        return np.array(discs, dtype=float).reshape(-1, 3)

    def _record(self) -> None:
        references: List[Tuple[float, float]] = []
        for name in self.names:
            agent = self.agents.get(name)
            reference = None if agent is None else agent.member.tracker.reference
            references.append((np.nan, np.nan) if reference is None else (reference.x, reference.y))
        self.recorder.add(self.now, [robot.pose for robot in self.world.robots.values()], references)


def drive(run: FleetRun, *, deadline: float, settle: float = 1.0,
          progress: Optional[Callable[[float], None]] = None) -> None:
    """Let a run go on until all is settled, or until `deadline` [s]; `progress` is told the time now and then."""
    settled = 0.0
    while run.now < deadline and settled < settle:
        run.step()
        settled = settled + run.world.clock.period if run.settled else 0.0
        if progress is not None and run.world.clock.tick % 100 == 0:
            progress(run.now)


def longest_fault(faults: Sequence[Fault]) -> float:
    """When the last fault that ends is over [s]."""
    return max((fault.at + (fault.duration if math.isfinite(fault.duration) else 0.0) for fault in faults),
               default=0.0)
