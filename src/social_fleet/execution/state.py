"""What a tracker says of itself, and what it commands."""

from enum import IntEnum
from typing import NamedTuple


class ProgressState(IntEnum):
    """The states of a robot under way, numbered as in the Progress message."""

    IDLE = 0  # no schedule, or not yet time to depart
    TURNING = 1  # turning in place
    DRIVING = 2  # following the reference, which may stand where the schedule says so
    HOLDING = 3  # standing because another robot has not passed yet
    ARRIVED = 4  # at the goal, for ever
    STOPPED = 5  # standing, or braking, because something is wrong


class Command(NamedTuple):
    """A velocity command."""

    speed: float  # [m/s], never negative
    turn_rate: float  # [rad/s], counter-clockwise


STANDSTILL = Command(0.0, 0.0)
