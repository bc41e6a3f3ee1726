"""Shapes of obstacles, and the cells that they touch."""

import math

import numpy as np
import pytest

from social_fleet.errors import InvalidOverlay
from social_fleet.geometry import Pose
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.overlays.raster import drawn_on, rasterised
from social_fleet.planning.overlays.shapes import MAX_VERTICES, Cells, DiscObstacle, Polygon, Rectangle

GRID = OccupancyGrid(np.zeros((30, 40), dtype=np.int8), 0.25)
TURNED = OccupancyGrid(np.zeros((30, 40), dtype=np.int8), 0.25, Pose(3.0, -2.0, 0.6))
L_SHAPE = Polygon(((2.0, 1.0), (5.0, 1.2), (5.1, 2.0), (3.1, 2.1), (3.0, 4.0), (2.1, 3.9)))


def covered(grid, shape):
    return set(map(tuple, rasterised(grid, shape).cells.tolist()))


def sampled(grid, shape, slack=0.0, per_cell=24):
    """Cells in which one of many points is no farther than `slack` [cells] from the shape, by its own distances."""
    rows, columns = grid.shape
    steps = (np.arange(max(grid.shape) * per_cell) + 0.5) / per_cell
    x, y = np.meshgrid(steps[:columns * per_cell], steps[:rows * per_cell])
    points = grid.from_local(np.column_stack([x.ravel(), y.ravel()]) * grid.resolution)
    inside = (shape.distances(points) <= slack * grid.resolution).reshape(rows, per_cell, columns, per_cell)
    return set(map(tuple, np.argwhere(inside.any(axis=(1, 3))).tolist()))


@pytest.mark.parametrize("grid", [GRID, TURNED])
@pytest.mark.parametrize("shape", [DiscObstacle(2.4, 1.3, 0.9), Rectangle(3.0, 2.5, 2.0, 0.4, 0.5), L_SHAPE,
                                   Rectangle(2.1, 2.1, 0.05, 0.05), DiscObstacle(2.1, 2.1, 0.02)])
def test_all_cells_that_a_shape_enters_and_no_others(grid, shape):
    # What lies between samples is at most half the diagonal of their spacing away from one.
    assert sampled(grid, shape) <= covered(grid, shape) <= sampled(grid, shape, slack=0.75 / 24)


def test_a_rectangle_on_the_edges_of_cells_takes_these_cells_alone():
    assert covered(GRID, Rectangle(1.0, 1.5, 0.5, 1.0)) == {(row, column) for row in range(4, 8) for column in (3, 4)}


def test_a_map_with_obstacles_drawn_in():
    drawn = drawn_on(TURNED, [DiscObstacle(5.0, 1.0, 0.5), L_SHAPE])
    assert set(map(tuple, np.argwhere(drawn.blocked).tolist())) == (covered(TURNED, DiscObstacle(5.0, 1.0, 0.5))
                                                                    | covered(TURNED, L_SHAPE))
    assert (drawn.resolution, drawn.origin) == (TURNED.resolution, TURNED.origin)


def test_cells_by_pairs_and_by_mask():
    cells = [(3, 4), (3, 5), (10, 20)]
    mask = np.zeros(GRID.shape, dtype=bool)
    mask[tuple(np.transpose(cells))] = True
    for grid in (GRID, TURNED):
        assert covered(grid, Cells.of(grid, cells)) == set(cells)
    assert Cells.of(GRID, mask) == Cells.of(GRID, cells)


def test_what_is_partly_off_the_map_counts_as_far_as_it_is_on_it():
    assert covered(GRID, Rectangle(0.0, 0.0, 1.0, 1.0)) == {(row, column) for row in range(2) for column in range(2)}
    assert covered(GRID, Cells.of(GRID, [(-1, 0), (0, 0)])) == {(0, 0)}


@pytest.mark.parametrize("shape", [
    DiscObstacle(-3.0, 1.0, 1.0), Rectangle(11.5, 2.0, 1.0, 1.0), Cells(((-1.0, 2.0),), 0.25),
    Polygon(((20.0, 0.0), (21.0, 0.0), (21.0, 1.0))), DiscObstacle(-0.8, -0.8, 1.0), Rectangle(-0.5, 1.0, 1.0, 1.0),
])
def test_what_is_wholly_off_the_map_is_refused(shape):
    with pytest.raises(InvalidOverlay, match=r"off the map, which lies within x 0.00 to 10.00 m and y 0.00 to 7.50 m"):
        rasterised(GRID, shape)


@pytest.mark.parametrize("make, field", [
    (lambda: DiscObstacle(math.nan, 0.0, 1.0), "x"), (lambda: DiscObstacle(0.0, math.inf, 1.0), "y"),
    (lambda: DiscObstacle(0.0, 0.0, 0.0), "radius"), (lambda: DiscObstacle(0.0, 0.0, -1.0), "radius"),
    (lambda: DiscObstacle("1", 0.0, 1.0), "x"), (lambda: DiscObstacle(0.0, True, 1.0), "y"),
    (lambda: Rectangle(0.0, 0.0, 0.0, 1.0), "width"), (lambda: Rectangle(0.0, 0.0, 1.0, math.nan), "height"),
    (lambda: Rectangle(0.0, 0.0, 1.0, 1.0, math.inf), "yaw"),
    (lambda: DiscObstacle(0.0, 0.0, 1e300), "radius"), (lambda: Rectangle(-1e300, 0.0, 1.0, 1.0), "x"),
    (lambda: Polygon(((0.0, 0.0), (1e300, 0.0), (0.0, 1.0))), "vertices[1]"),
    (lambda: Polygon(((0.0, 0.0), (1.0, 0.0))), "vertices"), (lambda: Polygon(()), "vertices"),
    (lambda: Polygon(((0.0, 0.0), (1.0, 0.0), (2.0, 0.0))), "vertices"),
    (lambda: Polygon(((0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0))), "vertices"),
    (lambda: Polygon(((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (1.0, 0.0), (0.0, 2.0))), "vertices"),
    (lambda: Polygon(((0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (0.0, 1.0))), "vertices"),
    (lambda: Polygon(((0.0, 0.0), (2.0, 0.0), (1.0, 0.0), (1.0, 1.0))), "vertices"),
    (lambda: Polygon(((0.0, 0.0), (1.0, math.nan), (0.0, 1.0))), "vertices[1]"),
    (lambda: Polygon(((0.0, 0.0), (1.0, 0.0, 2.0), (0.0, 1.0))), "vertices[1]"),
    (lambda: Polygon("abc"), "vertices"),
    (lambda: Polygon([(float(index), float(index ** 2)) for index in range(MAX_VERTICES + 1)]), "vertices"),
    (lambda: Cells((), 0.25), "points"), (lambda: Cells(((0.0, 0.0),), 0.0), "size"),
    (lambda: Cells.of(GRID, np.zeros((3, 3), dtype=bool)), "cells"), (lambda: Cells.of(GRID, [(0.5, 1.0)]), "cells"),
    (lambda: Cells.of(GRID, [(1, 2, 3)]), "cells"),
    (lambda: Cells.of(GRID, np.zeros(GRID.shape, dtype=bool)), "points"),
])
def test_what_is_no_shape_is_refused_by_its_field(make, field):
    with pytest.raises(InvalidOverlay) as caught:
        make()
    assert caught.value.field == field


def test_polygons_may_turn_either_way_and_be_lists():
    there = Polygon([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 0.2]])
    back = Polygon(np.array([[0.5, 0.2], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]))
    assert covered(GRID, there) == covered(GRID, back)
    assert hash(there) != hash(back)


def test_distances_are_zero_inside():
    points = np.array([(2.0, 1.0), (2.0, 3.0), (4.0, 1.0)])
    np.testing.assert_allclose(DiscObstacle(2.0, 1.0, 0.5).distances(points), [0.0, 1.5, 1.5])
    np.testing.assert_allclose(Rectangle(2.0, 1.0, 2.0, 1.0, math.pi / 2).distances(points), [0.0, 1.0, 1.5])
    np.testing.assert_allclose(L_SHAPE.distances(np.array([(2.5, 2.5), (2.0, 0.0), (7.1, 2.0)])), [0.0, 1.0, 2.0])
    np.testing.assert_allclose(Cells(((2.0, 1.0),), 0.5).distances(points), [0.0, 1.75, 1.75])
