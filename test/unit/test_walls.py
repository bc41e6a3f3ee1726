"""Directional wall distances, checked by hand on tiny worlds and against a walk of every ray."""

import math

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.mapping.walls import HEADINGS, wall_distances

EAST, NORTH_EAST, NORTH, NORTH_WEST, WEST, SOUTH_WEST, SOUTH, SOUTH_EAST = range(8)
ROOT2 = math.sqrt(2.0)


def walk(blocked, row, column, heading):
    """Steps a ray takes until it ends."""
    rows, columns = blocked.shape
    column_step, row_step = HEADINGS[heading]
    if blocked[row, column]:
        return 0
    steps = 0
    while True:
        steps += 1
        next_row, next_column = row + row_step, column + column_step
        if not (0 <= next_row < rows and 0 <= next_column < columns) or blocked[next_row, next_column]:
            return steps
        if column_step and row_step and blocked[row, next_column] and blocked[next_row, column]:
            return steps
        row, column = next_row, next_column


def test_headings_turn_counter_clockwise_from_the_columns():
    angles = [math.atan2(row_step, column_step) % (2 * math.pi) for column_step, row_step in HEADINGS]
    np.testing.assert_allclose(angles, np.arange(8) * math.pi / 4)


def test_distances_by_hand():
    grid = grid_from_text("""
        ....#
        .....
        #...?
    """, 0.2)
    distances = wall_distances(grid.blocked, 0.2, limit=10.0)
    assert distances.dtype == np.float32
    centre = distances[:, 1, 2]
    expected = {EAST: 0.5, NORTH_EAST: 0.3 * ROOT2, NORTH: 0.3, WEST: 0.5, SOUTH: 0.3, SOUTH_WEST: 0.3 * ROOT2}
    for heading, distance in expected.items():
        assert centre[heading] == pytest.approx(distance, abs=1e-6), heading
    assert distances[SOUTH_WEST, 1, 1] == pytest.approx(0.1 * ROOT2)
    assert distances[SOUTH_EAST, 1, 3] == pytest.approx(0.1 * ROOT2)
    assert distances[WEST, 0, 3] == pytest.approx(0.5)
    assert (distances[:, 0, 0] == 0.0).all()


def test_distances_are_capped():
    grid = grid_from_text(".....\n")
    assert wall_distances(grid.blocked, 1.0, limit=2.0)[EAST].tolist() == [[2.0, 2.0, 2.0, 1.5, 0.5]]
    assert wall_distances(grid.blocked, 1.0, limit=math.inf)[EAST, 0, 0] == 4.5


def test_a_ray_does_not_slip_through_a_diagonal_wall():
    grid = grid_from_text("""
        .#..
        ..#.
        ...#
        ....
    """)
    distances = wall_distances(grid.blocked, 1.0, limit=10.0)
    assert distances[NORTH_EAST, 1, 1] == pytest.approx(1.5 * ROOT2 - ROOT2)
    assert distances[NORTH_EAST, 0, 0] == pytest.approx(1.5 * ROOT2)
    assert distances[NORTH_EAST, 2, 1] == pytest.approx(0.5 * ROOT2), "the corner where two blocked cells touch"
    assert distances[SOUTH_WEST, 3, 2] == pytest.approx(0.5 * ROOT2)
    assert distances[NORTH, 0, 2] == pytest.approx(1.5 + 0.0)


@pytest.mark.parametrize("seed", range(5))
def test_distances_equal_a_walk_of_every_ray(seed):
    random = np.random.RandomState(seed)
    blocked = random.rand(random.randint(1, 25), random.randint(1, 25)) < 0.15
    distances = wall_distances(blocked, 0.05, limit=0.6)
    for (heading, row, column), distance in np.ndenumerate(distances):
        steps = walk(blocked, row, column, heading)
        stride = 0.05 * math.hypot(*HEADINGS[heading])
        assert distance == pytest.approx(min(max(steps - 0.5, 0.0) * stride, 0.6), abs=1e-6)
