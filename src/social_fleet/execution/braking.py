"""Speeds from which a stop is still possible, for motion in steps of constant speed."""

import math


def stopping_speed(distance: float, deceleration: float, period: float) -> float:
    """The highest speed for the next period from which a stop within `distance` stays possible.

    Valid for lengths as for angles. A robot that slows by ``deceleration * period`` every period covers
    ``v**2 / (2 deceleration) + v period / 2`` until it stands, the next period at `v` included.

    Parameters
    ----------
    distance : float
        Room that is left [m or rad].
    deceleration : float
        [m/s^2 or rad/s^2].
    period : float
        Duration of a step [s].
    """
    if distance <= 0.0:
        return 0.0
    half = 0.5 * period
    speed = deceleration * (math.sqrt(half * half + 2.0 * distance / deceleration) - half)
    return min(speed, distance / period)


def approach(value: float, target: float, largest_step: float) -> float:
    """`target`, or as far towards it from `value` as one step may go."""
    if target > value + largest_step:
        return value + largest_step
    if target < value - largest_step:
        return value - largest_step
    return target
