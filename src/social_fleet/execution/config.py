"""The tracker's parameters."""

from dataclasses import dataclass

from social_fleet.errors import InvalidParameter
from social_fleet.parameters import Parameters, parameter


@dataclass(frozen=True)
class TrackerConfig(Parameters):
    """Gains, tolerances and limits of a `Tracker`; config/tracker.yaml says when to change them.

    Raises
    ------
    InvalidParameter
        When a value is of a wrong type or out of range; `field` names it.
    """

    period: float = parameter(0.05, above=0.0, maximum=0.5)  # control period [s]
    position_gain: float = parameter(4.0, above=0.0)  # flatness law [1/s^2]
    velocity_gain: float = parameter(4.0, above=0.0)  # flatness law [1/s]
    along_gain: float = parameter(1.5, above=0.0)  # law near standstill [1/s]
    across_gain: float = parameter(20.0, above=0.0)  # law near standstill [1/m^2]
    damping: float = parameter(0.8, above=0.0)  # law near standstill, of the way back to the path [-]
    flatness_speed: float = parameter(0.2, above=0.0)  # the flatness law alone from here on, blended below [m/s]
    position_tolerance: float = parameter(0.05, above=0.0)  # at the goal [m]
    heading_tolerance: float = parameter(0.1, above=0.0)  # at the goal [rad]
    deviation_limit: float = parameter(0.3, above=0.0)  # behind the reference, beyond which it stops [m]
    lateral_limit: float = parameter(0.075, above=0.0)  # off the way that others leave it, beyond which it stops [m]
    lag_begin: float = parameter(0.03, minimum=0.0)  # the reference slows when the robot is this far behind [m]
    lag_end: float = parameter(0.10, above=0.0)  # and stands when it is this far behind [m]
    pose_timeout: float = parameter(0.5, above=0.0)  # age at which a pose is no news [s]
    pose_jump: float = parameter(0.15, above=0.0)  # a pose that moves by more than the robot can and this, jumps [m]
    pose_settle: float = parameter(10.0, minimum=0.0)  # for how long poses must hang together elsewhere then [s]
    standoff: float = parameter(0.02, minimum=0.0)  # how far before a gate to stand [m]
    release_tolerance: float = parameter(0.03, minimum=0.0)  # how far short of a gate's release counts as passed [m]

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.lag_end <= self.lag_begin:
            raise InvalidParameter(f"must be greater than lag_begin ({self.lag_begin:g}), not {self.lag_end:g}",
                                   field="lag_end")
        if self.deviation_limit < 2.0 * self.lateral_limit:
            raise InvalidParameter(f"must be at least twice lateral_limit ({self.lateral_limit:g}), or no robot finds "
                                   f"back to its path, not {self.deviation_limit:g}", field="deviation_limit")
        if self.release_tolerance < self.standoff:
            raise InvalidParameter(f"must be at least standoff ({self.standoff:g}), or two robots may wait for each "
                                   f"other for ever, not {self.release_tolerance:g}", field="release_tolerance")
