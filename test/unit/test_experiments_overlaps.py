"""What Figure 11 counts, on paths whose overlap a reader can work out."""

import numpy as np
import pytest

from social_fleet.experiments.overlaps import SEGMENT, overlapping, segments_of
from social_fleet.geometry import Polyline

EAST = Polyline([(0.0, 0.0), (10.0, 0.0)])
WEST = Polyline([(10.0, 0.1), (0.0, 0.1)])
NORTH = Polyline([(5.0, -5.0), (5.0, 5.0)])


def test_a_path_is_cut_into_equal_pieces_with_their_headings() -> None:
    pieces = segments_of(Polyline([(0.0, 0.0), (1.0, 0.0), (1.0, 2.0)]))
    assert len(pieces.middles) == 15 and pieces.middles[0] == pytest.approx((0.5 * SEGMENT, 0.0))
    assert pieces.headings[:5] == pytest.approx(0.0) and pieces.headings[5:] == pytest.approx(np.pi / 2.0)


def test_head_on_overlaps_all_the_way() -> None:
    assert [len(found) for found in overlapping([EAST, WEST], 0.5)] == [50, 50]


def test_following_does_not_count() -> None:
    assert [len(found) for found in overlapping([EAST, EAST], 0.5)] == [0, 0]
    slanted = Polyline([(0.0, 0.0), (8.0, 6.0)])
    assert [len(found) for found in overlapping([EAST, slanted], 0.5)] == [0, 0]


def test_a_crossing_overlaps_about_itself() -> None:
    east, north = overlapping([EAST, NORTH], 0.5)
    assert len(east) == len(north) == 4  # middles 0.1 and 0.3 m to either side
    assert np.abs(east - (5.0, 0.0)).max() <= 0.3 + 1e-9


def test_a_segment_counts_once_however_many_overlap_it() -> None:
    assert [len(found) for found in overlapping([EAST, WEST, WEST], 0.5)] == [50, 50, 50]


def test_own_segments_do_not_count() -> None:
    there_and_back = Polyline([(0.0, 0.0), (3.0, 0.0), (3.0, 0.2), (0.0, 0.2)])
    far = Polyline([(0.0, 9.0), (3.0, 9.0)])
    assert [len(found) for found in overlapping([there_and_back, far], 0.5)] == [0, 0]
    assert [len(found) for found in overlapping([EAST], 0.5)] == [0]
