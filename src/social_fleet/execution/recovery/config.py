"""Parameters of promises, delays and replans."""

from dataclasses import dataclass

from social_fleet.errors import InvalidParameter
from social_fleet.parameters import Parameters, parameter


@dataclass(frozen=True)
class RecoveryConfig(Parameters):
    """When robots and dispatcher act, and on what; config/recovery.yaml says when to change them.

    Raises
    ------
    InvalidParameter
        When a value is of a wrong type or out of range; `field` names it.
    """

    beat: float = parameter(0.5, above=0.0)  # the dispatcher says everything again after so long [s]
    lapse: float = parameter(6.0, above=0.0)  # a robot that was not heard for so long stands, by what it is told [s]
    gone: float = parameter(10.0, above=0.0)  # a robot that was silent for so long stands, and is planned round [s]
    lookahead: float = parameter(2.5, minimum=0.0)  # a promise leaves so much driving beyond the braking distance [s]
    late: float = parameter(5.0, above=0.0)  # delay at which a robot counts as late [s]
    recovered: float = parameter(2.0, minimum=0.0)  # delay below which it no longer does [s]
    patience: float = parameter(10.0, minimum=0.0)  # between two replans for the same robot's delay, at first [s]
    obstacle_patience: float = parameter(8.0, minimum=0.0)  # an obstacle is waited for so long before a detour [s]
    stuck: float = parameter(75.0, above=0.0)  # a robot that could move and did not for so long is planned round [s]
    astray: float = parameter(5.0, minimum=0.0)  # a robot off its path waits so long before it asks for another [s]
    retry: float = parameter(10.0, above=0.0)  # for robots that could not be served [s]
    give_up: float = parameter(120.0, above=0.0)  # a goal that cannot be reached for so long is given up [s]

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.gone <= self.lapse:
            raise InvalidParameter(f"must be greater than lapse ({self.lapse:g}): the robot must stand by then, not "
                                   f"{self.gone:g}", field="gone")
        if self.recovered >= self.late:
            raise InvalidParameter(f"must be less than late ({self.late:g}), not {self.recovered:g}",
                                   field="recovered")
