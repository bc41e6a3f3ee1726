"""What a dispatcher knows of one robot."""

from typing import Dict, FrozenSet, Optional, Tuple

from social_fleet.coordination.schedule import Schedule
from social_fleet.execution.delay_monitor import DelayMonitor
from social_fleet.execution.recovery.config import RecoveryConfig
from social_fleet.execution.recovery.messages import Assignment, Report
from social_fleet.execution.state import ProgressState
from social_fleet.geometry import Pose

_MOVED = 0.05  # a robot that has come so much further moves [m]
_TURNED = 0.1  # or turned by so much [rad]
_BOUND = 2.0  # within so long after it moved a robot that stands at its promise stands because of that [s]
_LONGEST_PATIENCE = 60.0  # [s]


class Charge:
    """One robot as its reports show it.

    Attributes
    ----------
    report : Report
        The latest.
    known_since : float
        When it, in its present session, was first heard of [s].
    place : Pose, optional
        Where it last knew itself to be, in whatever session [m, rad, map frame].
    given : Assignment, optional
        The latest that was made for it.
    replanned : float
        When it was last fitted in anew [s].
    patience : float
        For how long it is then left alone with its delay [s].
    pauses : float
        How many times as long as at first it is left alone when it could not be served.
    """

    def __init__(self, report: Report, config: RecoveryConfig) -> None:
        self.report = report
        self.known_since = report.stamp
        self.place: Optional[Pose] = None
        self.given: Optional[Assignment] = None
        self.replanned = -1e9
        self.patience = config.patience
        self.pauses = 1.0
        self.circumstances: Tuple[object, ...] = ()
        self._config = config
        self._schedules: Dict[int, Schedule] = {}
        self._monitor: Optional[DelayMonitor] = None
        self._moved_at = report.stamp
        self._mark = report
        self._unserved_since: Optional[float] = None
        self._errand_since = report.stamp
        self._learn(report)

    @property
    def name(self) -> str:
        """The robot's name."""
        return self.report.name

    def hear(self, report: Report) -> None:
        """Take in a later report."""
        if report.age <= self.report.age:
            return
        if report.session != self.report.session or report.stamp - self.report.stamp > self._config.gone:
            self.known_since = report.stamp
        if _number(report) != _number(self.report):  # what kept it from its former goal is not held against this one
            self._errand_since, self._unserved_since = report.stamp, None
        self._learn(report)
        self.report = report

    def _learn(self, report: Report) -> None:
        """Place, delay and motion."""
        self.place = report.pose or self.place
        if report.schedule is not None:
            self._schedules[report.version] = report.schedule
        if report.version and report.version in self._schedules:
            schedule = self._schedules[report.version]
            if self._monitor is None or self._monitor.schedule is not schedule:
                self._monitor = DelayMonitor(schedule, late=self._config.late, recovered=self._config.recovered)
            self._monitor.update(report.stamp, report.arc_length)
        else:
            self._monitor = None
        mark = self._mark
        turned = (report.pose is not None and mark.pose is not None
                  and abs(report.pose.yaw - mark.pose.yaw) > _TURNED)
        if (report.arc_length - mark.arc_length > _MOVED or report.session != mark.session or turned
                or self._is_excused(report)):
            self._moved_at, self._mark = report.stamp, report
        elif report.version != mark.version:
            self._mark = report

    def _is_excused(self, report: Report) -> bool:
        """Whether a robot stands for a reason that is none of its own."""
        if report.version == 0 or report.state in (ProgressState.ARRIVED, ProgressState.HOLDING):
            return True
        schedule = self._schedules.get(report.version)
        if schedule is None or report.stamp < schedule.times[0]:
            return True
        if report.arc_length >= float(schedule.arc_length(report.stamp)) - _MOVED:
            return True
        came = report.stamp - self._moved_at < _BOUND  # it drove up to its promise: one that stood before stands on
        return came and report.arc_length >= report.bound - _MOVED

    @property
    def is_homeless(self) -> bool:
        """Whether it stands it does not know where: no schedule can begin there."""
        return self.report.pose is None and (self.report.version == 0 or self.report.astray)

    @property
    def schedule(self) -> Optional[Schedule]:
        """What it follows."""
        return self._schedules.get(self.report.version)

    @property
    def delay(self) -> float:
        """[s]."""
        return 0.0 if self._monitor is None else self._monitor.delay

    @property
    def is_culprit(self) -> bool:
        """Whether it is late, and not for having to wait."""
        return (self._monitor is not None and self._monitor.is_late
                and self.report.state not in (ProgressState.HOLDING, ProgressState.ARRIVED))

    @property
    def is_unserved(self) -> bool:
        """Whether it has an errand and no schedule that leads to its goal."""
        return self.report.errand is not None and bool(self.report.unserved)

    def rest(self, now: float) -> float:
        """For how long it has stood though it could have moved [s]."""
        return max(now - self._moved_at, 0.0) if not self._is_excused(self.report) else 0.0

    def waits_for(self, names: FrozenSet[str]) -> bool:
        """Whether its schedule has it wait for any of `names` still, or pass where one may be."""
        schedule = self.schedule
        return schedule is not None and (self.report.state is not ProgressState.ARRIVED) and bool(
            {rule.other for rule in schedule.precedences if rule.at >= self.report.arc_length} & names)

    def give(self, assignment: Assignment, now: float, *, anew: bool, circumstances: Tuple[object, ...]) -> None:
        """Note what was made for it, and whether it was fitted in `anew` or only along with others."""
        unserved = bool(assignment.reason)
        if anew:
            late = self.is_culprit
            self.patience = min(2.0 * self.patience, _LONGEST_PATIENCE) if late else self._config.patience
            self.replanned = now
            self.pauses = min(2.0 * self.pauses, 4.0) if unserved else 1.0
        if unserved and self._unserved_since is None:
            self._unserved_since = now
        elif not unserved:
            self._unserved_since = None
        self.given = assignment
        self.circumstances = circumstances
        self._schedules = {version: schedule for version, schedule in self._schedules.items()
                           if version >= self.report.version}
        self._schedules[assignment.schedule.version] = assignment.schedule

    def hopeless(self, now: float) -> bool:
        """Whether it has had no way to its present goal for so long, or stood before something, that it is given up."""
        since = self._unserved_since
        return ((since is not None and now - since >= self._config.give_up)
                or min(self.report.blocked, now - self._errand_since) >= self._config.give_up)


def _number(report: Report) -> int:
    return 0 if report.errand is None else report.errand.number
