"""A norm of one's own, as doc/planning.md shows it."""

import numpy as np

from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.social_cost.norms import HeadingCost, Norm

WISH = 1.2  # [m] to the nearest wall


class KeepClear(Norm):
    """Stay clear of all walls, as a robot with a tray of glasses does."""

    reach = WISH + 1.0

    def __init__(self, config: PlannerConfig) -> None:
        self._weight = config.w_right

    def heading_cost(self, walls: np.ndarray, heading: int) -> HeadingCost:
        """What is missing to the wish, per metre of travel; no side, no drift."""
        nearest = walls.min(axis=0)
        nothing = np.zeros_like(nearest)
        return HeadingCost(self._weight * np.maximum(WISH - nearest, 0.0), nothing, nothing)
