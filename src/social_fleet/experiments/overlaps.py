"""How much the paths of a fleet get into each other's way: what Figure 11 counts."""

import math
from typing import List, NamedTuple, Sequence

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


def overlapping(paths: Sequence[Polyline], distance: float) -> List[np.ndarray]:
    """For each path the middles (K, 2) [m] of its segments that another robot's path overlaps and does not run along.

    Two segments overlap when their middles are closer than `distance` [m], and are left out when their headings differ
    by no more than 45 degrees: robots that drive there follow each other. A segment counts once, however many overlap
    it.
    """
    pieces = [segments_of(path) for path in paths]
    owners = np.repeat(np.arange(len(paths)), [len(piece.middles) for piece in pieces])
    middles = np.concatenate([piece.middles for piece in pieces])
    headings = np.concatenate([piece.headings for piece in pieces])
    close = cKDTree(middles).query_pairs(distance, output_type="ndarray").reshape(-1, 2)
    one, two = close.T
    turns = np.abs((headings[one] - headings[two] + math.pi) % (2.0 * math.pi) - math.pi)
    meeting = close[(owners[one] != owners[two]) & (turns > ALONG)]
    marked = np.zeros(len(middles), dtype=bool)
    marked[meeting.ravel()] = True
    return [middles[marked & (owners == index)] for index in range(len(paths))]
