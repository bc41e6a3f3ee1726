"""C-space: the field at cell centres, the continuous check of a path, and the reason why a pose is refused."""

import math

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.errors import InvalidGoal, InvalidParameter, InvalidPose, InvalidStart
from social_fleet.geometry import Polyline
from social_fleet.mapping.clearance import ConfigurationSpace, clearance_field

ROOM = """
    ?##########
    #.........#
    #.........#
    #....#....#
    #.........#
    #.........#
    ###########
"""


def test_the_field_by_hand():
    grid = grid_from_text(ROOM, 0.2)
    field = clearance_field(grid, limit=1.0)
    assert field.dtype == np.float32
    assert field[3, 5] == 0.0
    assert field[3, 4] == pytest.approx(0.1)
    assert field[4, 4] == pytest.approx(math.hypot(0.1, 0.1)), "the corner of the blocked cell, not its centre"
    assert field[3, 3] == pytest.approx(0.3)
    assert clearance_field(grid, limit=0.15).max() == pytest.approx(0.15)


def test_a_robot_that_fits_exactly_fits():
    corridor = grid_from_text("#######\n.......\n.......\n.......\n#######", 0.2)
    assert ConfigurationSpace(corridor, 0.3).free[2, 1:-1].all()
    assert not ConfigurationSpace(corridor, 0.301).free.any()
    wide = grid_from_text("#" * 11 + "\n" + ("." * 11 + "\n") * 7 + "#" * 11, 0.2)
    assert ConfigurationSpace(wide, 0.7).free[4, 5], "3.5 cells of 0.2 m are 0.7 m in single precision too"
    assert ConfigurationSpace(wide, 0.7).is_free_path([(1.0, 0.9), (1.2, 0.9)])


def test_the_border_is_a_wall():
    space = ConfigurationSpace(grid_from_text("...\n...\n...", 1.0), 0.6)
    assert np.argwhere(space.free).tolist() == [[1, 1]]
    assert space.path_clearance([(1.5, 1.5)]) == 1.5


@pytest.mark.parametrize("yaw", [0.0, 0.4, math.pi / 2])
def test_a_path_is_checked_between_its_points(yaw):
    """Both ends are fine, and the straight way between them is not."""
    grid = grid_from_text(ROOM, 0.2, (5.0, -3.0, yaw))
    space = ConfigurationSpace(grid, 0.25)
    left, above, right = grid.from_local([(0.5, 0.7), (1.1, 1.05), (1.7, 0.7)])
    assert space.is_free_path([left]) and space.is_free_path([right])
    assert not space.is_free_path([left, right])
    assert space.path_clearance([left, right]) == pytest.approx(0.0, abs=1e-12)
    assert space.path_clearance(Polyline([left, above])) == pytest.approx(0.15, abs=1e-9)
    smaller = ConfigurationSpace(grid, 0.1)
    assert smaller.is_free_path([left, above, right])
    assert not smaller.is_free_path([left, right])


def test_clearance_is_told_up_to_the_limit():
    grid = grid_from_text(ROOM, 0.2)
    assert ConfigurationSpace(grid, 0.1, limit=0.2).path_clearance([(0.6, 0.7)]) == pytest.approx(0.2)
    assert ConfigurationSpace(grid, 0.3, limit=0.2).limit == 0.3


def test_a_good_pose_gives_its_cell():
    space = ConfigurationSpace(grid_from_text(ROOM, 0.2), 0.25)
    assert space.check_pose(0.5, 0.7) == (3, 2)
    assert space.check_pose(0.46, 0.7, "goal") == (3, 2)


@pytest.mark.parametrize("point, reason", [
    ((5.0, 0.7), "is off the map"),
    ((math.nan, 0.7), "is not finite"),
    ((1.1, 0.7), "lies in a wall"),
    ((0.1, 1.3), "lies in unknown space"),
    ((0.3, 0.7), "is 0.10 m from the nearest wall or unknown space, closer than the robot's radius of 0.25 m"),
])
@pytest.mark.parametrize("what, error", [("start", InvalidStart), ("goal", InvalidGoal), ("place", InvalidPose)])
def test_a_bad_pose_is_refused_with_its_reason(point, reason, what, error):
    space = ConfigurationSpace(grid_from_text(ROOM, 0.2), 0.25)
    with pytest.raises(error, match=reason) as caught:
        space.check_pose(*point, what)
    assert type(caught.value) is error
    assert caught.value.field == what


def test_the_refusal_names_the_nearest_place_that_fits():
    space = ConfigurationSpace(grid_from_text(ROOM, 0.2), 0.25)
    with pytest.raises(InvalidStart, match=r"the nearest place where it fits is \(0.50, 0.70\)"):
        space.check_pose(0.3, 0.7)
    with pytest.raises(InvalidStart, match="no room for a robot of radius 3 m"):
        ConfigurationSpace(space.grid, 3.0).check_pose(0.5, 0.7)


@pytest.mark.parametrize("radius", [0.0, -0.1, math.nan, math.inf])
def test_a_radius_is_a_positive_number(radius):
    with pytest.raises(InvalidParameter, match="must be a positive number"):
        ConfigurationSpace(grid_from_text(ROOM), radius)
