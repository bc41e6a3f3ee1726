"""Social norms: what a metre of travel costs beside the wall that a norm follows (Eq. 3 as a line integral).

A norm is a small class. The search knows nothing of it: `edge_costs` turns what it yields into one number per
(cell, heading). `doc/planning.md` derives the integral.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from social_fleet.planning.config import PlannerConfig

PASSING_GAP = 0.2  # [m] between two robots that pass each other


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
    """A social convention of a place; derive from it to add one."""

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
    """Keep to one side: follow its wall at `standoff`, don't drift, and leave a buffer in open areas.

    In a corridor that is too narrow for two lanes the lane moves to the middle, and drifting costs nothing.

    References
    ----------
    Eq. 3 of Sato and Law, Socially Consistent Multi-Robot Navigation.
    """

    def __init__(self, config: PlannerConfig) -> None:
        self._config = config
        self._towards = -2 if config.side == "right" else 2

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
        two_lanes = self._two_lanes(near + far)
        lane = two_lanes * config.lane_standoff + (1.0 - two_lanes) * 0.5 * (near + far)
        width = near + far
        open_near = near > config.open_area
        astray = np.where(open_near, min(config.open_area,float(__import__('os').environ.get('CAP2','99'))) * self._guided(far), np.minimum(np.abs(near - lane),float(__import__('os').environ.get('CAP','99'))))
        buffer = np.where(open_near, np.maximum(config.buffer_distance - far, 0.0),
                          two_lanes * self._narrow(width) * self._oncoming(near, far))
        rate = config.w_right * astray + config.w_buf * buffer
        return HeadingCost(rate.astype(np.float32), near, (config.w_const * two_lanes).astype(np.float32))

    def _oncoming(self, near: np.ndarray, far: np.ndarray) -> np.ndarray:
        """How far [m] the robot's half of the passing distance reaches over the middle, at most all of it."""
        passing = 2.0 * self._config.robot_radius + PASSING_GAP
        return 0.5 * np.clip(near - far + passing, 0.0, 2.0 * passing)

    def _narrow(self, width: np.ndarray) -> np.ndarray:
        """1 in corridors of up to twice the width of two lanes, falling to 0 at four times."""
        return np.clip(2.0 - 0.5 * width / self._config.fade_widths[1], 0.0, 1.0)

    def _guided(self, far: np.ndarray) -> np.ndarray:
        """1 beside a far wall, falling to 0 where that is an open area away too and no wall guides at all."""
        return np.clip(2.0 - 2.0 * far / self._config.open_area, 0.0, 1.0)

    def _two_lanes(self, width: np.ndarray) -> np.ndarray:
        """0 where a corridor of `width` [m] has a single lane, 1 where it has two, smooth in between."""
        single, two = self._config.fade_widths
        share = np.clip((width - single) / max(two - single, 1e-6), 0.0, 1.0)
        return share * share * (3.0 - 2.0 * share)


def norm_of(config: PlannerConfig) -> Norm:
    """The norm that a configuration asks for."""
    return NoNorm() if config.side == "none" else KeepSide(config)
