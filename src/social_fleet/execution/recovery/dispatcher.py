"""Keeps a fleet supplied with schedules: opens exchanges, plans from promises, hands over, and says so until all know.

It keeps nothing that a robot's report does not tell: started anew, it goes on. doc/execution.md has the protocol.
"""

import logging
import math
from dataclasses import replace
from typing import Dict, FrozenSet, List, Mapping, Optional, Set, Tuple

from social_fleet.execution.recovery.charge import Charge
from social_fleet.execution.recovery.config import RecoveryConfig
from social_fleet.execution.recovery.decision import Need, replan_for_delays, replan_for_paths
from social_fleet.execution.recovery.messages import Assignment, Directive, Report
from social_fleet.execution.state import ProgressState
from social_fleet.execution.recovery.remaining import Remaining, stretch
from social_fleet.execution.recovery.replanning import Replanning, Request
from social_fleet.execution.recovery.sightings import SPARE, Sightings
from social_fleet.planning.overlays.shapes import DiscObstacle

log = logging.getLogger(__name__)

_GATHERING = 1.0  # a new robot is heard for so long before anything is planned with it: others may come, too [s]
_ROOM = 0.25  # kept to robots that stand for good, beyond their disc [m]
_AGAIN = "is tried again"
_REST = 2.0  # a robot that stands for less is expected to go on at once [s]


class Dispatcher:
    """Call `step` several times a second, and say what it returns to all robots.

    Parameters
    ----------
    replanning : Replanning
        Makes schedules.
    config : RecoveryConfig
        Times.
    session : int
        Greater than any that a dispatcher of this fleet has had: the time of its start will do.

    Attributes
    ----------
    assignments : dict of str to Assignment
        Those that are not confirmed yet.
    exchanges : int
        How many were opened.
    decisions : list of str
        Why, as sentences, the latest last.
    replans : dict of str to int
        By robot, how often it was fitted in anew.
    """

    def __init__(self, replanning: Replanning, config: RecoveryConfig = RecoveryConfig(), *, session: int = 0) -> None:
        self.config = config
        self.session = session
        self.exchanges = 0
        self.decisions: List[str] = []
        self.replans: Dict[str, int] = {}
        self._replanning = replanning
        self._charges: Dict[str, Charge] = {}
        self._sightings = Sightings()
        self._exchange = 0  # the one that is open, or in force
        self._need: Optional[Need] = None  # of the one that waits for promises
        self.assignments: Dict[str, Assignment] = {}
        self._silent: FrozenSet[str] = frozenset()
        self._standing: FrozenSet[str] = frozenset()
        self._said = -math.inf
        self._began: Optional[float] = None
        self._mentioned: Set[str] = set()

    def hear(self, report: Report) -> None:
        """Take in what a robot says; older news than known is passed over."""
        if report.name not in self._charges:
            self._charges[report.name] = Charge(report, self.config)
        else:
            self._charges[report.name].hear(report)
        if report.schedule is not None:
            self._mentioned.update(report.schedule.peers)
        self._sightings.hear(report)

    def step(self, now: float) -> Optional[Directive]:
        """What is to be said to all robots at `now` [s]; None when there is nothing new, nor time to say it again."""
        self._began = now if self._began is None else self._began
        before = self._exchange, len(self.assignments)
        if self._need is not None:
            self._collect(now)
        else:
            self.assignments = {name: given for name, given in self.assignments.items()
                                if self._charges[name].report.version < given.schedule.version}
            need = self._look(now)
            if need is not None:
                self._open(need)
        if before == (self._exchange, len(self.assignments)) and now - self._said < self.config.beat:
            return None
        self._said = now
        return Directive(now, {name: charge.report.stamp for name, charge in self._charges.items()}, self._exchange,
                         dict(self.assignments), self._sightings.obstacles, tuple(sorted(self._missing)),
                         self.session)

    @property
    def _missing(self) -> Set[str]:
        """Robots that schedules name and that were never heard of."""
        return self._mentioned - set(self._charges)

    def _live(self, now: float) -> List[Charge]:
        """Robots that are heard of, and know where they are or may do so soon."""
        return [charge for name, charge in sorted(self._charges.items())
                if now - charge.report.stamp <= self.config.gone
                and not (charge.is_homeless and now - charge.known_since > self.config.gone)]

    def _note_silence(self, live: List[Charge], now: float) -> FrozenSet[str]:
        """Who takes no part, and where they may stand; those that did until now are returned."""
        silent = frozenset(self._charges) - {charge.name for charge in live}
        new = silent - self._silent
        for name in sorted(new):
            self._sightings.put(name, self._spots(self._charges[name]), now)
        for name in sorted(self._silent - silent):
            self._sightings.drop(name)
        self._silent = silent
        return new

    def _look(self, now: float) -> Optional[Need]:
        """Whether anything calls for an exchange."""
        live = self._live(now)
        if not live or any(now - charge.known_since < _GATHERING for charge in live):
            return None
        if self._missing and now - (self._began or 0.0) < self.config.gone:
            return None  # just started: who was not heard of yet may still drive
        names = [charge.name for charge in live]
        causes = {charge.name: cause for charge in live for cause in [self._cause(charge, now)] if cause}
        if _AGAIN in causes.values():  # together, for they may be in each other's way
            causes.update((charge.name, _AGAIN) for charge in live if charge.name not in causes and charge.is_unserved)
        silent = self._note_silence(live, now)
        standing = frozenset(charge.name for charge in live if charge.rest(now) >= self.config.stuck)
        new = silent | (standing - self._standing)
        for charge in live:
            if charge.name not in new and charge.name not in causes and charge.waits_for(new):
                causes[charge.name] = "is led round " + ", ".join(sorted(new))
        if not causes and silent:
            causes[names[0]] = f"takes note that {', '.join(sorted(silent))} is silent"
        self._standing = standing
        need = replan_for_paths(causes, names)
        return need if need is not None else self._delays(live, now)

    def _cause(self, charge: Charge, now: float) -> str:
        """Why a robot needs another path, as the end of a sentence; empty when it does not."""
        report, given = charge.report, self.assignments.get(charge.name)
        errand = report.errand.number if report.errand is not None else 0
        if given is not None and given.session == report.session:
            return _changed_errand(errand, given.errand)
        if charge.is_homeless:
            return ""
        if report.astray:
            return "stands off its path"
        if report.lapsed:
            return "was silent"
        if report.version == 0:
            return "has no schedule"
        if report.version < self._exchange:
            return "follows an old schedule"
        if errand != report.serving:
            return _changed_errand(errand, report.serving)
        if now - charge.replanned < self.config.retry * charge.pauses:
            return ""
        if report.unserved and errand:
            changed = charge.circumstances != (self._sightings.version, self._silent, self._standing)
            return _AGAIN if not report.final or changed else ""
        if report.blocked >= self.config.obstacle_patience:
            return "has something in its way"
        return ""

    def _delays(self, live: List[Charge], now: float) -> Optional[Need]:
        """A replan for robots that are late, unless there was one for them just now."""
        schedules = {charge.name: charge.schedule for charge in live if charge.schedule is not None}
        late = [charge.name for charge in live if charge.is_culprit and now - charge.replanned >= charge.patience]
        if len(schedules) < len(live) or not late or self.assignments:
            return None
        return replan_for_delays({charge.name: charge.delay for charge in live}, late, schedules,
                                 {charge.name: charge.report.arc_length for charge in live})

    def _open(self, need: Need) -> None:
        """Ask all for their promises."""
        self._exchange = 1 + max([self._exchange, *(max(charge.report.exchange, charge.report.version)
                                                    for charge in self._charges.values())])
        self._need = need
        self.assignments = {}
        self.exchanges += 1
        self.decisions.append(f"{need.mode}: {need.reason}")
        log.info("exchange %d, %s: %s", self._exchange, need.mode, need.reason)

    def _collect(self, now: float) -> None:
        """Plan once all that are heard of have promised."""
        assert self._need is not None
        live = self._live(now)
        if any(max(charge.report.version, charge.report.exchange) > self._exchange
               or charge.report.version == self._exchange for charge in live):
            self._open(self._need)  # another dispatcher, one that has ended, has used the number
            return
        if any((charge.report.exchange, charge.report.promised_to) != (self._exchange, self.session)
               for charge in live):
            return
        if any(charge.report.version and charge.schedule is None for charge in live):
            return  # nobody has said yet what it follows
        if any(charge.is_homeless for charge in live):
            return  # nobody knows where it is, itself included
        self._note_silence(live, now)  # who fell silent since the exchange was opened stands somewhere
        need, self._need = self._need, None
        remaining = [Remaining.of(charge.report, charge.schedule) for charge in live]
        request = Request(
            self._exchange, now, remaining, need, rests={charge.name: self._rest(charge, now) for charge in live},
            obstacles=self._sightings.beside(charge.report for charge in live), standing=self._places(live, now),
            doubtful=self._sightings.doubtful(now), silent=self._silent,
            give_up=frozenset(charge.name for charge in live if charge.hopeless(now)))
        self.assignments = {name: replace(given, dispatcher=self.session)
                            for name, given in self._replanning.assignments(request).items()}
        for charge in live:
            charge.give(self.assignments[charge.name], now, anew=charge.name in need.robots,
                        circumstances=(self._sightings.version, self._silent, self._standing))
        for name in need.robots:
            self.replans[name] = self.replans.get(name, 0) + 1

    def _rest(self, charge: Charge, now: float) -> float:
        """For how long a robot is expected to stand on: as long again as it has stood [s]."""
        rest = charge.rest(now)
        return rest if rest >= _REST else 0.0

    def _places(self, live: List[Charge], now: float) -> Mapping[str, Tuple[DiscObstacle, ...]]:
        """Where robots are that are not to be waited for."""
        places: Dict[str, Tuple[DiscObstacle, ...]] = {}
        for name in sorted(self._silent):
            places[name] = self._sightings.places(name)
        for charge in live:
            pose, radius = charge.report.pose, charge.report.body.radius
            if charge.name in self._standing and pose is not None:
                places[charge.name] = (DiscObstacle(pose.x, pose.y, radius + _ROOM),)
        return places

    def _spots(self, charge: Charge) -> Tuple[DiscObstacle, ...]:
        """Where a robot that fell silent may have come to: as far as it could drive until it had to stand."""
        report, reach = charge.report, charge.report.body.limits.max_speed * (self.config.lapse + 1.0)
        spots: List[Tuple[float, float]] = [] if charge.place is None else [(charge.place.x, charge.place.y)]
        if charge.schedule is not None and not report.astray and report.state is not ProgressState.ARRIVED:
            item = Remaining.of(report, charge.schedule)
            spots += stretch(item.prefix if math.isfinite(report.bound) else item.way, reach)
        return tuple(DiscObstacle(x, y, report.body.radius + _ROOM - SPARE) for x, y in spots)


def _changed_errand(number: int, served: int) -> str:
    """What is new about an errand other than the one that is served, or will be; 0 is none."""
    if number == served:
        return ""
    return "has a new goal" if number else "has no goal any more"
