"""What becomes of one robot's goals: an explicit state machine that knows neither ROS nor how anything is done.

It is told what happens and says what is to be done next (`errand`) and whether the robot must be held (`holds`).
Answers carry the number of the attempt that they belong to; what belongs to an earlier one changes nothing.
"""

import logging
from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import FrozenSet, Mapping, NamedTuple, Optional

from social_fleet.geometry import Pose
from social_fleet.parameters import Parameters, parameter

log = logging.getLogger(__name__)


class NavigationState(IntEnum):
    """The states, numbered as in the NavigationStatus message."""

    IDLE = 0  # there was no goal yet
    STOPPING = 1  # brakes for another goal
    PLANNING = 2  # the planner looks for a path
    COORDINATING = 3  # the fleet makes room for it
    DRIVING = 4  # the tracker drives it
    WAITING = 5  # could not, and will try again soon
    SUCCEEDED = 6  # stands at the goal
    CANCELED = 7  # the goal was taken back
    ABORTED = 8  # given up, for a reason


class Errand(Enum):
    """What is to be done for a robot by those who can."""

    NOTHING = "nothing"
    PLAN = "plan"  # a path from where it stands to the goal
    COORDINATE = "coordinate"  # a schedule for that path
    PARK = "park"  # have the fleet plan round where it stands: it will not drive its schedule any more


class RobotNews(NamedTuple):
    """What is known of a robot by its tracker."""

    version: int  # of the schedule that it follows; 0: of none
    standing: bool  # whether it neither moves nor turns
    arrived: bool  # whether it stands at the end of that schedule
    trouble: str = ""  # why it cannot go on by that schedule; empty while it can
    blocked: str = ""  # why it should look for another way; it may still go on by itself


_NEXT: Mapping[NavigationState, FrozenSet[NavigationState]] = {
    NavigationState.IDLE: frozenset({NavigationState.STOPPING, NavigationState.PLANNING}),
    NavigationState.STOPPING: frozenset({NavigationState.PLANNING, NavigationState.CANCELED}),
    NavigationState.PLANNING: frozenset({NavigationState.COORDINATING, NavigationState.WAITING,
                                         NavigationState.DRIVING, NavigationState.ABORTED, NavigationState.CANCELED,
                                         NavigationState.STOPPING}),
    NavigationState.COORDINATING: frozenset({NavigationState.DRIVING, NavigationState.WAITING,
                                             NavigationState.ABORTED, NavigationState.CANCELED,
                                             NavigationState.STOPPING}),
    NavigationState.DRIVING: frozenset({NavigationState.SUCCEEDED, NavigationState.PLANNING, NavigationState.STOPPING,
                                        NavigationState.ABORTED, NavigationState.CANCELED}),
    NavigationState.WAITING: frozenset({NavigationState.PLANNING, NavigationState.STOPPING, NavigationState.ABORTED,
                                        NavigationState.CANCELED}),
}
_NEW_GOAL = frozenset({NavigationState.STOPPING, NavigationState.PLANNING})  # what follows on an end
_ACTIVE = frozenset(_NEXT) - {NavigationState.IDLE}
_HELD = frozenset({NavigationState.STOPPING, NavigationState.PLANNING, NavigationState.COORDINATING,
                   NavigationState.WAITING})


@dataclass(frozen=True)
class NavigationConfig(Parameters):
    """How long a goal is worth trying for."""

    patience: float = parameter(20.0, minimum=0.0)  # to be refused in a row before a goal is given up [s]
    blocked_patience: float = parameter(60.0, minimum=0.0)  # for a way that is blocked, or a robot in trouble [s]
    retry_period: float = parameter(1.0, above=0.0)  # between two attempts [s]


class Navigation:
    """The goals of one robot, one at a time; a new one takes the place of the one before.

    Parameters
    ----------
    config : NavigationConfig

    Attributes
    ----------
    state : NavigationState
    goal : Pose, optional
        The present goal, or the last one [m, rad, map frame].
    number : int
        Of the present attempt; answers to earlier ones are passed over.
    version : int
        Of the schedule that the robot drives towards the goal; 0: of none.
    reason : str
        Why it waits, was canceled or aborted, as a sentence; empty when all is well.
    since : float
        When the state was entered [s].
    replans : int
        How often this goal needed another path.
    """

    def __init__(self, config: NavigationConfig = NavigationConfig()) -> None:
        self.config = config
        self.state = NavigationState.IDLE
        self.goal: Optional[Pose] = None
        self.number = 0
        self.version = 0
        self.reason = ""
        self.since = 0.0
        self.replans = 0
        self._claims = False  # a schedule is in force that the robot does not drive any more
        self._returns = False  # the old schedule holds where the attempt fails
        self._failing: Optional[float] = None  # since when attempts fail
        self._due = 0.0  # when to try again
        self._standing = False
        self._under_way = False  # whether it has a schedule that it has not driven to the end

    @property
    def active(self) -> bool:
        """Whether there is a goal that is not done with."""
        return self.state in _ACTIVE

    @property
    def holds(self) -> bool:
        """Whether the robot must not move by the schedule that it has."""
        return self.state in _HELD or (self._claims and self.state is not NavigationState.DRIVING)

    @property
    def errand(self) -> Errand:
        """What is to be done next."""
        if self.state is NavigationState.PLANNING:
            return Errand.PLAN
        if self.state is NavigationState.COORDINATING:
            return Errand.COORDINATE
        if not self.active and self._claims and self._standing:
            return Errand.PARK
        return Errand.NOTHING

    def accept(self, goal: Pose, now: float) -> None:
        """Go to `goal`, whatever was before."""
        self.goal, self.reason, self.replans = goal, "", 0
        self._returns, self._failing = False, None
        self._claims |= self._under_way
        self._enter(NavigationState.STOPPING, now)

    def cancel(self, now: float, reason: str = "the goal was taken back") -> None:
        """Have no goal any more; nothing happens when there is none."""
        if self.active:
            self._end(NavigationState.CANCELED, now, reason)

    def hear(self, news: RobotNews, now: float, *, busy: bool = False) -> None:
        """Take in where the robot is; `busy`: a schedule that was asked for earlier may still come into force."""
        self._standing = news.standing and not busy
        self._under_way = news.version > 0 and not news.arrived
        if self.state is NavigationState.STOPPING and self._standing:
            self._enter(NavigationState.PLANNING, now)
        elif self.state is NavigationState.WAITING and now >= self._due and self._standing:
            self._enter(NavigationState.PLANNING, now)
        elif self.state is NavigationState.DRIVING and news.version >= self.version:
            self._follow(news, now)

    def _follow(self, news: RobotNews, now: float) -> None:
        if news.arrived:
            self._claims = False
            self.reason = ""
            self._enter(NavigationState.SUCCEEDED, now)
        elif (news.trouble or news.blocked) and news.standing:
            if self._failing is None or now >= self._due:
                self._returns = not news.trouble
                self.reason = news.trouble or news.blocked
                self.replans += 1
                self._enter(NavigationState.PLANNING, now)
        elif not news.standing:
            self._failing = None
            self.reason = ""

    def planned(self, number: int, now: float) -> bool:
        """There is a path; whether anybody still wants it."""
        if number != self.number or self.state is not NavigationState.PLANNING:
            return False
        self._enter(NavigationState.COORDINATING, now, same=True)
        return True

    def scheduled(self, number: int, version: int, now: float) -> bool:
        """Schedule `version` is in force; whether the robot is to drive it."""
        self._claims = True
        if number != self.number or self.state is not NavigationState.COORDINATING:
            return False
        self.version = version
        self.reason = ""
        self._enter(NavigationState.DRIVING, now)
        return True

    def refused(self, number: int, now: float, reason: str, *, final: bool = False) -> None:
        """There is no path or no schedule; `final`: and trying again will not help."""
        if number != self.number or self.state not in (NavigationState.PLANNING, NavigationState.COORDINATING):
            return
        self._failing = now if self._failing is None else self._failing
        patience = self.config.blocked_patience if self.replans else self.config.patience
        if (final and not self.replans) or now - self._failing >= patience:
            self._end(NavigationState.ABORTED, now, reason)
            return
        self.reason = reason
        self._due = now + self.config.retry_period
        self._enter(NavigationState.DRIVING if self._returns else NavigationState.WAITING, now)

    def parked(self, now: float) -> None:
        """The fleet plans round where the robot stands."""
        if not self.active:
            self._claims = False

    def _end(self, state: NavigationState, now: float, reason: str) -> None:
        self.reason = reason
        self._enter(state, now)

    def _enter(self, state: NavigationState, now: float, *, same: bool = False) -> None:
        """Change the state; a new attempt begins unless it is the `same`."""
        allowed = _NEXT.get(self.state, _NEW_GOAL) | {NavigationState.STOPPING}
        assert state in allowed, f"{self.state.name} is not followed by {state.name}"
        self.number += not same
        log.debug("%s after %s: %s", state.name, self.state.name, self.reason)
        self.state, self.since = state, now
