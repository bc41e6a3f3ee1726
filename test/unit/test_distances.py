"""Distances to blocked squares against brute force that shares nothing with the kernels."""

import math

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.mapping.distances import (centre_clearance, polyline_clearance, segment_clearance,
                                            segment_square_distance)


def random_blocked(seed, density=0.06):
    random = np.random.RandomState(seed)
    shape = random.randint(1, 30, size=2)
    return random.rand(*shape) < density, random


def point_clearance(blocked, points, limit=math.inf):
    """Least distance from points (M, 2) in cells to blocked squares, a ring of blocked cells round the map included."""
    rows, columns = np.nonzero(np.pad(blocked, 1, constant_values=True))
    low = np.column_stack([columns, rows]) - 1.0
    gaps = np.maximum(np.maximum(low - points[:, None], points[:, None] - low - 1.0), 0.0)
    return np.minimum(np.hypot(gaps[..., 0], gaps[..., 1]).min(axis=1), limit)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("limit", [0.3, 2.0, 7.3, 100.0])
def test_centre_clearance_is_exact(seed, limit):
    blocked, _ = random_blocked(seed, density=0.03 * (seed % 3))
    centres = np.argwhere(np.ones(blocked.shape, dtype=bool))[:, ::-1] + 0.5
    expected = point_clearance(blocked, centres, limit).reshape(blocked.shape)
    np.testing.assert_allclose(centre_clearance(blocked, limit), expected, atol=1e-5)


@pytest.mark.parametrize("p, q, distance", [
    ((2.0, 2.0), (2.0, 2.0), math.sqrt(2.0)),
    ((-1.0, 0.5), (3.0, 0.5), 0.0),
    ((0.2, 0.2), (0.3, 0.3), 0.0),
    ((-2.0, 1.0), (3.0, 1.0), 0.0),
    ((1.5, -3.0), (1.5, 9.0), 0.5),
    ((2.0, 1.0), (1.0, 2.0), math.sqrt(0.5)),
    ((0.5, -2.0), (0.5, -0.25), 0.25),
])
def test_distance_of_a_segment_from_the_unit_square_by_hand(p, q, distance):
    assert segment_square_distance(p, q, 0, 0) == pytest.approx(distance, abs=1e-12)
    assert segment_square_distance(q, p, 0, 0) == pytest.approx(distance, abs=1e-12)


@pytest.mark.parametrize("seed", range(30))
def test_segment_clearance_against_dense_samples(seed):
    blocked, random = random_blocked(seed, density=0.02)
    size = np.array(blocked.shape[::-1], dtype=float)
    for _ in range(20):
        p = random.rand(2) * size
        q = p if random.rand() < 0.1 else np.clip(p + random.randn(2) * 4.0, 0.0, size)
        if random.rand() < 0.2:
            q = np.array([q[0], p[1]])
        samples = p + (q - p) * np.linspace(0.0, 1.0, 2001)[:, None]
        spacing = math.hypot(*(q - p)) / 2000
        expected = point_clearance(blocked, samples).min()
        found = segment_clearance(blocked, p, q, 1000.0)
        assert expected - spacing / 2 - 1e-9 <= found <= expected + 1e-9
        assert segment_clearance(blocked, p, q, 1.5) == pytest.approx(min(found, 1.5), abs=1e-12)
        early = segment_clearance(blocked, p, q, 1000.0, 2.0)
        assert found <= early + 1e-12 and (early < 2.0) == (found < 2.0)


def test_off_the_map_there_is_no_clearance():
    blocked = np.zeros((4, 4), dtype=bool)
    for outside in [(-0.1, 1.0), (1.0, 4.5), (9.0, 9.0)]:
        assert segment_clearance(blocked, (1.0, 1.0), outside, 3.0) == 0.0
        assert segment_clearance(blocked, outside, (1.0, 1.0), 3.0) == 0.0


def test_a_chain_is_as_near_as_its_nearest_segment():
    blocked = grid_from_text("""
        .......
        .......
        ....#..
        .......
        .......
    """).blocked
    chain = np.array([(1.5, 1.5), (1.5, 3.5), (3.5, 3.5)])
    assert polyline_clearance(blocked, chain[:1], 5.0) == 1.5
    assert polyline_clearance(blocked, chain[:2], 5.0) == 1.5
    assert polyline_clearance(blocked, chain, 5.0) == pytest.approx(math.hypot(0.5, 0.5))
    assert polyline_clearance(blocked, chain, 0.25) == 0.25
