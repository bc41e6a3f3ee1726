"""What paths are judged by, in worlds that a reader checks by hand."""

import math

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.errors import InvalidParameter
from social_fleet.experiments.metrics import (heading_change, heading_change_per_metre, mean_wall_distance,
                                              median_wall_distance, paper_wall_distance, predictability,
                                              right_distance, wall_samples)

# 20 m by 6 m; the upper half has a block from x = 10 on.
CORRIDOR = grid_from_text("""
    ####################
    #.........##########
    #.........##########
    #..................#
    #..................#
    ####################
""")
EAST = [(1.0, 2.5), (19.0, 2.5)]


def test_walls_beside_a_straight_path():
    samples = wall_samples(CORRIDOR, EAST)
    assert len(samples.points) == 18 and samples.lengths == pytest.approx(np.ones(18))
    assert samples.near == pytest.approx(np.full(18, 1.5))
    assert samples.far == pytest.approx([2.5] * 9 + [0.5] * 9)


def test_the_other_way_round_the_walls_change_sides():
    there, back = wall_samples(CORRIDOR, EAST), wall_samples(CORRIDOR, EAST[::-1])
    assert back.near == pytest.approx(there.far[::-1]) and back.far == pytest.approx(there.near[::-1])
    left = wall_samples(CORRIDOR, EAST, side="left")
    assert left.near == pytest.approx(there.far) and left.far == pytest.approx(there.near)


def test_a_ray_goes_across_the_continuous_heading():
    open_room = grid_from_text("\n".join(["#" * 22, *["#" + "." * 20 + "#"] * 20, "#" * 22]), 0.5)
    slope = np.array([3.0, 4.0]) / 5.0
    samples = wall_samples(open_room, np.array([(5.0, 5.0), (5.0, 5.0) + 0.1 * slope]))
    x, y = samples.points[0]
    # To the right of (3, 4) / 5 lies (4, -3) / 5: the wall y = 0.5 comes before x = 10.5.
    assert samples.near[0] == pytest.approx(min((10.5 - x) / 0.8, (y - 0.5) / 0.6))
    assert samples.far[0] == pytest.approx(min((x - 0.5) / 0.8, (10.5 - y) / 0.6))


def test_the_border_of_the_map_is_a_wall_and_the_frame_may_be_turned():
    turned = grid_from_text("....\n....", origin=(3.0, 1.0, math.pi / 2))
    samples = wall_samples(turned, [(2.5, 1.5), (2.5, 4.5)])  # along the row of x 2 to 3
    assert samples.near == pytest.approx(np.full(3, 0.5)) and samples.far == pytest.approx(np.full(3, 1.5))


def test_a_diagonal_has_a_vertex_per_cell():
    samples = wall_samples(CORRIDOR, [(1.5, 1.5), (4.5, 4.5)])
    assert len(samples.points) == 3 and samples.lengths == pytest.approx(np.full(3, math.sqrt(2.0)))


def test_the_papers_rule_drops_the_ends_and_open_areas():
    samples = wall_samples(CORRIDOR, EAST[::-1])
    # 4.5 m to 13.5 m from the goal the wall to the right is 0.5 m away (x > 10) or 2.5 m: places x = 6.5 to 13.5.
    assert paper_wall_distance(samples) == pytest.approx((4 * 0.5 + 4 * 2.5) / 8)
    assert right_distance(CORRIDOR, EAST[::-1]) == paper_wall_distance(samples)
    assert paper_wall_distance(samples, open_area=2.0) == pytest.approx((4 * 0.5 + 4 * 2.5) / 8)  # the left one is near
    assert paper_wall_distance(samples, open_area=1.5) == pytest.approx(0.5)
    assert paper_wall_distance(samples, end_radius=10.0) is None


def test_by_arc_length_all_of_the_way_counts():
    assert mean_wall_distance(wall_samples(CORRIDOR, EAST[::-1])) == pytest.approx(1.5)
    # Pieces of a straight and of a diagonal segment weigh by their length: 6 m at 0.5 m, then sqrt(8) m.
    samples = wall_samples(CORRIDOR, [(2.0, 1.5), (8.0, 1.5), (10.0, 3.5)])
    assert samples.lengths.sum() == pytest.approx(6.0 + math.sqrt(8.0))
    assert mean_wall_distance(samples) == pytest.approx(samples.near @ samples.lengths / samples.lengths.sum())


def test_the_median_is_that_of_the_way():
    assert median_wall_distance(wall_samples(CORRIDOR, EAST)) == pytest.approx(1.5)
    # 2 m beside the block, where the wall is 0.5 m away, and 4 m where it is 2.5 m away.
    samples = wall_samples(CORRIDOR, [(12.0, 2.5), (6.0, 2.5)])
    assert median_wall_distance(samples) == pytest.approx(2.5)
    assert mean_wall_distance(samples) == pytest.approx((2 * 0.5 + 4 * 2.5) / 6)


def test_a_path_that_stands_still_has_no_distance():
    samples = wall_samples(CORRIDOR, [(2.0, 1.5)])
    assert len(samples.points) == 0
    assert paper_wall_distance(samples) is mean_wall_distance(samples) is median_wall_distance(samples) is None


def test_heading_change():
    square = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]
    assert heading_change(square) == pytest.approx(1.5 * math.pi)
    assert heading_change([(0, 0), (-1, 1e-3), (-2, 0)]) == pytest.approx(2e-3, rel=1e-3)  # over the jump of atan2
    assert heading_change([(0, 0), (1, 0)]) == heading_change([(0, 0)]) == 0.0
    assert heading_change_per_metre([square, [(0, 0), (4, 0)]]) == pytest.approx(1.5 * math.pi / 8.0)
    assert heading_change_per_metre([]) == 0.0


def test_one_way_streets_are_predictable():
    measured = predictability([[(0.1, 0.6), (2.0, 0.6)]] * 3)
    assert measured.entropy == 0.0
    assert (measured.squares, measured.paths_per_square) == (4, 3.0)


def test_two_ways_are_a_bit_and_weigh_by_their_metres():
    both = [[(0.0, 0.2), (4.0, 0.2)], [(2.0, 0.2), (0.0, 0.2)]]
    assert predictability(both).entropy == pytest.approx(4.0 / 6.0)  # 2 m with both ways, 2 m with one
    mixed = -(4 / 6 * math.log2(4 / 6) + 2 / 6 * math.log2(2 / 6))
    assert predictability(both, square=10.0).entropy == pytest.approx(mixed)


def test_a_heading_is_one_of_eight():
    star = [[(0.25, 0.25), (0.25 + 0.2 * math.cos(angle), 0.25 + 0.2 * math.sin(angle))]
            for angle in np.arange(16) * math.pi / 8 + 0.01]
    assert predictability(star).entropy == pytest.approx(3.0)


def test_nothing_driven_is_no_entropy():
    assert tuple(predictability([])) == tuple(predictability([[(1.0, 1.0)]])) == (0.0, 0, 0.0)


@pytest.mark.parametrize("square", [0.0, -1.0, math.nan])
def test_a_square_needs_a_size(square):
    with pytest.raises(InvalidParameter, match="positive"):
        predictability([], square=square)


def test_there_are_two_sides():
    with pytest.raises(InvalidParameter, match="right or left"):
        wall_samples(CORRIDOR, EAST, side="none")
