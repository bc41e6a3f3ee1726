"""The simulation's parameters."""

import math
from dataclasses import dataclass

from social_fleet.errors import InvalidParameter
from social_fleet.parameters import Parameters, parameter


@dataclass(frozen=True)
class LidarConfig(Parameters):
    """A planar lidar: as many beams as fit from `angle_min` to `angle_max`.

    Raises
    ------
    InvalidParameter
        When a value is of a wrong type or out of range; `field` names it.
    """

    range_min: float = parameter(0.05, minimum=0.0)  # [m]
    range_max: float = parameter(10.0, above=0.0)  # [m]
    angle_min: float = parameter(-math.pi)  # of the first beam, in the robot's frame [rad]
    angle_max: float = parameter(math.pi)  # [rad]
    angle_increment: float = parameter(math.radians(1.0), above=0.0)  # [rad]
    noise: float = parameter(0.0, minimum=0.0)  # standard deviation of a range [m]

    def __post_init__(self) -> None:
        super().__post_init__()
        for low, high in (("range_min", "range_max"), ("angle_min", "angle_max")):
            if getattr(self, high) <= getattr(self, low):
                raise InvalidParameter(f"must be greater than {low} ({getattr(self, low):g}), not "
                                       f"{getattr(self, high):g}", field=high)


@dataclass(frozen=True)
class SimulationConfig(Parameters):
    """The simulated robots and their clock; config/fake_robots.yaml says when to change what.

    Raises
    ------
    InvalidParameter
        When a value is of a wrong type or out of range; `field` names it.
    """

    period: float = parameter(0.05, above=0.0, maximum=0.5)  # of the simulation's steps [s]
    command_timeout: float = parameter(0.5, above=0.0)  # without a new command for so long a robot brakes [s]
    odometry_noise: float = parameter(0.0, minimum=0.0, maximum=0.5)  # relative, of distance and angle [-]
    position_error: float = parameter(0.0, minimum=0.0)  # bound of localisation's error [m]
    heading_error: float = parameter(0.0, minimum=0.0)  # [rad]
    seed: int = parameter(0, minimum=0)  # of all noise
    deadline_factor: float = parameter(3.0, minimum=1.0)  # a run is given up after this many makespans ...
    deadline_extra: float = parameter(60.0, minimum=0.0)  # ... and so much more [s]
