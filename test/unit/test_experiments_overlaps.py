"""What Figure 11 counts, on paths whose overlap a reader can work out."""

import numpy as np
import pytest

from social_fleet.experiments.overlaps import SEGMENT, overlaps_of, segments_of
from social_fleet.geometry import Polyline

EAST = Polyline([(0.0, 0.0), (10.0, 0.0)])
WEST = Polyline([(10.0, 0.1), (0.0, 0.1)])
NORTH = Polyline([(5.0, -5.0), (5.0, 5.0)])


def test_a_path_is_cut_into_equal_pieces_with_their_headings() -> None:
    pieces = segments_of(Polyline([(0.0, 0.0), (1.0, 0.0), (1.0, 2.0)]))
    assert len(pieces.middles) == 15 and pieces.middles[0] == pytest.approx((0.5 * SEGMENT, 0.0))
    assert pieces.headings[:5] == pytest.approx(0.0) and pieces.headings[5:] == pytest.approx(np.pi / 2.0)


def test_head_on_overlaps_all_the_way() -> None:
    assert overlaps_of([EAST, WEST], 0.5).count(2) == 100


def test_following_does_not_count() -> None:
    assert overlaps_of([EAST, EAST], 0.5).count(2) == 0
    slanted = Polyline([(0.0, 0.0), (8.0, 6.0)])
    assert overlaps_of([EAST, slanted], 0.5).count(2) == 0


def test_a_crossing_overlaps_about_itself() -> None:
    found = overlaps_of([EAST, NORTH], 0.5)
    assert found.count(2) == 2 * 4  # middles 0.1 and 0.3 m to either side
    assert np.abs(found.middles - (5.0, 0.0)).max() <= 0.3 + 1e-9


def test_a_segment_counts_once_however_many_overlap_it() -> None:
    found = overlaps_of([EAST, WEST, WEST], 0.5)
    assert [found.count(size) for size in (1, 2, 3)] == [0, 100, 150]


def test_fleets_of_the_first_robots_are_counted_as_if_alone() -> None:
    generator = np.random.RandomState(3)
    paths = [Polyline(generator.uniform(0.0, 10.0, (4, 2))) for _ in range(6)]
    found = overlaps_of(paths, 0.5)
    assert [found.count(size) for size in range(1, 7)] == [len(overlaps_of(paths[:size], 0.5).sizes)
                                                           for size in range(1, 7)]


def test_own_segments_do_not_count() -> None:
    there_and_back = Polyline([(0.0, 0.0), (3.0, 0.0), (3.0, 0.2), (0.0, 0.2)])
    far = Polyline([(0.0, 9.0), (3.0, 9.0)])
    assert overlaps_of([there_and_back, far], 0.5).count(2) == 0
    assert overlaps_of([EAST], 0.5).count(1) == 0
