"""The precedence gate: how far a robot may go by what the others have reported, whatever the clock says."""

import math
from typing import Dict, List, Mapping, NamedTuple, Optional, Set, Tuple

from social_fleet.coordination.schedule import Precedence, Schedule


class ReportedProgress(NamedTuple):
    """What a robot last said of its progress."""

    version: int  # of the schedule that it follows
    arc_length: float  # measured along that schedule's path [m]
    stamp: float  # when it was measured [s]


class Waiting(NamedTuple):
    """Whom a robot waits for."""

    other: str
    at: float  # where on its own path it waits [m]
    other_at: float  # what the other has to pass on its path [m]
    since: float  # [s]


class PrecedenceGate:
    """Bounds the arc length of one robot by the precedences that are not yet released.

    Before it passes anything beyond what it is committed to, all `peers` of its schedule must have left older ones.

    A precedence is released once `other` has reported an arc length of at least `other_at` on the very schedule
    version that `other_at` belongs to. Without news nothing is released; what is released stays so, because progress
    never falls.

    Parameters
    ----------
    standoff : float
        How far before `at` the robot is to stand [m].
    release_tolerance : float
        How far short of `other_at` counts as passed [m]: robots stand by their standoff short of where they wait,
        and must not wait for each other's last centimetres. Part of the tracking tolerance that windows include.

    Attributes
    ----------
    bound : float
        The arc length that must not be exceeded [m]; infinite when nothing is left to wait for.
    """

    def __init__(self, *, standoff: float = 0.02, release_tolerance: float = 0.03) -> None:
        self._standoff = standoff
        self._tolerance = release_tolerance
        self._precedences: List[Precedence] = []
        self._next = 0
        self._awaited: Set[str] = set()
        self._passed: Dict[Tuple[str, int], float] = {}
        self._since: Optional[float] = None
        self._version = 0
        self._committed = math.inf
        self._unconfirmed: Set[str] = set()
        self._newest: Dict[str, int] = {}
        self.bound = math.inf

    def follow(self, schedule: Schedule) -> None:
        """Hold the robot to the precedences of `schedule` from now on; what others have passed is remembered."""
        self._precedences = sorted(schedule.precedences, key=lambda precedence: precedence.at)
        self._next = 0
        self._since = None
        self._version = schedule.version
        self._committed = schedule.robot.committed or 0.0
        self._unconfirmed = {name for name in schedule.peers if self._newest.get(name, 0) < schedule.version}
        self._advance(anew=True)

    def hear(self, others: Mapping[str, ReportedProgress]) -> None:
        """Take in the latest reports, by name; those of robots that nothing is awaited from are passed over."""
        changed = confirmed = False
        for name in self._awaited:
            report = others.get(name)
            if report is not None and report[1] > self._passed.get((name, report[0]), -math.inf):
                self._passed[name, report[0]] = report[1]
                changed = True
        if self._unconfirmed:
            for name, report in others.items():
                self._newest[name] = max(report.version, self._newest.get(name, 0))
            left = {name for name in self._unconfirmed if self._newest.get(name, 0) < self._version}
            confirmed, self._unconfirmed = left != self._unconfirmed, left
        if changed or confirmed:
            self._advance(anew=confirmed)

    def _advance(self, *, anew: bool = False) -> None:
        """Step over what is released; a later precedence cannot bind before an earlier one."""
        first = self._next
        while self._next < len(self._precedences) and self._released(self._precedences[self._next]):
            self._next += 1
            self._since = None
        if self._next > first or anew:
            self._bind()

    def _bind(self) -> None:
        """Find the bound, and whose reports may move it."""
        self._awaited = {precedence.other for precedence in self._precedences[self._next:]}
        held = self._next < len(self._precedences)
        self.bound = max(self._precedences[self._next].at - self._standoff, 0.0) if held else math.inf
        if self._unconfirmed:
            self.bound = min(self.bound, self._committed)

    def _released(self, precedence: Precedence) -> bool:
        passed = self._passed.get((precedence.other, precedence.other_version))
        return passed is not None and passed >= precedence.other_at - self._tolerance

    def waiting_for(self, now: float) -> Optional[Waiting]:
        """Whom a robot that stands at the bound at `now` waits for; None when nothing holds it."""
        if self._next == len(self._precedences) and not self._unconfirmed:
            return None
        if self._since is None:
            self._since = now
        if self._unconfirmed and self.bound == self._committed:
            return Waiting(min(self._unconfirmed), self._committed, 0.0, self._since)
        precedence = self._precedences[self._next]
        return Waiting(precedence.other, precedence.at, precedence.other_at, self._since)

    def moving(self) -> None:
        """The robot does not stand at the bound: a later wait starts anew."""
        self._since = None
