"""Which places of a small world hang together, with and without discs that are closed."""

import numpy as np
from worlds import grid_from_text

from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.lattice import Lattice
from social_fleet.planning.overlays.discs import Disc
from social_fleet.planning.regions import Regions

RING = """
    ############
    #..........#
    #.########.#
    #..........#
    ############
    #..........#
    ############
"""


def regions(*discs: Disc) -> Regions:
    coarse = grid_from_text(RING, 1.0)
    grid = type(coarse)(np.kron(coarse.values, np.ones((4, 4), dtype=np.int8)), 0.25, coarse.origin)
    return Regions(grid, Lattice(ConfigurationSpace(grid, 0.2)), discs)


TOP, LOW, LEFT, APART = (5.5, 5.5), (5.5, 3.5), (1.5, 4.5), (5.5, 1.5)


def test_what_walls_divide() -> None:
    labels = regions().of(np.array([TOP, LOW, LEFT, APART]))
    assert labels[0] == labels[1] == labels[2] != labels[3]
    assert (labels > 0).all()


def test_one_disc_leaves_a_ring_whole_and_two_divide_it() -> None:
    ends = np.array([LEFT, (10.5, 4.5)])
    one, two = regions(Disc(*TOP, 0.6)).of(ends), regions(Disc(*TOP, 0.6), Disc(*LOW, 0.6)).of(ends)
    assert one[0] == one[1]
    assert two[0] != two[1]


def test_a_place_in_a_wall_counts_as_the_one_beside_it_and_one_far_off_as_none() -> None:
    found = regions()
    assert found.of(np.array([(5.5, 6.1)]))[0] == found.of(np.array([TOP]))[0]
    assert found.of(np.array([(-50.0, 3.0), (5.5, 60.0)])).tolist() == [0, 0]


def test_parts_that_a_disc_touches() -> None:
    found = regions(Disc(*TOP, 0.6), Disc(*LOW, 0.6))
    left, right = found.of(np.array([LEFT, (10.5, 4.5)])).tolist()
    assert sorted(found.touching(Disc(*TOP, 0.6))) == sorted((left, right))
    assert found.touching(Disc(*LEFT, 0.3)).tolist() == [left]


def test_a_disc_across_a_lane_may_cut_it_and_one_in_a_corner_does_not() -> None:
    found = regions()
    assert found.may_be_cut_by(Disc(*TOP, 0.6))
    assert not found.may_be_cut_by(Disc(1.5, 1.5, 0.4))
