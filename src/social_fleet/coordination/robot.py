"""A robot as coordination, execution and simulation see it: a name, a path, a body and its limits."""

import math
from dataclasses import dataclass, field
from numbers import Real
from typing import Optional, Tuple, TypeVar, Union

import numpy as np

from social_fleet.errors import InvalidInput, InvalidScenario
from social_fleet.geometry import Polyline, Pose
from social_fleet.planning.plan import Plan


_MOST = 1000.0  # of any limit: beyond what drives, and within what times can be computed for


_Lengths = TypeVar("_Lengths", float, np.ndarray)


def safety_distance(radius: _Lengths, other_radius: _Lengths, tracking_tolerance: float) -> _Lengths:
    """Between two robots' centres, below which they count as in each other's way; for one pair or many [m]."""
    return radius + other_radius + 2.0 * tracking_tolerance


def _is_finite(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)


@dataclass(frozen=True)
class MotionLimits:
    """What a differential drive can do; all positive."""

    max_speed: float = 0.7  # [m/s]
    max_acceleration: float = 1.0  # [m/s^2]
    max_turn_rate: float = 1.5  # [rad/s]
    max_turn_acceleration: float = 3.0  # [rad/s^2]

    def __post_init__(self) -> None:
        for name in ("max_speed", "max_acceleration", "max_turn_rate", "max_turn_acceleration"):
            value = getattr(self, name)
            if not (_is_finite(value) and 0.0 < value <= _MOST):
                raise InvalidScenario(f"must be a positive number, at most {_MOST:g}, not {value!r}", field=name)


@dataclass(frozen=True)
class Robot:
    """One robot of a fleet with the path that it is to drive.

    Parameters
    ----------
    name : str
        Unique within the fleet.
    plan : Plan or (N, 2) array
        The path [m, map frame].
    max_speed : float
        Speed limit [m/s].
    radius : float, optional
        Radius of the body's disc [m]; the plan's by default.
    depart : float
        Earliest time of motion [s], on the fleet's common clock.
    weight : float
        Priority: what a second of its delay costs in the sum of completion, against 1 for others.
    start_yaw, goal_yaw : float, optional
        Headings at the ends [rad]; the plan's by default, None where any will do.
    max_acceleration, max_turn_rate, max_turn_acceleration : float
        [m/s^2], [rad/s], [rad/s^2].
    committed : float, optional
        Of a robot under way: the arc length up to which it may drive whatever is decided now, for others have left
        that stretch to it [m]; None for one that waits at its start for its schedule.

    Raises
    ------
    InvalidScenario
        When a value is not finite or out of range; the message names the robot.
    """

    name: str
    plan: Union[Plan, np.ndarray]
    max_speed: float = 0.7
    radius: Optional[float] = None
    depart: float = 0.0
    start_yaw: Optional[float] = None
    goal_yaw: Optional[float] = None
    max_acceleration: float = MotionLimits.max_acceleration
    max_turn_rate: float = MotionLimits.max_turn_rate
    max_turn_acceleration: float = MotionLimits.max_turn_acceleration
    weight: float = 1.0
    committed: Optional[float] = None
    path: Polyline = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise InvalidScenario("a robot needs a name", field="name")
        planned = isinstance(self.plan, Plan)
        points = self.plan.points if isinstance(self.plan, Plan) else self.plan
        try:
            self._set("path", Polyline(points))
        except InvalidInput as error:
            raise InvalidScenario(f"robot {self.name}: {error.message}", field="path") from error
        if self.radius is None:
            self._set("radius", self.plan.robot_radius if isinstance(self.plan, Plan) else 0.25)
        for end in ("start_yaw", "goal_yaw"):
            if getattr(self, end) is None and planned:
                self._set(end, getattr(self.plan, end))
            yaw = getattr(self, end)
            if yaw is not None and not _is_finite(yaw):
                raise InvalidScenario(f"robot {self.name}: must be finite, not {yaw!r}", field=end)
        if not (_is_finite(self.radius) and self.body_radius > 0.0):
            raise InvalidScenario(f"robot {self.name}: must be positive, not {self.radius!r}", field="radius")
        if not (_is_finite(self.weight) and self.weight > 0.0):
            raise InvalidScenario(f"robot {self.name}: must be positive, not {self.weight!r}", field="weight")
        if self.committed is not None and not (_is_finite(self.committed) and self.committed >= 0.0):
            raise InvalidScenario(f"robot {self.name}: must not be negative, not {self.committed!r}", field="committed")
        if not (_is_finite(self.depart) and self.depart >= 0.0):
            raise InvalidScenario(f"robot {self.name}: must not be negative, not {self.depart!r}",
                                  field="depart")
        try:
            self.limits  # its values check themselves
        except InvalidScenario as error:
            raise InvalidScenario(f"robot {self.name}: {error.message}", field=error.field) from error

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    @property
    def limits(self) -> MotionLimits:
        """The motion limits as one value."""
        return MotionLimits(self.max_speed, self.max_acceleration, self.max_turn_rate,
                            self.max_turn_acceleration)

    @property
    def body_radius(self) -> float:
        """`radius`, never None [m]."""
        assert self.radius is not None
        return self.radius

    @property
    def stops(self) -> Tuple[float, ...]:
        """Arc lengths [m] of places on the way that are meant for letting others pass."""
        return self.plan.stops if isinstance(self.plan, Plan) else ()

    @property
    def start(self) -> Pose:
        """Pose before departure; without a given heading, the path's."""
        x, y = self.path.points[0]
        return Pose(float(x), float(y), self.path.heading(0.0) if self.start_yaw is None else self.start_yaw)

    @property
    def goal(self) -> Pose:
        """Pose after arrival; without a given heading, the path's."""
        x, y = self.path.points[-1]
        yaw = self.path.heading(self.path.length) if self.goal_yaw is None else self.goal_yaw
        return Pose(float(x), float(y), yaw)
