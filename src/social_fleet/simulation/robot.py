"""A differential-drive robot as a fleet simulation needs it: kinematics, limits, odometry."""

import math
import random
from typing import Tuple

from social_fleet.coordination.robot import MotionLimits
from social_fleet.geometry import Pose, wrap_angle


class DifferentialDriveRobot:
    """Moves along exact arcs at the commanded velocity, as far as its drive can follow.

    A change of speed or turn rate happens at the beginning of a step and is at most the acceleration limit times the
    step's duration.

    Parameters
    ----------
    name : str
        The robot's name.
    pose : Pose
        Where it stands at first [m, rad, map frame].
    radius : float
        Of its disc [m].
    limits : MotionLimits
        Of speed, turn rate and their accelerations.
    odometry_noise : float
        Standard deviation of the odometry's relative error, of distance and angle alike, drawn anew every step.
    seed : int
        Of that noise.
    command_timeout : float
        Without a new command for so long it brakes to a stop [s].

    Attributes
    ----------
    pose : Pose
        The true pose [m, rad, map frame].
    odometry : Pose
        The pose by dead reckoning since the beginning [m, rad, odom frame].
    speed, turn_rate : float
        True velocities [m/s, rad/s].
    speed_share : float
        Share of the commanded speed and turn rate that the drive yields: 1 when sound, 0 when stuck.
    """

    def __init__(self, name: str, pose: Pose, *, radius: float = 0.25, limits: MotionLimits = MotionLimits(),
                 odometry_noise: float = 0.0, seed: int = 0, command_timeout: float = math.inf) -> None:
        self.name = name
        self.pose = pose
        self.radius = radius
        self.limits = limits
        self.odometry = Pose(0.0, 0.0, 0.0)
        self.speed = 0.0
        self.turn_rate = 0.0
        self.speed_share = 1.0
        self._noise = odometry_noise
        self._random = random.Random(f"{seed}/{name}")
        self._command: Tuple[float, float] = (0.0, 0.0)
        self._command_timeout = command_timeout
        self._command_age = 0.0

    def command(self, speed: float, turn_rate: float) -> None:
        """Take a velocity [m/s, rad/s] to strive for from the next step on."""
        self._command = (speed, turn_rate)
        self._command_age = 0.0

    def step(self, period: float) -> None:
        """Move for `period` seconds."""
        limits = self.limits
        if self._command_age > self._command_timeout - 0.5 * period:  # ages are sums of rounded periods
            self._command = (0.0, 0.0)
        self._command_age += period
        speed, turn_rate = self._command
        if speed == turn_rate == self.speed == self.turn_rate == 0.0:
            return
        self.speed = _towards(self.speed, speed * self.speed_share, limits.max_speed,
                              limits.max_acceleration * period)
        self.turn_rate = _towards(self.turn_rate, turn_rate * self.speed_share, limits.max_turn_rate,
                                  limits.max_turn_acceleration * period)
        distance, angle = self.speed * period, self.turn_rate * period
        self.pose = along_arc(self.pose, distance, angle)
        if self._noise > 0.0:
            distance *= 1.0 + self._random.gauss(0.0, self._noise)
            angle *= 1.0 + self._random.gauss(0.0, self._noise)
        self.odometry = along_arc(self.odometry, distance, angle)


def along_arc(pose: Pose, distance: float, angle: float) -> Pose:
    """The pose after driving `distance` [m] while turning evenly by `angle` [rad]."""
    half = 0.5 * angle
    chord = distance * (math.sin(half) / half) if abs(half) > 1e-6 else distance
    return Pose(pose.x + chord * math.cos(pose.yaw + half), pose.y + chord * math.sin(pose.yaw + half),
                wrap_angle(pose.yaw + angle))


def _towards(value: float, target: float, limit: float, largest_step: float) -> float:
    target = min(max(target, -limit), limit)
    return min(max(target, value - largest_step), value + largest_step)
