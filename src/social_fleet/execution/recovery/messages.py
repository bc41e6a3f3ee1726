"""What robots and dispatcher say to each other. Every message may be lost, late, repeated or overtaken by another."""

from dataclasses import dataclass, field
from typing import Mapping, Optional, Tuple

from social_fleet.coordination.robot import MotionLimits
from social_fleet.coordination.schedule import Schedule
from social_fleet.execution.gate import Waiting
from social_fleet.execution.state import ProgressState
from social_fleet.geometry import Pose
from social_fleet.planning.overlays.shapes import DiscObstacle


@dataclass(frozen=True)
class Body:
    """What a robot is: its disc, its limits, and what a second of its delay costs."""

    radius: float = 0.25  # [m]
    limits: MotionLimits = MotionLimits()
    weight: float = 1.0


@dataclass(frozen=True)
class Errand:
    """Where a robot is to go: (x, y) or (x, y, yaw) [m, rad, map frame], numbered so that a later one is known."""

    number: int
    goal: Tuple[float, ...]


@dataclass(frozen=True)
class Report:
    """What a robot says of itself, to all, several times a second.

    Attributes
    ----------
    name, body
        Who it is.
    session : int
        Differs whenever the robot's program has started anew; later ones are greater.
    stamp : float
        When all this was so, on the fleet's clock [s].
    version : int
        Of the schedule that it follows; 0 without one.
    arc_length, speed : float
        Measured progress along that schedule's path [m], and speed [m/s].
    pose : Pose, optional
        Where it is [m, rad, map frame]; None when it does not know.
    exchange : int
        The latest exchange of schedules that it has given a promise for; 0: none.
    bound : float
        Its promise: the arc length that it does not pass before it gets a later schedule [m]; infinite without one.
    lapsed : bool
        It has not heard of the dispatcher for so long that it stands until it gets a later schedule.
    astray : bool
        It stands off its path, and needs one that begins where it is.
    errand : Errand, optional
        What it is to do; None: stay where it is.
    serving : int
        Number of the errand that its schedule serves; 0 for none.
    unserved : str
        Why its schedule does not lead to the goal of that errand; empty when it does.
    final : bool
        It has given that errand up.
    obstacles : mapping of str to DiscObstacle
        What it has seen and the map does not hold, by names that are its own.
    cleared : tuple of str
        Obstacles of any robot that it sees to be gone.
    blocked : float
        For how long something in its way has kept it standing [s]; 0 when nothing does.
    waiting_for : Waiting, optional
        Whom it waits for at its gate.
    schedule : Schedule, optional
        What it follows: for a dispatcher that has just started.
    """

    name: str
    session: int
    stamp: float
    body: Body = Body()
    version: int = 0
    arc_length: float = 0.0
    speed: float = 0.0
    state: ProgressState = ProgressState.IDLE
    pose: Optional[Pose] = None
    exchange: int = 0
    bound: float = float("inf")
    lapsed: bool = False
    astray: bool = False
    errand: Optional[Errand] = None
    serving: int = 0
    unserved: str = ""
    final: bool = False
    obstacles: Mapping[str, DiscObstacle] = field(default_factory=dict)
    cleared: Tuple[str, ...] = ()
    blocked: float = 0.0
    waiting_for: Optional[Waiting] = None
    schedule: Optional[Schedule] = None

    @property
    def age(self) -> Tuple[int, float]:
        """Of two reports of a robot, the later one has the greater."""
        return self.session, self.stamp


@dataclass(frozen=True)
class Assignment:
    """A schedule for one robot, made from its promise.

    Attributes
    ----------
    session : int
        The robot's; a robot that has started anew since does not take it up.
    schedule : Schedule
        Its version is the exchange's number.
    origin : float
        Where on the path that the robot has followed the new one begins [m].
    errand : int
        Number of the errand that it serves; 0 for none.
    reason : str
        Why the robot is not led to its goal, as a sentence; empty when it is.
    final : bool
        With a reason: there is no use in waiting.
    temporary : bool
        The path is a detour round an obstacle that is not in the map.
    """

    session: int
    schedule: Schedule
    origin: float = 0.0
    errand: int = 0
    reason: str = ""
    final: bool = False
    temporary: bool = False


@dataclass(frozen=True)
class Directive:
    """What the dispatcher says, to all, again and again.

    Attributes
    ----------
    stamp : float
        When it was said [s].
    heard : mapping of str to float
        The stamp of the latest report of every robot that was heard of [s].
    exchange : int
        Number of the exchange that is open or in force; robots give a promise for one that is new to them.
    assignments : mapping of str to Assignment
        For robots that have not confirmed theirs yet.
    obstacles : mapping of str to DiscObstacle
        What all robots have seen, for those that can see whether it is still there.
    missing : tuple of str
        Robots that schedules name and that were never heard of, since the dispatcher started anew: who has heard of
        one passes on its latest report.
    """

    stamp: float
    heard: Mapping[str, float]
    exchange: int = 0
    assignments: Mapping[str, Assignment] = field(default_factory=dict)
    obstacles: Mapping[str, DiscObstacle] = field(default_factory=dict)
    missing: Tuple[str, ...] = ()
