"""Social norms: what a metre of travel costs beside the wall that a norm follows (Eq. 3 as a line integral).

A norm is a small class. The search knows nothing of it: `edge_costs` turns what it yields into one number per
(cell, heading). `doc/planning.md` derives the integral.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Callable, Dict, Type

import numpy as np

from social_fleet.errors import InvalidParameter
from social_fleet.planning.config import PlannerConfig

PASSING_GAP = 0.25  # [m] between two robots that pass each other, tracking errors included
WALL_GAP = 0.05  # [m] between a robot and the wall that it keeps to, at least


@dataclass(frozen=True)
class HeadingCost:
    """What a norm charges for travel in one heading, at every cell.

    Attributes
    ----------
    rate : array
        Social cost per metre of travel, not negative.
    followed : array
        Distance [m] that should stay constant along the way.
    change_weight : array
        Cost per metre by which `followed` drifts.
    """

    rate: np.ndarray
    followed: np.ndarray
    change_weight: np.ndarray


class Norm(ABC):
    """A social convention of a place; derive from it to add one.

    A class that the configuration names is made with the `PlannerConfig` as its only argument.
    """

    @abstractmethod
    def heading_cost(self, walls: np.ndarray, heading: int) -> HeadingCost:
        """Cost of travel in one of the eight headings.

        Parameters
        ----------
        walls : (8, ...) float32 array
            Distance [m] to the nearest wall in each of the headings (counter-clockwise from the grid's columns, in
            steps of 45 degrees), capped at `reach`.
        heading : int
            Index of the heading that is driven.

        Returns
        -------
        HeadingCost
            Arrays of the shape of `walls[heading]`.
        """

    @property
    @abstractmethod
    def reach(self) -> float:
        """How far [m] the norm needs to see walls."""


class NoNorm(Norm):
    """Only length counts."""

    reach = 1.0

    def heading_cost(self, walls: np.ndarray, heading: int) -> HeadingCost:
        """No cost anywhere."""
        nothing = np.zeros_like(walls[heading])
        return HeadingCost(nothing, nothing, nothing)


class KeepSide(Norm):
    """Keep to one side: follow its wall at the standoff, don't drift, and leave room for oncoming traffic.

    Where the wall is an open area away, C_right is that distance, falling to nothing where the wall on the other side
    is as far and none guides. C_buf is the room missing beside the far wall there, and in corridors the reach beyond
    the robot's own half. In a narrow corridor the lane moves to the wall as two robots need it to pass; in one that is
    too narrow for two it moves to the middle, and drifting costs nothing.

    References
    ----------
    Eq. 3 of Sato and Law, Socially Consistent Multi-Robot Navigation.
    """

    def __init__(self, config: PlannerConfig) -> None:
        self._config = config
        self._towards = -2 if config.side == "right" else 2
        self._passing = 2.0 * config.robot_radius + PASSING_GAP  # [m] from centre to centre

    @property
    def reach(self) -> float:
        """How far [m] the norm needs to see walls."""
        config = self._config
        return max(config.open_area + config.lane_standoff, config.buffer_distance, config.fade_widths[1]) + 1.0

    def heading_cost(self, walls: np.ndarray, heading: int) -> HeadingCost:
        """Eq. 3 per metre: w_right C_right + w_buf C_buf, and w_const on the near wall's distance."""
        config = self._config
        near = walls[(heading + self._towards) % 8]
        far = walls[(heading - self._towards) % 8]
        width = near + far
        two_lanes = self._two_lanes(width)
        half = np.maximum(0.5 * (width - self._passing), config.robot_radius + WALL_GAP)  # where both have equal room
        lane = two_lanes * np.minimum(config.lane_standoff, half) + (1.0 - two_lanes) * 0.5 * width
        opening = near > config.open_area
        astray = np.where(opening, config.open_area * self._guided(far),
                          np.minimum(np.abs(near - lane), config.lane_pull))
        shortfall = np.where(opening, np.maximum(config.buffer_distance - far, 0.0),
                             two_lanes * self._narrow(width) * self._intrusion(near, np.maximum(half, lane)))
        rate = config.w_right * astray + config.w_buf * shortfall
        return HeadingCost(rate.astype(np.float32), near, (config.w_const * two_lanes).astype(np.float32))

    def _intrusion(self, near: np.ndarray, half: np.ndarray) -> np.ndarray:
        """How far [m] the robot is beyond its own half, where it would leave others too little room to pass."""
        return np.clip(near - half, 0.0, self._passing)

    def _narrow(self, width: np.ndarray) -> np.ndarray:
        """1 in corridors of up to twice the width of two lanes, falling to 0 at four times."""
        return np.clip(2.0 - 0.5 * width / max(self._config.fade_widths[1], 1e-6), 0.0, 1.0)

    def _guided(self, far: np.ndarray) -> np.ndarray:
        """1 beside a far wall, falling to 0 where that is an open area away too and no wall guides at all."""
        return np.clip(2.0 - 2.0 * far / self._config.open_area, 0.0, 1.0)

    def _two_lanes(self, width: np.ndarray) -> np.ndarray:
        """0 where a corridor of `width` [m] has a single lane, 1 where it has two, smooth in between."""
        single, two = self._config.fade_widths
        share = np.clip((width - single) / max(two - single, 1e-6), 0.0, 1.0)
        return share * share * (3.0 - 2.0 * share)


SIDES: Dict[str, Callable[[PlannerConfig], Norm]] = {
    "right": KeepSide,
    "left": KeepSide,
    "none": lambda config: NoNorm(),
}
"""The norm that each value of `PlannerConfig.side` asks for."""


def norm_of(config: PlannerConfig) -> Norm:
    """The norm that a configuration asks for: the class that `norm` names, else by `side`.

    Raises
    ------
    InvalidParameter
        When there is no such class, it is no `Norm`, or it cannot be made from the configuration; the field is
        ``norm``.
    """
    if config.norm is None:
        return SIDES[config.side](config)
    kind = _imported(config.norm)
    try:
        norm = kind(config)
    except Exception as error:
        raise InvalidParameter(f"{config.norm} cannot be made from the configuration: {type(error).__name__}: {error}",
                               field="norm") from error
    return norm


def _imported(path: str) -> Type[Any]:
    """The subclass of `Norm` with the dotted path ``package.module.Class``."""
    module_name, _, name = path.rpartition(".")
    if not all(part.isidentifier() for part in path.split(".")) or not module_name:
        raise InvalidParameter(f"must name a class as package.module.Class, not {path!r}", field="norm")
    try:
        module = import_module(module_name)
    except Exception as error:
        raise InvalidParameter(f"the module {module_name} cannot be imported: {error}; it must lie on PYTHONPATH",
                               field="norm") from error
    kind = getattr(module, name, None)
    if not isinstance(kind, type):
        raise InvalidParameter(f"the module {module_name} has no class {name}", field="norm")
    if not issubclass(kind, Norm):
        raise InvalidParameter(f"{path} must derive from {Norm.__module__}.Norm", field="norm")
    missing = sorted(getattr(kind, "__abstractmethods__", ()))
    if missing:
        raise InvalidParameter(f"{path} must define {' and '.join(missing)}", field="norm")
    return kind
