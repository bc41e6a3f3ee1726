"""Temporary obstacles that a single plan goes round."""

import math
from dataclasses import dataclass
from typing import Sequence

import numpy as np

from social_fleet.errors import InvalidParameter
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.overlays.shapes import FARTHEST


@dataclass(frozen=True)
class Disc:
    """A disc that the centre line of a path stays out of: `x`, `y` [m, map frame], `radius` [m]."""

    x: float
    y: float
    radius: float

    def __post_init__(self) -> None:
        for name in ("x", "y", "radius"):
            if not abs(getattr(self, name)) <= FARTHEST:  # nor NaN
                raise InvalidParameter(f"must be a finite number, {FARTHEST:g} at most, not {getattr(self, name)!r}",
                                       field=name)
        if self.radius <= 0.0:
            raise InvalidParameter(f"must be positive, not {self.radius!r}", field="radius")

    def holds(self, x: float, y: float) -> bool:
        """Whether a point lies inside, the rim excluded."""
        return math.hypot(x - self.x, y - self.y) < self.radius


def local_discs(grid: OccupancyGrid, discs: Sequence[Disc]) -> np.ndarray:
    """Discs as (D, 3) array: x, y, radius in cells along the grid's axes."""
    if not discs:
        return np.zeros((0, 3))
    centres = grid.to_local([(disc.x, disc.y) for disc in discs])
    return np.column_stack([centres, [disc.radius for disc in discs]]) / grid.resolution


def covered_nodes(node: np.ndarray, discs: np.ndarray) -> np.ndarray:
    """Nodes that an edge clear of all discs must not touch.

    Between two nodes that are at most a diagonal step apart, and each at least sqrt(radius^2 + 1/2) from a disc's
    centre, no point of the edge is nearer to the centre than the radius.

    Parameters
    ----------
    node : (rows, cols) int32 array
        Number of each cell's node, -1 for none.
    discs : (D, 3) array
        As `local_discs` gives them.
    """
    rows, cols = node.shape
    covered = [np.zeros(0, dtype=node.dtype)]
    for x, y, radius in discs:
        reach = math.sqrt(radius * radius + 0.5)
        low_row, high_row = max(math.floor(y - reach), 0), min(math.ceil(y + reach), rows)
        low_col, high_col = max(math.floor(x - reach), 0), min(math.ceil(x + reach), cols)
        if low_row >= high_row or low_col >= high_col:
            continue
        window = node[low_row:high_row, low_col:high_col]
        aside = np.arange(low_col, high_col) + 0.5 - x
        above = np.arange(low_row, high_row) + 0.5 - y
        inside = above[:, None] ** 2 + aside[None, :] ** 2 < reach * reach
        covered.append(window[inside & (window >= 0)])
    return np.unique(np.concatenate(covered))
