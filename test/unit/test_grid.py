"""Cells and poses map onto each other, yaw included; a grid is immutable and refuses what makes no sense."""

import dataclasses
import math

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.errors import InvalidMap, InvalidPose
from social_fleet.geometry import Pose
from social_fleet.mapping.grid import OccupancyGrid

THREE_BY_TWO = """
    #.?
    ..#
"""


def test_the_top_line_of_a_text_is_the_highest_row():
    grid = grid_from_text(THREE_BY_TWO)
    assert grid.shape == (2, 3)
    assert grid.values.tolist() == [[0, 0, 100], [100, 0, -1]]


def test_unknown_and_likely_occupied_cells_are_blocked():
    grid = OccupancyGrid(np.array([[-1, 0, 1, 49, 50, 99, 100]]), 0.1)
    assert grid.blocked.tolist() == [[True, False, False, False, True, True, True]]


def test_cells_without_yaw():
    grid = grid_from_text(THREE_BY_TWO, 0.5, (-1.0, 2.0, 0.0))
    assert grid.size == (1.5, 1.0)
    assert grid.cell(-1.0, 2.0) == (0, 0)
    assert grid.cell(0.49, 2.99) == (1, 2)
    assert grid.centre(1, 2) == (0.25, 2.75)
    assert grid.contains(0.49, 2.99)
    assert not grid.contains(0.5, 2.5)
    assert not grid.contains(math.nan, 2.5)


def test_cells_with_a_quarter_turn():
    """Columns run along +y and rows along -x."""
    grid = grid_from_text(THREE_BY_TWO, 1.0, (10.0, 0.0, math.pi / 2))
    assert grid.cell(9.5, 0.5) == (0, 0)
    assert grid.cell(9.5, 2.5) == (0, 2)
    assert grid.cell(8.5, 0.5) == (1, 0)
    np.testing.assert_allclose(grid.centres([(0, 2), (1, 0)]), [(9.5, 2.5), (8.5, 0.5)])


@pytest.mark.parametrize("yaw", [0.0, 0.3, -2.0])
def test_every_cell_holds_its_centre(yaw):
    grid = OccupancyGrid(np.zeros((7, 11), dtype=np.int8), 0.05, Pose(-3.7, 12.1, yaw))
    cells = np.argwhere(np.ones(grid.shape, dtype=bool))
    np.testing.assert_array_equal(grid.cells(grid.centres(cells)), cells)


def test_local_and_map_frame_are_inverse():
    grid = OccupancyGrid(np.zeros((2, 2), dtype=np.int8), 1.0, Pose(3.0, -1.0, 0.7))
    points = np.array([(0.0, 0.0), (1.5, 0.25), (-2.0, 9.0)])
    np.testing.assert_allclose(grid.from_local(grid.to_local(points)), points, atol=1e-12)
    np.testing.assert_allclose(grid.to_local([(3.0, -1.0)]), [(0.0, 0.0)], atol=1e-12)


def test_a_pose_on_an_edge_belongs_to_the_cell_above_it_whatever_the_rounding():
    grid = OccupancyGrid(np.zeros((1, 500), dtype=np.int8), 0.2)
    edges = np.array([(round(column * 0.2, 1), 0.1) for column in range(500)])
    np.testing.assert_array_equal(grid.cells(edges)[:, 1], np.arange(500))


@pytest.mark.parametrize("point, message", [
    ((3.0, 0.5), r"\(3.00, 0.50\) is off the map, which lies within x 0.00 to 3.00 m and y 0.00 to 2.00 m"),
    ((-0.1, 0.5), "off the map"),
    ((math.nan, 0.5), "is not finite"),
    ((0.5, math.inf), "is not finite"),
])
def test_points_off_the_map_are_refused(point, message):
    grid = grid_from_text(THREE_BY_TWO)
    with pytest.raises(InvalidPose, match=message):
        grid.cell(*point)
    with pytest.raises(InvalidPose, match=message):
        grid.cells([(0.5, 0.5), point])


def test_values_are_copied_and_read_only():
    values = np.zeros((2, 2), dtype=np.int8)
    grid = OccupancyGrid(values, 1.0)
    values[0, 0] = 100
    assert grid.values[0, 0] == 0
    for array in (grid.values, grid.blocked):
        with pytest.raises(ValueError):
            array[0, 0] = 1
    with pytest.raises(dataclasses.FrozenInstanceError):
        grid.resolution = 2.0


def test_equality_and_digest_see_every_part():
    base = grid_from_text(THREE_BY_TWO, 0.5)
    assert base == grid_from_text(THREE_BY_TWO, 0.5)
    assert hash(base) == hash(grid_from_text(THREE_BY_TWO, 0.5))
    others = [grid_from_text(THREE_BY_TWO, 0.25), grid_from_text(THREE_BY_TWO, 0.5, (0.0, 0.0, 0.1)),
              grid_from_text("#..\n..#", 0.5), OccupancyGrid(base.values.reshape(3, 2), 0.5)]
    assert len({grid.digest for grid in [base] + others}) == 5
    assert base.digest == grid_from_text(THREE_BY_TWO, 0.5, (-0.0, 0.0, 0.0)).digest


@pytest.mark.parametrize("values, resolution, origin, field", [
    (np.zeros((0, 3), dtype=np.int8), 1.0, Pose(0, 0), "values"),
    (np.zeros(3, dtype=np.int8), 1.0, Pose(0, 0), "values"),
    (np.full((1, 1), 101), 1.0, Pose(0, 0), "values"),
    (np.full((1, 1), -2), 1.0, Pose(0, 0), "values"),
    (np.full((1, 1), 0.5), 1.0, Pose(0, 0), "values"),
    ([[0]], 0.0, Pose(0, 0), "resolution"),
    ([[0]], -0.05, Pose(0, 0), "resolution"),
    ([[0]], math.nan, Pose(0, 0), "resolution"),
    ([[0]], math.inf, Pose(0, 0), "resolution"),
    ([[0]], "fine", Pose(0, 0), "resolution"),
    ([[0]], 1e-300, Pose(0, 0), "resolution"),
    ([[0]], 1e300, Pose(0, 0), "resolution"),
    ([[0]], 10 ** 400, Pose(0, 0), "resolution"),
    ([[0]], 1.0, Pose(1e300, 0), "origin"),
    ([[0]], 1.0, Pose(0, math.nan), "origin"),
    ([[0]], 1.0, (0.0, "x", 0.0), "origin"),
    ([[0]], 1.0, 3.0, "origin"),
])
def test_nonsense_is_refused_by_field(values, resolution, origin, field):
    with pytest.raises(InvalidMap) as caught:
        OccupancyGrid(values, resolution, origin)
    assert caught.value.field == field
