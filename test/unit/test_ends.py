"""Where plans start and end: what is refused, and how poses join the lattice."""

import math

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.errors import InvalidGoal, InvalidStart, NoPath
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.driven_path.chords import Ground
from social_fleet.planning.ends import checked_position, joined, reachable
from social_fleet.planning.lattice import Lattice, fitting_radius
from social_fleet.planning.overlays.discs import Disc
from social_fleet.planning.planner import SocialPlanner

SPACE = ConfigurationSpace(grid_from_text("""
    ............
    ............
    ............
    ....??......
    ....##......
    ............
    ............
"""), 0.8)
NOBODY = np.zeros(0, dtype=np.int64)


def ground_of(space):
    return Ground(space.grid.blocked, space.clearance, space.grid.resolution, fitting_radius(space), np.zeros((0, 3)))


@pytest.mark.parametrize("pose, words", [
    ((math.nan, 1.0), "finite"), ((1.0, 1.0, math.inf), "finite"), ((1.0,), "1 numbers"),
    ((1.0, 2.0, 3.0, 4.0), "4 numbers"),
    ("ab", "must be"), ((-3.0, 1.0), "off the map"), ((4.5, 2.5), "wall"), ((4.5, 3.5), "unknown"),
    ((3.5, 2.5), "radius"), ((0.1, 5.0), "radius"), ((9.0, 5.0), "must avoid"),
])
def test_bad_poses_say_what_is_wrong(pose, words):
    for what, error in (("start", InvalidStart), ("goal", InvalidGoal)):
        with pytest.raises(error, match=words) as caught:
            checked_position(SPACE, pose, what, [Disc(9.0, 5.5, 1.0)])
        assert caught.value.field == what


def test_a_good_pose_in_cells():
    np.testing.assert_allclose(checked_position(SPACE, (1.5, 1.25, 0.3), "start", []), [1.5, 1.25])


def test_a_pose_joins_its_own_cell():
    lattice = Lattice(SPACE)
    node = lattice.node[1, 1]
    assert reachable(lattice, ground_of(SPACE), np.array([1.3, 1.8]), NOBODY) == [node]


def test_a_pose_in_a_cell_whose_centre_is_too_near_a_wall_joins_others():
    lattice = Lattice(SPACE)
    assert lattice.node[2, 3] < 0  # its centre is half a metre from the wall
    near = reachable(lattice, ground_of(SPACE), np.array([3.1, 2.5]), NOBODY)
    assert near[0] == lattice.node[2, 2]
    assert lattice.node[2, 6] not in near


def test_closed_nodes_are_not_joined():
    lattice = Lattice(SPACE)
    node = lattice.node[1, 1]
    assert node not in reachable(lattice, ground_of(SPACE), np.array([1.5, 1.5]), np.array([node]))


def test_ends_in_separate_rooms_do_not_join():
    space = ConfigurationSpace(grid_from_text("""
        ...#...
        ...#...
        ...#...
    """), 0.4)
    lattice = Lattice(space)
    ends = np.array([1.5, 1.5]), np.array([5.5, 1.5])
    assert joined(lattice, ground_of(space), ends, NOBODY) == []
    assert joined(lattice, ground_of(space), (ends[0], ends[0]), NOBODY) == [(lattice.node[1, 1],) * 2]


def test_a_pose_in_a_pocket_joins_what_its_radius_lets_it_reach():
    # A gap of 0.6 m: a disc of 0.25 m fits through, with a margin of 0.06 m it does not.
    planner = SocialPlanner(grid_from_text("""
        ##############
        #............#
        #............#
        #............#
        #............#
        #............#
        #######...####
        #............#
        #............#
        #............#
        #............#
        #............#
        ##############
    """, 0.2), PlannerConfig(robot_radius=0.25, wall_margin=0.06))
    lattice = planner.lattice
    in_pocket, beyond, far_off = (1.7, 1.1), (0.9, 1.9), (0.5, 0.5)
    pocket, outside = (lattice.node[planner.grid.cell(*place)] for place in (in_pocket, beyond))
    assert min(pocket, outside) >= 0 and lattice.component[pocket] != lattice.component[outside]
    for start, goal in ((in_pocket, beyond), (beyond, in_pocket)):
        assert planner.space.is_free_path(planner.plan(start, goal).points)
    with pytest.raises(NoPath):  # through the gap there is no way but for those who stand at it
        planner.plan(far_off, beyond)
