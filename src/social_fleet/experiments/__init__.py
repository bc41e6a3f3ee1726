"""The paper's tables and figures again, on its environments and on any other map; see doc/experiments.md."""

from importlib import import_module
from typing import TYPE_CHECKING

from social_fleet.errors import InvalidParameter

if TYPE_CHECKING:
    from social_fleet.experiments.frame import Experiment

# Name on the command line, its module and class. What is listed here is offered there.
EXPERIMENTS = {
    "table2": ("table2", "Table2"),
    "fig6": ("fig6", "Figure6"),
    "fig7": ("fig7", "Figure7"),
    "fig8": ("fig8", "Figure8"),
    "fig9": ("fig9", "Figure9"),
    "fig10": ("fig10", "Figure10"),
    "fig11": ("fig11", "Figure11"),
    "fig14": ("fig14", "Figure14"),
    "fig15": ("fig15", "Figure15"),
    "fig12": ("fig12", "Figure12"),
    "table3": ("table3", "Table3"),
    "predictability": ("routes", "PredictabilityOfRoutes"),
}


def experiment_named(name: str) -> "Experiment":
    """The experiment of a name; imported when asked for, so that a list of names costs nothing.

    Raises
    ------
    InvalidParameter
        When there is none.
    """
    if name not in EXPERIMENTS:
        raise InvalidParameter(f"must be one of {', '.join(EXPERIMENTS)}, not {name!r}", field="experiment")
    module, kind = EXPERIMENTS[name]
    experiment: "Experiment" = getattr(import_module(f"{__name__}.{module}"), kind)()
    return experiment
