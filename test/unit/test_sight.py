"""Hits on discs, as a lidar without a map has them."""

import math

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.simulation.sight import hits, in_sight


def test_hits_lie_on_the_near_side_of_a_disc() -> None:
    points = hits(0.0, 0.0, np.array([[2.0, 0.0, 0.5]]), 4.0)
    assert len(points) > 5 and np.hypot(points[:, 0] - 2.0, points[:, 1]) == pytest.approx(0.5, abs=1e-6)
    assert np.hypot(points[:, 0], points[:, 1]).min() == pytest.approx(1.5, abs=0.01)
    assert points[:, 0].max() < 2.0


def test_its_own_disc_what_is_far_and_what_is_hidden_are_not_hit() -> None:
    discs = np.array([[0.0, 0.0, 0.25], [9.0, 0.0, 0.5], [2.0, 0.0, 0.5], [3.5, 0.0, 0.3]])
    points = hits(0.0, 0.0, discs, 4.0, 0)
    assert len(points) and np.hypot(points[:, 0] - 2.0, points[:, 1]).max() < 0.51
    assert len(hits(0.0, 0.0, np.zeros((0, 3)), 4.0)) == 0


def test_walls_hide_places() -> None:
    grid = grid_from_text("....\n.##.\n....")
    assert in_sight(grid, 0.5, 0.5, (3.5, 0.5)) and not in_sight(grid, 1.5, 0.5, (1.5, 2.5))
    assert in_sight(grid, 0.5, 0.5, (0.5, 2.5)) and math.isfinite(grid.resolution)
