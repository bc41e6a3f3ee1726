"""What `coordinate` can be asked for: the choices, also for files and command line, and the ranges."""

import math
from numbers import Integral, Real

from social_fleet.errors import InvalidScenario

MODES = ("simultaneous", "sequential", "unified")
FORMULATIONS = ("exact", "paper")
OBJECTIVES = ("sum_of_completion", "makespan")
OUT_OF_TIME = "no schedule within the time limit; allow more time or send fewer robots at once"
"""What `TimedOut` says when the limit passed before there was any schedule."""


def check_options(*, mode: str, formulation: str, objective: str, effort: int, repairs: int, gap: float,
                  time_margin: float, tracking_tolerance: float, time_limit: float) -> None:
    """Raise InvalidScenario for an option out of its range."""
    for value, choices, field in ((mode, MODES, "mode"), (formulation, FORMULATIONS, "formulation"),
                                  (objective, OBJECTIVES, "objective")):
        if value not in choices:
            raise InvalidScenario(f"must be one of {', '.join(choices)}, not {value!r}", field=field)
    for count, field in ((effort, "effort"), (repairs, "repairs")):
        if isinstance(count, bool) or not isinstance(count, Integral) or count < 0:
            raise InvalidScenario(f"must be a whole number, zero or more, not {count!r}", field=field)
    for number, field in ((gap, "gap"), (time_margin, "time_margin"), (tracking_tolerance, "tracking_tolerance"),
                          (time_limit, "time_limit")):
        _check_number(number, field, positive=field == "time_limit")


def _check_number(number: float, field: str, *, positive: bool) -> None:
    if isinstance(number, bool) or not isinstance(number, Real):
        raise InvalidScenario(f"must be a number, not {number!r}", field=field)
    if not math.isfinite(number) or number < 0.0 or (positive and number == 0.0):
        raise InvalidScenario(f"must be {'positive' if positive else 'zero or more'}, not {number!r}", field=field)
