"""One robot's part in a coordination without a coordinator (3.4.2).

Every robot announces its path; searches the pairs that are its share (`coordination.work_sharing`) as soon as it knows
both paths; tells all others what it found; and solves the program of the whole fleet, which is the same for all. Then
each tells the others a digest of its schedule, and takes it for valid only when all have the same one.

News that comes late, twice or in any order changes nothing: paths are sorted by name, and the windows of a pair follow
from its two paths, whoever searches them. So a robot that waits in vain for another's windows searches them itself.
In vain for its *path* or its verdict there is nothing to do: a fleet that would leave one robot out could not know
that all others leave it out, too.
"""

import logging
import math
from typing import Callable, Dict, Iterable, List, Optional, Sequence, Tuple, Union

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.encounters import Encounter, EncounterFinder
from social_fleet.coordination.replanning import Replanner
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import FleetSchedule, Schedule
from social_fleet.coordination.work_sharing import Pair, share_pairs
from social_fleet.errors import Disagreement, InvalidParameter, InvalidScenario, SilentRobot, SocialFleetError
from social_fleet.fleet.conversation import Conversation
from social_fleet.fleet.encoding import decode, encode, schedule_digest
from social_fleet.fleet.messages import Announcement, Findings, Message, PairWindows, Round, Verdict, digest
from social_fleet.fleet.transport import Transport

log = logging.getLogger(__name__)

PairKey = Tuple[str, str, str, str]  # both names, and the digests of both announcements


class Participant:
    """One robot of a `Round`. Call `poll` often, from one thread; it waits for nobody.

    Parameters
    ----------
    own : Robot or Schedule
        The robot with its path, one of the round's `planning`; or its schedule under way, one of its `fixed`, on the
        fleet's clock.
    round_ : Round
        The same for all.
    transport : Transport
        The way to the others.
    limit : float
        How long to wait for a path, or for the windows of a pair [s].
    repeat : float
        After what time everything is said again, for those who missed it [s].
    time_limit, solver, replanner
        As `coordinate` takes them; planner and solver the same for all, or else there may be no common schedule.

    Raises
    ------
    InvalidScenario
        When the robot has no part in the round, or another one than it takes.
    InvalidParameter
        When a time is not positive and finite.
    """

    def __init__(self, own: Union[Robot, Schedule], round_: Round, transport: Transport, *, limit: float = 5.0,
                 repeat: float = 0.5, time_limit: float = 30.0, solver: Optional[str] = None,
                 replanner: Optional[Replanner] = None) -> None:
        for value, field in ((limit, "limit"), (repeat, "repeat"), (time_limit, "time_limit")):
            if not 0.0 < value < math.inf:
                raise InvalidParameter(f"must be positive and finite, not {value!r}", field=field)
        part = "fixed" if isinstance(own, Schedule) else "planning"
        if own.name not in getattr(round_, part):
            raise InvalidScenario(f"robot {own.name} is none of the round's robots: {', '.join(getattr(round_, part))}",
                                  field=part)
        self.name = own.name
        self.searched_for: Tuple[str, ...] = ()
        """Robots whose pairs this one searched in their stead."""
        self._round, self._key = round_, round_.key
        self._talk = Conversation(own.name, round_.key, round_.robots, transport, repeat)
        self._limit, self._time_limit = limit, time_limit
        self._solver, self._replanner = solver, replanner
        self._finder = EncounterFinder(round_.tracking_tolerance)
        self._shares = share_pairs(round_.planning, round_.fixed)
        self._paths: Dict[str, Tuple[str, Announcement]] = {}  # with their digests
        self._found: Dict[PairKey, Tuple[Encounter, ...]] = {}
        self._verdicts: Dict[str, Verdict] = {}
        self._stage: Callable[[float], None] = self._begin
        self._deadline = -math.inf
        self._fleet: Optional[FleetSchedule] = None
        self._agreed = False
        self._failure: Optional[SocialFleetError] = None
        if isinstance(own, Schedule):
            self._opening = encode(Announcement(self._key, own.robot, own))
        else:
            self._opening = encode(Announcement(self._key, own))

    def poll(self, now: float) -> Optional[FleetSchedule]:
        """Hear what came, do what can be done, and say it.

        Parameters
        ----------
        now : float
            Time on any clock that does not go back [s].

        Returns
        -------
        FleetSchedule or None
            The schedule of the whole fleet, once all robots have confirmed it; None until then. Poll on for some
            `repeat` more, for the sake of those who have missed a message.

        Raises
        ------
        SilentRobot
            Some were not heard of within the limit.
        Disagreement
            Some have another schedule or none, announced two paths, or share a name.
        Infeasible, InvalidScenario, TimedOut, SolverFailed
            What `coordinate` finds; every robot finds the same. After an exception every poll raises it again.
        """
        if self._failure is not None or self._agreed:
            self._talk.discard()
        else:
            self._advance(now)
        self._talk.repeat(now)
        if self._failure is not None:
            raise self._failure
        return self._fleet if self._agreed else None

    def _advance(self, now: float) -> None:
        """Hear, and get as far as that allows; an end without a schedule is told to the others like one with."""
        try:
            for message, content in self._talk.listen(now):
                self._take(message, content)
            self._stage(now)
        except SocialFleetError as error:
            self._failure = error
            self._talk.say(encode(Verdict(self._key, self.name, "", str(error))), now)

    def _take(self, message: Message, content: bytes) -> None:
        if isinstance(message, Announcement):
            self._take_path(message, digest(content))
        elif isinstance(message, Findings):
            for pair in message.pairs:
                self._found[pair.r, pair.s, pair.r_path, pair.s_path] = pair.windows
        else:
            self._verdicts[message.sender] = message

    def _take_path(self, message: Announcement, fingerprint: str) -> None:
        name = message.sender
        if self._paths.setdefault(name, (fingerprint, message))[0] != fingerprint:
            raise Disagreement(f"robot {name} announced two different paths in one round; begin a new round",
                               robots=[name])
        if (message.schedule is not None) != (name in self._round.fixed):
            raise Disagreement(f"robot {name} {'has no' if message.schedule is None else 'has a'} schedule under way, "
                               "unlike what the round says; begin a new round", robots=[name])

    def _begin(self, now: float) -> None:
        self._talk.say(self._opening, now)
        message = decode(self._opening)  # its own robot, too, is the one that the others hear of
        self._take(message, self._opening)
        self._stage, self._deadline = self._search_own, now + self._limit
        self._stage(now)

    def _search_own(self, now: float) -> None:
        """Search one's share as the paths come; once it is done, tell the others."""
        own = self._shares[self.name]
        self._search([pair for pair in own if self._paths.keys() >= set(pair)])
        self._check_paths({name for pair in own for name in pair}, now)
        if all(self._paths.keys() >= set(pair) for pair in own):
            found = [PairWindows(*self._key_of(pair), windows=self._found[self._key_of(pair)]) for pair in own]
            self._talk.say(encode(Findings(self._key, self.name, tuple(found))), now)
            self._stage = self._gather_paths
            self._stage(now)

    def _gather_paths(self, now: float) -> None:
        """Until all paths are there."""
        if self._check_paths(self._round.robots, now):
            self._stage, self._deadline = self._gather_windows, now + self._limit
            self._stage(now)

    def _check_paths(self, names: Iterable[str], now: float) -> bool:
        """Whether those paths are there; raises SilentRobot when they should be by now."""
        missing = sorted(set(names) - self._paths.keys())
        if missing and now >= self._deadline:
            raise self._silent(missing, "no path")
        return not missing

    def _gather_windows(self, now: float) -> None:
        """Until all windows are there, or it takes too long."""
        late = {name: pairs for name, pairs in self._shares.items()
                if any(self._key_of(pair) not in self._found for pair in pairs)}
        if late and now < self._deadline:
            return
        lost = [name for name in late if now - self._talk.heard_at[name] >= self._limit]
        if lost:
            raise self._silent(lost, "no more than a path")
        for name, pairs in late.items():
            log.info("robot %s searches the pairs of %s, whose windows have not come", self.name, name)
            self._search(pairs)
        self.searched_for = tuple(late)
        self._solve(now)

    def _gather_verdicts(self, now: float) -> None:
        """Until all have confirmed the same schedule."""
        own = self._verdicts[self.name].schedule
        for verdict in (self._verdicts[name] for name in self._round.robots if name in self._verdicts):
            if verdict.reason:
                raise Disagreement(f"robot {verdict.sender} has no schedule: {verdict.reason}",
                                   robots=[verdict.sender])
            if verdict.schedule != own:
                raise Disagreement(f"robots {self.name} and {verdict.sender} found different schedules from the same "
                                   "paths; run one release with one solver, and leave it time enough",
                                   robots=[self.name, verdict.sender])
        missing = [name for name in self._round.robots if name not in self._verdicts]
        if missing and now >= self._deadline:
            raise self._silent(missing, "no verdict")
        self._agreed = not missing

    def _search(self, pairs: Sequence[Pair]) -> None:
        for pair in pairs:
            key = self._key_of(pair)
            if key not in self._found:
                r, s = (self._paths[name][1].robot for name in pair)
                self._found[key] = self._finder.between(r, s)

    def _key_of(self, pair: Pair) -> PairKey:
        r, s = pair
        return r, s, self._paths[r][0], self._paths[s][0]

    def _solve(self, now: float) -> None:
        """The program of the whole fleet, and the verdict on it."""
        told = {name: self._paths[name][1] for name in self._round.robots}
        for pairs in self._shares.values():
            for r, s in pairs:
                self._finder.learn(told[r].robot, told[s].robot, self._found[self._key_of((r, s))])
        fixed = [told[name].schedule for name in self._round.fixed]
        self._fleet = coordinate(
            [told[name].robot for name in self._round.planning], mode="unified" if fixed else "simultaneous",
            fixed=[schedule for schedule in fixed if schedule is not None], time_margin=self._round.time_margin,
            tracking_tolerance=self._round.tracking_tolerance, time_limit=self._time_limit, solver=self._solver,
            replanner=self._replanner, repairs=self._round.repairs, version=self._round.version, finder=self._finder)
        verdict = Verdict(self._key, self.name, schedule_digest(self._fleet))
        self._verdicts[self.name] = verdict
        self._talk.say(encode(verdict), now)
        self._stage, self._deadline = self._gather_verdicts, now + self._time_limit + 2.0 * self._limit
        self._stage(now)

    def _silent(self, names: List[str], what: str) -> SilentRobot:
        return SilentRobot(f"robot {self.name} has heard {what} from {', '.join(names)} within the limit; begin a new "
                           "round that leaves out whoever is gone, and keeps clear of where they stand", robots=names)
