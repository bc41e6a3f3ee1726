"""Conflicting links and their connected regions, against a dense matrix and an image labelling."""

from typing import List, Tuple

import numpy as np
import pytest
from fleets import random_path
from scipy import ndimage

from social_fleet.coordination.conflict_regions import LINK, Links, conflict_regions, cut_into_links
from social_fleet.geometry import Polyline


def gaps_to_segments(points: np.ndarray, tails: np.ndarray, heads: np.ndarray) -> np.ndarray:
    """Distance of each of P points to each of S segments (P, S) [m]."""
    steps = heads - tails
    squares = np.maximum(np.einsum("ij,ij->i", steps, steps), 1e-30)
    offsets = points[:, None] - tails[None]
    along = np.clip(np.einsum("psj,sj->ps", offsets, steps) / squares, 0.0, 1.0)
    return np.hypot(*np.moveaxis(offsets - along[..., None] * steps[None], -1, 0))


def crossing(r: Links, s: Links) -> np.ndarray:
    """Which links properly cross (R, S): the ends of either lie on two sides of the other."""
    def side(tails: np.ndarray, heads: np.ndarray, points: np.ndarray) -> np.ndarray:
        steps, offsets = (heads - tails)[:, None], points[None] - tails[:, None]
        return steps[..., 0] * offsets[..., 1] - steps[..., 1] * offsets[..., 0]
    of_s = side(r.tails, r.heads, s.tails) * side(r.tails, r.heads, s.heads)
    of_r = side(s.tails, s.heads, r.tails) * side(s.tails, s.heads, r.heads)
    return (of_s < 0.0) & (of_r.T < 0.0)


def link_gaps(r: Links, s: Links) -> np.ndarray:
    """Distance of all links (R, S) [m]."""
    of_r = [gaps_to_segments(ends, s.tails, s.heads) for ends in (r.tails, r.heads)]
    of_s = [gaps_to_segments(ends, r.tails, r.heads).T for ends in (s.tails, s.heads)]
    return np.where(crossing(r, s), 0.0, np.minimum.reduce(of_r + of_s))


def regions(r: Links, s: Links, distance: float) -> List[frozenset]:
    """The regions found, as sets of link pairs."""
    runs, labels = conflict_regions(r, s, distance)
    return [frozenset((int(i), j) for i, low, high in runs[labels == label] for j in range(low, high + 1))
            for label in range(labels.max(initial=-1) + 1)]


def expected(r: Links, s: Links, distance: float) -> Tuple[set, np.ndarray]:
    gaps = link_gaps(r, s)
    marks, count = ndimage.label(gaps < distance, structure=np.ones((3, 3)))
    return {frozenset(map(tuple, np.argwhere(marks == mark).tolist())) for mark in range(1, count + 1)}, gaps


def test_links_cover_the_path_and_mark_its_ends() -> None:
    links = cut_into_links(Polyline([(0, 0), (0.25, 0), (0.25, 1.0)]))
    assert links.starts[0] == links.ends[0] == 0.0 and links.starts[-1] == links.ends[-1] == 1.25
    assert np.array_equal(links.starts[2:], links.ends[1:-1]), "one begins where the other ends"
    assert (links.ends - links.starts).max() <= LINK + 1e-12
    assert np.hypot(*(links.heads - links.tails).T) == pytest.approx(links.ends - links.starts), "none cuts a corner"
    assert len(cut_into_links(Polyline([(3, 3)])).starts) == 2


@pytest.mark.parametrize("seed", range(30))
def test_random_paths_against_the_dense_matrix(seed: int) -> None:
    rng = np.random.RandomState(seed)
    r, s = (cut_into_links(Polyline(random_path(rng, rng.randint(1, 8), 4.0))) for _ in range(2))
    distance = rng.uniform(0.3, 1.0)
    wanted, gaps = expected(r, s, distance)
    if np.abs(gaps - distance).min() < 1e-9:
        pytest.skip("a gap that is the distance but for rounding")
    found = regions(r, s, distance)
    assert set(found) == wanted
    assert len(found) == len(wanted)


@pytest.mark.parametrize("name, r, s, count", [
    ("a crossing", [(-3, 0), (3, 0)], [(0, -3), (0, 3)], 1),
    ("head-on along a corridor", [(0, 0), (9, 0)], [(9, 0), (0, 0)], 1),
    ("lanes side by side", [(0, 0), (9, 0)], [(0, 1), (9, 1)], 0),
    ("the same place crossed three times", [(-3, 0), (3, 0)], [(0, -2), (0, 2), (0.1, -2), (0.2, 2)], 3),
    ("a U-turn across a lane", [(-3, 0), (3, 0)], [(0, -2), (0, 0.5), (0.2, -2)], 1),
    ("a U-turn that ends before the lane", [(-3, 0), (3, 0)], [(0, -2), (0, -0.7), (0.2, -2)], 0),
    ("two corridors shared", [(0, 0), (9, 0)], [(0, 0), (3, 0), (3, 3), (6, 3), (6, 0), (9, 0)], 2),
    ("a path that crosses itself, and there the other", [(-3, 0), (3, 0), (3, 3), (0, 3), (0, -3)],
     [(-3, -3), (3, 3)], 3)])
def test_counts_by_hand(name: str, r: list, s: list, count: int) -> None:
    assert len(regions(cut_into_links(Polyline(r)), cut_into_links(Polyline(s)), 0.7)) == count, name


def test_the_order_of_the_two_paths_does_not_matter() -> None:
    rng = np.random.RandomState(99)
    r, s = (cut_into_links(Polyline(random_path(rng, 7, 4.0))) for _ in range(2))
    swapped = {frozenset((i, j) for j, i in region) for region in regions(s, r, 0.6)}
    assert set(regions(r, s, 0.6)) == swapped
