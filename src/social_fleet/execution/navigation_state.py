"""What becomes of one robot's goals: an explicit state machine that knows neither ROS nor how anything is done.

It is told what happens, and says whether a path is to be asked for (`wants_path`) and what the robot is to do
(`order`).
"""

import logging
from dataclasses import dataclass
from enum import IntEnum
from typing import FrozenSet, Mapping, NamedTuple, Optional

from social_fleet.geometry import Pose
from social_fleet.parameters import Parameters, parameter

log = logging.getLogger(__name__)


class NavigationState(IntEnum):
    """The states, numbered as in the NavigationStatus message."""

    IDLE = 0  # there was no goal yet
    PLANNING = 1  # the planner is asked whether there is a path
    COORDINATING = 2  # the fleet makes room for it
    DRIVING = 3  # on a schedule that leads to the goal
    WAITING = 4  # cannot now, and will as soon as it can
    SUCCEEDED = 5  # stands at the goal
    CANCELED = 6  # the goal was taken back
    ABORTED = 7  # given up, for a reason


class Order(NamedTuple):
    """What the robot is to do: go to `goal`, or stay where it is."""

    number: int  # of the goal that it belongs to
    goal: Optional[Pose]


class RobotNews(NamedTuple):
    """What the robot itself says."""

    assigned: int = 0  # number of the goal that its schedule was made for; 0: for none
    reason: str = ""  # why that schedule does not lead there; empty when it does
    final: bool = False  # with a reason: and never will
    arrived: bool = False  # whether it stands at the end of its schedule
    trouble: str = ""  # why it cannot go on just now; empty while it can


_ACTIVE = frozenset({NavigationState.PLANNING, NavigationState.COORDINATING, NavigationState.DRIVING,
                     NavigationState.WAITING})
_ENDS = frozenset({NavigationState.CANCELED, NavigationState.ABORTED})
_NEXT: Mapping[NavigationState, FrozenSet[NavigationState]] = {
    NavigationState.PLANNING: frozenset({NavigationState.COORDINATING, NavigationState.WAITING}) | _ENDS,
    NavigationState.COORDINATING: frozenset({NavigationState.DRIVING, NavigationState.WAITING,
                                             NavigationState.SUCCEEDED}) | _ENDS,
    NavigationState.DRIVING: frozenset({NavigationState.WAITING, NavigationState.SUCCEEDED}) | _ENDS,
    NavigationState.WAITING: frozenset({NavigationState.PLANNING, NavigationState.COORDINATING,
                                        NavigationState.DRIVING, NavigationState.SUCCEEDED}) | _ENDS,
}  # besides PLANNING, which a new goal leads to from everywhere


@dataclass(frozen=True)
class NavigationConfig(Parameters):
    """How long a goal is worth trying for; config/navigator.yaml says when to change what.

    Raises
    ------
    InvalidParameter
        When a value is of a wrong type or out of range; `field` names it.
    """

    patience: float = parameter(20.0, minimum=0.0)  # without any answer of planner or fleet [s]
    waiting_patience: float = parameter(240.0, minimum=0.0)  # where the robot cannot go on [s]
    retry_period: float = parameter(1.0, above=0.0)  # between two questions to the planner [s]


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
        Of that goal; 0 before the first.
    order : Order, optional
        What the robot is to do; None before the first goal.
    reason : str
        Why it waits, was canceled or aborted, as a sentence; empty when all is well.
    since : float
        When the state was entered [s].
    """

    def __init__(self, config: NavigationConfig = NavigationConfig()) -> None:
        self.config = config
        self.state = NavigationState.IDLE
        self.goal: Optional[Pose] = None
        self.number = 0
        self.order: Optional[Order] = None
        self.reason = ""
        self.since = 0.0
        self._waiting_since: Optional[float] = None
        self._retry_at: Optional[float] = None  # when to ask the planner again; None: it has answered

    @property
    def active(self) -> bool:
        """Whether there is a goal that is not done with."""
        return self.state in _ACTIVE

    @property
    def wants_path(self) -> bool:
        """Whether the planner is to be asked."""
        return self.state is NavigationState.PLANNING

    def accept(self, goal: Pose, number: int, now: float) -> None:
        """Go to `goal`, whatever was before; `number` is greater than any before."""
        self.goal, self.number = goal, number
        self._waiting_since = None
        self._enter(NavigationState.PLANNING, now)

    def again(self, number: int, now: float) -> None:
        """Have the fleet asked anew for the same goal; nothing happens when there is none. Patience goes on."""
        if self.active and self.goal is not None:
            self.number = number
            self._enter(NavigationState.PLANNING, now, self.reason)

    def cancel(self, now: float, reason: str = "the goal was taken back") -> None:
        """Have no goal any more; nothing happens when there is none."""
        if self.active:
            self._end(NavigationState.CANCELED, now, reason)

    def planned(self, number: int, now: float) -> None:
        """There is a path for the goal `number`: the fleet is to make room for it."""
        if number == self.number and self.state is NavigationState.PLANNING:
            self.order = Order(number, self.goal)
            if self._retry_at is not None:  # the planner was waited for, not the fleet
                self._retry_at = self._waiting_since = None
            self._enter(NavigationState.COORDINATING, now)

    def refused(self, number: int, now: float, reason: str, *, final: bool) -> None:
        """There is no path for the goal `number`; `final`: and there will be none."""
        if number != self.number or self.state is not NavigationState.PLANNING:
            return
        if final:
            self._end(NavigationState.ABORTED, now, reason)
            return
        self._retry_at = now + self.config.retry_period
        self._wait(now, reason, self.config.patience)

    def hear(self, news: RobotNews, now: float) -> None:
        """Take in what the robot says."""
        if self._retry_at is not None:
            if self.state is NavigationState.WAITING and now >= self._retry_at:
                self._enter(NavigationState.PLANNING, now, self.reason)
        elif self.state in (NavigationState.COORDINATING, NavigationState.DRIVING, NavigationState.WAITING):
            self._follow(news, now)

    def _follow(self, news: RobotNews, now: float) -> None:
        assigned = news.assigned == self.number
        if assigned and news.reason:
            if news.final:
                self._end(NavigationState.ABORTED, now, news.reason)
            else:
                self._wait(now, news.reason, self.config.waiting_patience)
        elif assigned and news.arrived:
            self._enter(NavigationState.SUCCEEDED, now)
        elif news.trouble:
            self._wait(now, news.trouble, self.config.waiting_patience)
        elif assigned:
            self._waiting_since = None
            self._enter(NavigationState.DRIVING, now)
        elif self.state is not NavigationState.COORDINATING or now - self.since > self.config.patience:
            self._wait(now, "the fleet has not made room for it yet", self.config.waiting_patience)

    def _wait(self, now: float, reason: str, patience: float) -> None:
        """Wait for better times, but not for ever."""
        self._waiting_since = now if self._waiting_since is None else self._waiting_since
        if now - self._waiting_since >= patience:
            self._end(NavigationState.ABORTED, now, reason)
        else:
            self._enter(NavigationState.WAITING, now, reason)

    def _end(self, state: NavigationState, now: float, reason: str) -> None:
        """The goal is done with: the robot stays where it is."""
        if self.order is not None:
            self.order = Order(self.number, None)
        self._enter(state, now, reason)

    def _enter(self, state: NavigationState, now: float, reason: str = "") -> None:
        self.reason = reason
        if state is self.state and state is not NavigationState.PLANNING:
            return
        allowed = _NEXT.get(self.state, frozenset()) | {NavigationState.PLANNING}
        assert state in allowed, f"{self.state.name} is not followed by {state.name}"
        if state is not NavigationState.WAITING and state is not NavigationState.PLANNING:
            self._retry_at = None
        log.debug("%s after %s: %s", state.name, self.state.name, reason)
        self.state, self.since = state, now
