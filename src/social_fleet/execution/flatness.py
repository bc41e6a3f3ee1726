"""Trajectory tracking for a differential drive by differential flatness.

The position (x, y) is a flat output of the unicycle: from its trajectory and two derivatives follow heading, speed and
turn rate. Dynamic feedback linearisation makes the error dynamics of x and y linear,

    u = p''_ref + k_v (p'_ref - p') + k_p (p_ref - p),
    speed' = u . (cos, sin),    turn rate = u . (-sin, cos) / speed,

with the speed as the compensator's state. It is singular at standstill, where the heading does not follow from the
flat output; there the Lyapunov-based law of the same paper takes over, which divides by nothing. Between, both are
blended.

References
----------
G. Oriolo, A. De Luca, M. Vendittelli: WMR control via dynamic feedback linearization: design, implementation, and
experimental validation. IEEE Transactions on Control Systems Technology 10(6), 2002, Eqs. 10-16 and III-B.
doi:10.1109/TCST.2002.804116
"""

import math
from typing import NamedTuple, Tuple

from social_fleet.execution.config import TrackerConfig
from social_fleet.geometry import Pose, wrap_angle


class ReferenceMotion(NamedTuple):
    """The reference over one period."""

    x: float  # position at its beginning [m]
    y: float
    yaw: float  # heading at its beginning [rad]
    last_speed: float  # in the period before [m/s]
    speed: float  # in this period [m/s]
    turn_rate: float  # in this period [rad/s]


def track(pose: Pose, speed: float, reference: ReferenceMotion, period: float,
          config: TrackerConfig) -> Tuple[float, float]:
    """The speed [m/s] and turn rate [rad/s] for the next period, before any limit.

    Parameters
    ----------
    pose : Pose
        Where the robot is [m, rad, map frame].
    speed : float
        Its present speed [m/s].
    period : float
        How long the command will be held [s].
    """
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    error_x, error_y = reference.x - pose.x, reference.y - pose.y
    along, across = cos * error_x + sin * error_y, cos * error_y - sin * error_x
    turn = wrap_angle(reference.yaw - pose.yaw)
    share = min(max(2.0 * speed / config.flatness_speed - 1.0, 0.0), 1.0)
    linear, angular = 0.0, 0.0
    if share > 0.0:
        linear, angular = _linearising(along, across, turn, speed, reference, period, config)
    if share < 1.0:
        slow_linear, slow_angular = _near_standstill(along, across, turn, reference, config)
        linear = share * linear + (1.0 - share) * slow_linear
        angular = share * angular + (1.0 - share) * slow_angular
    return linear, angular


def _linearising(along: float, across: float, turn: float, speed: float, reference: ReferenceMotion, period: float,
                 config: TrackerConfig) -> Tuple[float, float]:
    """Dynamic feedback linearisation, all vectors in the robot's frame; `speed` must not be near 0."""
    cos, sin = math.cos(turn), math.sin(turn)
    push = (reference.speed - reference.last_speed) / period
    swing = reference.speed * reference.turn_rate
    forward = (cos * push - sin * swing + config.velocity_gain * (reference.last_speed * cos - speed)
               + config.position_gain * along)
    sideways = (sin * push + cos * swing + config.velocity_gain * reference.last_speed * sin
                + config.position_gain * across)
    return speed + forward * period, sideways / speed


def _near_standstill(along: float, across: float, turn: float, reference: ReferenceMotion,
                     config: TrackerConfig) -> Tuple[float, float]:
    """The nonlinear design of III-B (after Samson), defined at any speed."""
    cardinal_sine = math.sin(turn) / turn if abs(turn) > 1e-6 else 1.0
    linear = reference.speed * math.cos(turn) + config.along_gain * along
    stiffness = config.across_gain
    heading_gain = 2.0 * config.damping * math.sqrt(reference.turn_rate ** 2 + stiffness * reference.speed ** 2)
    angular = reference.turn_rate + stiffness * reference.speed * cardinal_sine * across + heading_gain * turn
    return linear, angular
