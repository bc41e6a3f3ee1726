"""The exception tree of social_fleet: one class per meaning, so that a caller can act on the type alone.

Messages are whole sentences that name the robot, the place or the field, and the remedy.
"""

from typing import Sequence, Tuple


class SocialFleetError(Exception):
    """Whatever social_fleet raises on purpose."""


class InvalidInput(SocialFleetError, ValueError):
    """Something that was given is wrong; the caller has to change it.

    Parameters
    ----------
    message
        What is wrong and what would be right.
    source, field
        The file (or message) and the field that hold the value, when known.
    """

    def __init__(self, message: str, *, source: str = "", field: str = "") -> None:
        self.source = source
        self.field = field
        self.message = message
        super().__init__(": ".join(part for part in (source, field, message) if part))


class InvalidMap(InvalidInput):
    """A map file or an occupancy grid that cannot be used."""


class InvalidPose(InvalidInput):
    """A start or goal where the robot cannot stand: not finite, off the map, blocked or too close to a wall."""


class InvalidStart(InvalidPose):
    """The start of a plan is unusable."""


class InvalidGoal(InvalidPose):
    """The goal of a plan is unusable."""


class InvalidParameter(InvalidInput):
    """A configuration value of the wrong type or out of its range."""


class InvalidGraph(InvalidInput):
    """A social graph file that is cut short, of another version, or learnt on another map."""


class InvalidOverlay(InvalidInput):
    """An obstacle that is no shape, or that lies off the map."""


class InvalidScenario(InvalidInput):
    """A scenario file, a fleet or a request that contradicts itself or lacks a value."""


class InvalidSchedule(InvalidInput):
    """A schedule whose arrays do not fit together or whose times fall."""


class InvalidMessage(InvalidInput):
    """What came from another robot is cut short, of another version, or contradicts itself."""


class NoPath(SocialFleetError):
    """Start and goal are fine, but no path joins them."""


class Infeasible(SocialFleetError):
    """No schedule exists on the given paths.

    Parameters
    ----------
    message
        The contradiction as a sentence.
    robots
        Names of the robots that contradict each other.
    pairs
        Pairs of names whose encounters form the contradiction.
    """

    def __init__(self, message: str, *, robots: Sequence[str] = (),
                 pairs: Sequence[Tuple[str, str]] = ()) -> None:
        self.robots = tuple(robots)
        self.pairs = tuple(pairs)
        super().__init__(message)


class TimedOut(SocialFleetError):
    """A time limit passed before there was any answer."""


class SilentRobot(TimedOut):
    """Robots that a coordination waited for said nothing within the limit.

    Parameters
    ----------
    message
        Who, and what was missing, as a sentence.
    robots
        Their names.
    """

    def __init__(self, message: str, *, robots: Sequence[str]) -> None:
        self.robots = tuple(robots)
        super().__init__(message)


class Disagreement(SocialFleetError):
    """Robots that were to find the same schedule did not: none of them may be driven.

    Parameters
    ----------
    message
        Who, and how they differ, as a sentence.
    robots
        Names of those that differ.
    """

    def __init__(self, message: str, *, robots: Sequence[str]) -> None:
        self.robots = tuple(robots)
        super().__init__(message)


class SolverFailed(SocialFleetError):
    """The optimisation solver ended in a state that is neither an answer nor a proof that there is none."""


class NotReady(SocialFleetError):
    """A request came before what it needs (a map, a transform, a pose)."""
