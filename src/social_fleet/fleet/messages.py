"""What robots tell each other while they coordinate; `encoding` turns it into bytes and back."""

import hashlib
import json
import math
from dataclasses import astuple, dataclass
from typing import Optional, Tuple, Union

from social_fleet.coordination.encounters import Encounter
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import Schedule
from social_fleet.errors import InvalidScenario


@dataclass(frozen=True)
class Round:
    """One coordination, as all who take part in it know it beforehand.

    Attributes
    ----------
    version : int
        Stamped on the schedules; another one for every round.
    planning, fixed : tuple of str
        Names of the robots to schedule, and of those whose schedules are under way. No `fixed` is the simultaneous
        scenario of 3.3.3; one of `planning` and some `fixed` the sequential; several of both the unified.
    time_margin, tracking_tolerance, repairs
        As `coordinate` takes them: [s], [m].

    Raises
    ------
    InvalidScenario
        When nobody plans, a name comes twice, or a number is out of range.
    """

    version: int
    planning: Tuple[str, ...]
    fixed: Tuple[str, ...] = ()
    time_margin: float = 1.0
    tracking_tolerance: float = 0.1
    repairs: int = 50

    def __post_init__(self) -> None:
        for name in ("planning", "fixed"):
            object.__setattr__(self, name, tuple(sorted(getattr(self, name))))
        if not self.planning:
            raise InvalidScenario("there is no robot to coordinate", field="planning")
        for name in self.robots:
            if self.robots.count(name) > 1:
                raise InvalidScenario(f"two robots are named {name}; names must differ", field="planning, fixed")
        for name in ("time_margin", "tracking_tolerance", "repairs"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise InvalidScenario(f"must be zero or more, not {value!r}", field=name)
        for name in ("time_margin", "tracking_tolerance"):
            object.__setattr__(self, name, float(getattr(self, name)))  # 1 and 1.0 are one key

    @property
    def robots(self) -> Tuple[str, ...]:
        """All names, in the coordinator's order."""
        return self.planning + self.fixed

    @property
    def key(self) -> str:
        """What its messages are known by: differs when anything differs that the schedules depend on."""
        return digest(json.dumps(astuple(self)).encode())


@dataclass(frozen=True)
class Announcement:
    """A robot's path and limits; with its schedule, on the fleet's clock, when that is under way."""

    round: str
    robot: Robot
    schedule: Optional[Schedule] = None

    @property
    def sender(self) -> str:
        """Name of the robot that says so."""
        return self.robot.name


@dataclass(frozen=True)
class PairWindows:
    """The windows of two robots, as robots 0 and 1, on the paths of two announcements, given by their digests."""

    r: str
    s: str
    r_path: str
    s_path: str
    windows: Tuple[Encounter, ...]


@dataclass(frozen=True)
class Findings:
    """The windows of all pairs that a robot had to search."""

    round: str
    sender: str
    pairs: Tuple[PairWindows, ...]


@dataclass(frozen=True)
class Verdict:
    """What a robot's program gave: the digest of the fleet's schedule, or why there is none."""

    round: str
    sender: str
    schedule: str
    reason: str = ""


Message = Union[Announcement, Findings, Verdict]


def digest(content: bytes) -> str:
    """A fingerprint: equal for equal bytes, and in practice only for those."""
    return hashlib.sha256(content).hexdigest()[:32]
