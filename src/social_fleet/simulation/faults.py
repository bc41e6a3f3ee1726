"""What may go wrong in a simulated run."""

import math
from dataclasses import dataclass
from typing import Iterable, Sequence, Tuple

from social_fleet.errors import InvalidScenario

FAULT_KINDS = ("pause", "slow", "lost", "jump", "drift", "silent", "restart", "dead", "errand", "join")
LASTING = ("dead", "errand", "join")
"""Those that do not come to an end."""

DISPATCHER = "dispatcher"
"""Whom a fault may befall besides robots."""


@dataclass(frozen=True)
class Fault:
    """Something that befalls one robot.

    ``pause`` makes it stand for `duration`; ``slow`` lets it drive at `factor` of its commanded velocity; ``lost``
    leaves it without a pose; ``jump`` shifts its pose by `distance` towards `direction`, and ``drift`` does so slowly,
    and back in the second half of its `duration`; ``silent`` cuts it off from all others; ``restart`` ends its program,
    which starts anew after `duration` knowing nothing; ``dead`` ends it for good. ``errand`` gives it another `goal`
    and ``join`` starts its program at `at`; both last for ever. The dispatcher can be ``silent`` and ``restart``.

    Parameters
    ----------
    robot : str
        The robot's name, or ``dispatcher``.
    kind : str
        One of `FAULT_KINDS`.
    at : float
        When it begins [s].
    duration : float
        How long it lasts [s].
    factor : float
        Of a slow robot, in (0, 1].
    distance, direction : float
        Of a jump or a drift [m], [rad, map frame].
    goal : tuple of float
        Of an errand: (x, y) or (x, y, yaw) [m, rad, map frame].

    Raises
    ------
    InvalidScenario
        When a value is out of its range.
    """

    robot: str
    kind: str
    at: float
    duration: float = math.inf
    factor: float = 0.5
    distance: float = 0.5
    direction: float = 0.0
    goal: Tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if self.kind not in FAULT_KINDS:
            raise InvalidScenario(f"must be one of {', '.join(FAULT_KINDS)}, not {self.kind!r}", field="kind")
        if self.robot == DISPATCHER and self.kind not in ("silent", "restart"):
            raise InvalidScenario(f"the dispatcher can be silent or restart, not {self.kind!r}", field="kind")
        if not (math.isfinite(self.at) and self.at >= 0.0):
            raise InvalidScenario(f"must be a time that is not negative, not {self.at!r}", field="at")
        if not (self.duration >= 0.0 and (math.isfinite(self.duration) or self.kind in LASTING)):
            raise InvalidScenario(f"must be a time that is not negative, not {self.duration!r}", field="duration")
        if not 0.0 < self.factor <= 1.0:
            raise InvalidScenario(f"must be greater than 0 and at most 1, not {self.factor!r}", field="factor")
        if not (math.isfinite(self.distance) and math.isfinite(self.direction)):
            raise InvalidScenario(f"must be finite, not {(self.distance, self.direction)!r}", field="distance")
        if (self.kind == "errand") != bool(self.goal):
            raise InvalidScenario("an errand, and nothing else, needs a goal", field="goal")

    def active(self, now: float) -> bool:
        """Whether it is in force at `now` [s]."""
        return self.at <= now < self.at + self.duration


def pose_shift(fault: Fault, now: float) -> Tuple[float, float]:
    """By how much a jump or a drift shifts a pose at `now` [m, map frame]."""
    if not fault.active(now) or fault.kind not in ("jump", "drift"):
        return 0.0, 0.0
    share = 1.0 if fault.kind == "jump" else 1.0 - abs(2.0 * (now - fault.at) / fault.duration - 1.0)
    return (share * fault.distance * math.cos(fault.direction), share * fault.distance * math.sin(fault.direction))


def speed_share(faults: Sequence[Fault], robot: str, now: float) -> float:
    """Share of the commanded velocity that `robot` drives at `now` [s]: 0 while it is paused."""
    share = 1.0
    for fault in faults:
        if fault.robot == robot and fault.kind in ("pause", "slow") and fault.active(now):
            share = min(share, 0.0 if fault.kind == "pause" else fault.factor)
    return share


def active(faults: Iterable[Fault], now: float, *kinds: str) -> bool:
    """Whether any of `faults` of these kinds is in force at `now` [s]."""
    return any(fault.kind in kinds and fault.active(now) for fault in faults)


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
