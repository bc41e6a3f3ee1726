"""Outlines of polygons: which are refused, and what they hold."""

import numpy as np
import pytest

from social_fleet.errors import InvalidParameter
from social_fleet.mapping.polygons import checked_polygon, crossing_sides, inside_polygon

SQUARE = [[0, 0], [2, 0], [2, 2], [0, 2]]


def test_a_square_is_kept_either_way_round():
    assert checked_polygon(SQUARE, InvalidParameter) == ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))
    assert len(checked_polygon(SQUARE[::-1], InvalidParameter)) == 4


@pytest.mark.parametrize("outline", [
    [[0, 0], [2, 2], [2, 0], [0, 2]],  # a bow tie
    [[0, 0], [2, 0], [1, 0]],  # folded back
    [[0, 0], [2, 0], [2, 2], [2, 2], [0, 2]],  # a corner twice
    [[0, 0], [4, 0], [4, 4], [2, 0], [0, 4]],  # a corner on a side
    [[0, 0], [0, 0], [0, 0]],
])
def test_an_outline_that_crosses_or_touches_itself_is_refused(outline):
    with pytest.raises(InvalidParameter, match="cross or touch") as error:
        checked_polygon(outline, InvalidParameter, field="zone")
    assert error.value.field == "zone"


@pytest.mark.parametrize("outline, field", [
    (None, "polygon"), ("square", "polygon"), ([[0, 0], [1, 1]], "polygon"),
    ([[0, 0], [1, 0], [1]], "polygon[2]"), ([[0, 0], [1, "a"], [1, 1]], "polygon[1]"),
    ([[0, float("nan")], [1, 0], [1, 1]], "polygon[0]"), ([[0, 0], [True, 0], [1, 1]], "polygon[1]"),
    ([[0, 0], [1, 0], [float("inf"), 1]], "polygon[2]"), ([3, [1, 0], [1, 1]], "polygon[0]"),
])
def test_what_is_no_outline_is_refused(outline, field):
    with pytest.raises(InvalidParameter) as error:
        checked_polygon(outline, InvalidParameter)
    assert error.value.field == field


def test_a_concave_outline_is_fine_and_holds_what_lies_within():
    arrow = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (2.0, 1.0), (0.0, 4.0)]
    assert crossing_sides(arrow) is None
    inside = inside_polygon(arrow, np.array([0.5, 2.0, 2.0, 3.5, 5.0]), np.array([0.5, 0.5, 2.0, 2.0, 1.0]))
    assert inside.tolist() == [True, True, False, True, False]


def test_polygons_that_share_a_side_share_no_place():
    left, right = [(0, 0), (1, 0), (1, 2), (0, 2)], [(1, 0), (2, 0), (2, 2), (1, 2)]
    x, y = (values.ravel() for values in np.meshgrid(np.arange(0.0, 2.0, 0.25), np.arange(0.0, 2.0, 0.25)))
    assert (inside_polygon(left, x, y) ^ inside_polygon(right, x, y)).all()
