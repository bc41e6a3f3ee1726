"""Norms that a user might write, for the tests to name."""

import numpy as np

from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.social_cost.norms import HeadingCost, Norm


class KeepOff(Norm):
    """Stay a metre away from the walls ahead and behind, whatever the side."""

    reach = 3.0

    def __init__(self, config: PlannerConfig) -> None:
        self.weight = config.w_right

    def heading_cost(self, walls: np.ndarray, heading: int) -> HeadingCost:
        nearest = walls.min(axis=0)
        nothing = np.zeros_like(nearest)
        return HeadingCost(self.weight * np.maximum(1.0 - nearest, 0.0), nothing, nothing)


class Unfinished(Norm):
    """Lacks what a norm needs."""


class Picky(KeepOff):
    """Cannot be made."""

    def __init__(self, config: PlannerConfig) -> None:
        raise ValueError("the moon is not full")


class NoNormAtAll:
    """Has nothing to do with norms."""
