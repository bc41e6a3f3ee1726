"""How much the paths of a fleet get into each other's way: what Figure 11 counts."""

import math
from typing import NamedTuple, Sequence

import numpy as np
from scipy.spatial import cKDTree

from social_fleet.geometry import Polyline

SEGMENT = 0.2  # [m] the cell of the paper's Environment 1: a path segment there leads from one cell to the next
ALONG = 0.25 * math.pi  # [rad] headings that differ by no more go the same direction


class Segments(NamedTuple):
    """A path in pieces: middles (N, 2) [m, map frame] and headings (N,) [rad]."""

    middles: np.ndarray
    headings: np.ndarray


def segments_of(path: Polyline) -> Segments:
    """`path` in equal pieces of about `SEGMENT`."""
    count = max(int(round(path.length / SEGMENT)), 1)
    middles = (np.arange(count) + 0.5) * path.length / count
    which = np.clip(np.searchsorted(path.arc_lengths, middles, "right") - 1, 0, len(path.segment_headings) - 1)
    return Segments(path.position(middles), path.segment_headings[which])


class Overlaps(NamedTuple):
    """Segments in which a fleet's robots get into each other's way: middles (K, 2) [m], and `sizes` (K,).

    Segment k is one already in the fleet of the first `sizes[k]` robots.
    """

    middles: np.ndarray
    sizes: np.ndarray

    def count(self, size: int) -> int:
        """How many there are in the fleet of the first `size` robots."""
        return int((self.sizes <= size).sum())


def overlaps_of(paths: Sequence[Polyline], distance: float) -> Overlaps:
    """The segments that another robot's path overlaps and does not run along.

    Two segments overlap when their middles are closer than `distance` [m], and are left out when their headings differ
    by no more than 45 degrees: robots that drive there follow each other. A segment counts once, however many overlap
    it.
    """
    pieces = [segments_of(path) for path in paths]
    owners = np.repeat(np.arange(len(paths)), [len(piece.middles) for piece in pieces])
    middles = np.concatenate([piece.middles for piece in pieces])
    headings = np.concatenate([piece.headings for piece in pieces])
    one, two = cKDTree(middles).query_pairs(distance, output_type="ndarray").reshape(-1, 2).T
    turns = np.abs((headings[one] - headings[two] + math.pi) % (2.0 * math.pi) - math.pi)
    meeting = (owners[one] != owners[two]) & (turns > ALONG)
    one, two = one[meeting], two[meeting]
    sizes = np.full(len(middles), len(paths) + 1)
    for segment in (one, two):
        np.minimum.at(sizes, segment, np.maximum(owners[one], owners[two]) + 1)
    found = sizes <= len(paths)
    return Overlaps(middles[found], sizes[found])
