"""A robot's part in the exchange of schedules: it promises, holds to it, and takes up what was made from it.

doc/execution.md has the protocol and why it is safe whatever is lost, late or restarted.
"""

import math
from typing import Dict, List, Mapping, Optional, Tuple

from social_fleet.execution.course import distance
from social_fleet.execution.gate import ReportedProgress
from social_fleet.execution.recovery.config import RecoveryConfig
from social_fleet.execution.recovery.messages import Assignment, Body, Directive, Errand, Report
from social_fleet.execution.state import STANDSTILL, Command
from social_fleet.execution.tracker import Tracker
from social_fleet.geometry import Pose
from social_fleet.planning.overlays.shapes import DiscObstacle

_WAITS = "it stands off its path and waits for another"
_AWAY = 0.3  # so far from where it was held up it is so no longer [m]
_FREE_AGAIN = 3.0  # nor after nothing has been in its way for so long [s]
_AT_OBSTACLE = 0.15  # a robot that stands so close before what its lidar bounds is held up by it [m]


class Member:
    """One robot of a fleet: its tracker, what it has promised, and what it has heard.

    Parameters
    ----------
    name, body
        Who it is.
    tracker : Tracker
        Drives it.
    session : int
        Greater than any that a robot of this name has had: the time of its start will do.
    config : RecoveryConfig
        Times.

    Attributes
    ----------
    errand : Errand, optional
        What the robot is to do; set it at any time, with a greater number for something new.
    obstacles, cleared
        See `Report`; kept by whoever looks at the lidar.
    assignment : Assignment, optional
        What it follows.
    exchange : int
        The latest that it has given a promise for.
    others : dict of str to Report
        The latest of every other robot.
    bound : float
        The arc length that it does not pass for what it has promised [m].
    """

    def __init__(self, name: str, body: Body, tracker: Tracker, *, session: int,
                 config: RecoveryConfig = RecoveryConfig()) -> None:
        self.name = name
        self.body = body
        self.tracker = tracker
        self.config = config
        self.session = session
        self.errand: Optional[Errand] = None
        self.assignment: Optional[Assignment] = None
        self.obstacles: Mapping[str, DiscObstacle] = {}
        self.cleared: Tuple[str, ...] = ()
        self.bound = math.inf
        self.lapsed = False
        self.exchange = 0
        self._standing = False  # it has promised not to move at all
        self._asked = 0
        self._acknowledged = -math.inf
        self.others: Dict[str, Report] = {}
        self._heard: Dict[str, ReportedProgress] = {}
        self._pose: Optional[Pose] = None
        self._astray_since = math.inf
        self._blocked_since = math.inf
        self._blocked_last = -math.inf
        self._blocked_at = Pose(0.0, 0.0)
        self._now = -math.inf

    def greet(self, now: float) -> None:
        """Count the dispatcher as heard of at `now` [s]: for a robot that was given its schedule by other means."""
        self._acknowledged = max(self._acknowledged, now)

    def hear(self, directive: Directive) -> Optional[Assignment]:
        """Take in what the dispatcher says; the assignment that is taken up with it, if any."""
        self._acknowledged = max(self._acknowledged, directive.heard.get(self.name, -math.inf))
        self._asked = max(self._asked, directive.exchange)
        given = directive.assignments.get(self.name)
        if (given is None or given.session != self.session or given.schedule.version != self.exchange
                or given.schedule.version <= self.version):
            return None
        if self.tracker.schedule is None or self.astray:
            self.tracker.follow(given.schedule)
        else:
            self.tracker.follow(given.schedule, origin=given.origin)
        self.assignment = given
        self.bound, self.lapsed, self._standing = math.inf, False, False
        self._astray_since = math.inf
        return given

    def remembered(self, directive: Directive) -> List[Report]:
        """Reports to pass on: the latest of robots that the dispatcher misses."""
        return [self.others[name] for name in directive.missing if name in self.others]

    def hear_report(self, report: Report) -> None:
        """Take in what another robot says; older news than known is passed over."""
        known = self.others.get(report.name)
        if report.name == self.name or (known is not None and report.age <= known.age):
            return
        self.others[report.name] = report
        self._heard[report.name] = ReportedProgress(report.version, report.arc_length, report.stamp)

    def step(self, now: float, pose: Optional[Pose], *, pose_stamp: Optional[float] = None,
             horizon: float = math.inf, ahead: float = math.inf) -> Command:
        """The command for the period that begins at `now` [s].

        Parameters
        ----------
        pose, pose_stamp
            As `Tracker.step` takes them.
        horizon : float
            Arc length that must not be passed for what the lidar sees [m].
        ahead : float
            How far the lidar leaves it free to drive straight on [m].
        """
        self._now, self._pose = now, pose
        if not self.lapsed and now - self._acknowledged > self.config.lapse and self.version:
            self.lapsed = True
            self.bound = min(self.bound, self.tracker.stopping_arc_length())
        command = self.tracker.step(now, pose, self._heard, pose_stamp=pose_stamp, horizon=min(horizon, self.bound),
                                    ahead=ahead, halt=_WAITS if self._standing else "")
        self._watch(now, min(horizon - self.tracker.progress, ahead), command)
        if self._asked > self.exchange:
            self._promise()
        return command

    def _promise(self) -> None:
        """Give a promise for the exchange that was asked for; one that stands off any path gives it once it stands."""
        if self.tracker.schedule is not None and not self.astray:
            self.bound = min(self.bound, max(self.tracker.progress, min(
                self.tracker.stopping_arc_length(self.config.lookahead), self.tracker.gate_bound)))
        elif self.tracker.command != STANDSTILL:
            return
        else:
            self._standing = True
        self.exchange = self._asked

    def _watch(self, now: float, room: float, command: Command) -> None:
        """For how long the robot has been astray, and blocked: until it has got away from there."""
        stands = command == STANDSTILL
        self._astray_since = min(self._astray_since, now) if self.tracker.needs_path and stands else math.inf
        if stands and not self.tracker.arrived and room < _AT_OBSTACLE and self._pose is not None:
            if self._blocked_since == math.inf:
                self._blocked_since, self._blocked_at = now, self._pose
            self._blocked_last = now
        elif self._pose is not None and (now - self._blocked_last > _FREE_AGAIN
                                         or distance(self._pose, self._blocked_at) > _AWAY):
            self._blocked_since = math.inf

    @property
    def version(self) -> int:
        """Of the schedule that it follows; 0 without one."""
        return 0 if self.tracker.schedule is None else self.tracker.schedule.version

    @property
    def astray(self) -> bool:
        """Whether it has stood off its path for so long that it needs another one."""
        return self._standing and self.version > 0 or self._now - self._astray_since >= self.config.astray

    @property
    def blocked(self) -> float:
        """For how long something in its way has kept it standing [s]."""
        return max(self._now - self._blocked_since, 0.0)

    @property
    def served(self) -> bool:
        """Whether it stands at the goal of its present errand."""
        return (self.errand is not None and self.assignment is not None and not self.assignment.reason
                and self.assignment.errand == self.errand.number and self.tracker.arrived)

    def report(self, now: float) -> Report:
        """What all others are to be told."""
        tracker, given = self.tracker, self.assignment
        serving, unserved, final = (0, "", False) if given is None else (given.errand, given.reason, given.final)
        return Report(self.name, self.session, now, self.body, self.version, tracker.progress, tracker.command.speed,
                      tracker.state, self._pose, self.exchange, self.bound, self.lapsed, self.astray, self.errand,
                      serving, unserved, final, dict(self.obstacles), self.cleared, self.blocked, tracker.waiting_for,
                      tracker.schedule)
