"""What may go wrong in a simulated run."""

import math
from dataclasses import dataclass
from typing import Sequence

from social_fleet.errors import InvalidScenario

FAULT_KINDS = ("pause", "slow")


@dataclass(frozen=True)
class Fault:
    """Something that befalls one robot.

    ``pause`` makes it stand for `duration`; ``slow`` lets it drive at `factor` of its commanded velocity.

    Parameters
    ----------
    robot : str
        The robot's name.
    kind : str
        One of `FAULT_KINDS`.
    at : float
        When it begins [s].
    duration : float
        How long it lasts [s].
    factor : float
        Of a slow robot, in (0, 1].

    Raises
    ------
    InvalidScenario
        When a value is out of its range.
    """

    robot: str
    kind: str
    at: float
    duration: float
    factor: float = 0.5

    def __post_init__(self) -> None:
        if self.kind not in FAULT_KINDS:
            raise InvalidScenario(f"must be one of {', '.join(FAULT_KINDS)}, not {self.kind!r}", field="kind")
        for name in ("at", "duration"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise InvalidScenario(f"must be a time that is not negative, not {value!r}", field=name)
        if not 0.0 < self.factor <= 1.0:
            raise InvalidScenario(f"must be greater than 0 and at most 1, not {self.factor!r}", field="factor")

    def active(self, now: float) -> bool:
        """Whether it is in force at `now` [s]."""
        return self.at <= now < self.at + self.duration


def speed_share(faults: Sequence[Fault], robot: str, now: float) -> float:
    """Share of the commanded velocity that `robot` drives at `now` [s]: 0 while it is paused."""
    share = 1.0
    for fault in faults:
        if fault.robot == robot and fault.active(now):
            share = min(share, 0.0 if fault.kind == "pause" else fault.factor)
    return share


@dataclass(frozen=True)
class CircleObstacle:
    """A disc that stands in the way for a while, unknown to the map.

    Raises
    ------
    InvalidScenario
        When a value is out of its range.
    """

    x: float  # [m, map frame]
    y: float
    radius: float  # [m]
    appears: float = 0.0  # [s]
    disappears: float = math.inf  # [s]

    def __post_init__(self) -> None:
        if not (math.isfinite(self.x) and math.isfinite(self.y)):
            raise InvalidScenario(f"must be finite, not {(self.x, self.y)!r}", field="center")
        if not (math.isfinite(self.radius) and self.radius > 0.0):
            raise InvalidScenario(f"must be positive, not {self.radius!r}", field="radius")
        if not self.disappears > self.appears:
            raise InvalidScenario(f"must be later than it appears ({self.appears!r}), not {self.disappears!r}",
                                  field="disappears")

    def present(self, now: float) -> bool:
        """Whether it is there at `now` [s]."""
        return self.appears <= now < self.disappears
