"""How often the fleet's paths used every edge: one heatmap per heading."""

from dataclasses import dataclass
from typing import Sequence, Tuple

import numpy as np

from social_fleet.errors import InvalidInput
from social_fleet.mapping.walls import HEADINGS

# Heading by (row step + 1, column step + 1); -1 stands still.
_HEADING_OF = np.full((3, 3), -1, dtype=np.int64)
_HEADING_OF[HEADINGS[:, 1] + 1, HEADINGS[:, 0] + 1] = np.arange(8)
MOST = int(np.iinfo(np.uint16).max)  # where counts end


def headings_of(cells: np.ndarray) -> np.ndarray:
    """Heading index of every step of a chain of 8-connected (row, column) cells: (M - 1,).

    Raises
    ------
    InvalidInput
        When two cells in succession are not neighbours.
    """
    steps = np.diff(np.asarray(cells, dtype=np.int64).reshape(-1, 2), axis=0)
    if len(steps) and (np.abs(steps).max() > 1 or not steps.any(axis=1).all()):
        raise InvalidInput("a path for the heatmaps must go from cell to neighbouring cell", field="cells")
    return _HEADING_OF[steps[:, 0] + 1, steps[:, 1] + 1]


def edges_of(cells: np.ndarray, shape: Tuple[int, int]) -> np.ndarray:
    """Numbers of the edges that a path of (M, 2) cells (row, column) uses, each once, ascending: (K,) int64.

    Edge (heading, row, column) has the number that it has in an array of (8, rows, columns).

    Raises
    ------
    InvalidInput
        When the cells are no chain of neighbours, or leave the map of `shape`.
    """
    cells = np.asarray(cells, dtype=np.int64).reshape(-1, 2)
    if len(cells) and ((cells < 0).any() or (cells >= shape).any()):
        raise InvalidInput(f"a path leaves the map of {shape[0]} x {shape[1]} cells", field="cells")
    return np.unique((headings_of(cells) * shape[0] + cells[:-1, 0]) * shape[1] + cells[:-1, 1])


@dataclass(frozen=True, eq=False)
class EdgeCounts:
    """How many paths used which edges, without the edges that none used.

    Attributes
    ----------
    shape : (int, int)
        Rows and columns of the map.
    edges : (K,) int64 array
        Numbers of the edges, ascending; see `edges_of`.
    counts : (K,) uint16 array
        How many paths used each, from 1 on; 65535 stands for as many or more.
    """

    shape: Tuple[int, int]
    edges: np.ndarray
    counts: np.ndarray

    @classmethod
    def none(cls, shape: Tuple[int, int]) -> "EdgeCounts":
        """No path at all."""
        return cls(shape, np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.uint16))

    @classmethod
    def total(cls, shape: Tuple[int, int], parts: Sequence["EdgeCounts"]) -> "EdgeCounts":
        """The sum of several, in whatever order.

        Sums end at 65535, so that the order does not matter: a sum that has reached it stays there.
        """
        if not parts:
            return cls.none(shape)
        edges, place = np.unique(np.concatenate([part.edges for part in parts]), return_inverse=True)
        sums = np.bincount(place, np.concatenate([part.counts for part in parts]), len(edges))
        return cls(shape, edges, np.minimum(sums, MOST).astype(np.uint16))

    def __eq__(self, other: object) -> bool:
        return (isinstance(other, EdgeCounts) and self.shape == other.shape
                and np.array_equal(self.edges, other.edges) and np.array_equal(self.counts, other.counts))

    def only(self, keep: np.ndarray) -> "EdgeCounts":
        """Those edges for which `keep` (K,) bool is true."""
        return EdgeCounts(self.shape, self.edges[keep], self.counts[keep])

    @property
    def places(self) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Heading, row and column of every edge."""
        heading, row, column = np.unravel_index(self.edges, (8,) + self.shape)
        return heading, row, column


class Heatmaps:
    """Eight directional heatmaps of one map.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of the map.

    Attributes
    ----------
    counts : (8, rows, cols) uint16 array
        How many paths left a cell in a heading, up to 65535.
    """

    def __init__(self, shape: Tuple[int, int]) -> None:
        self.counts = np.zeros((8,) + tuple(shape), dtype=np.uint16)

    @property
    def shape(self) -> Tuple[int, int]:
        """Rows and columns."""
        return self.counts.shape[1], self.counts.shape[2]

    def add(self, cells: np.ndarray) -> None:
        """Count one path, given as (M, 2) cells (row, column); an edge that it uses twice counts once.

        Raises
        ------
        InvalidInput
            When the cells are no chain of neighbours, or leave the map; nothing is counted then.
        """
        self.add_edges(edges_of(cells, self.shape))

    def add_edges(self, edges: np.ndarray) -> None:
        """Count one path, given as `edges_of` gives it."""
        counts = self.counts.reshape(-1)
        counts[edges] = np.minimum(counts[edges], MOST - 1) + 1

    def add_counts(self, more: EdgeCounts) -> None:
        """Add what others counted on the same map."""
        counts = self.counts.reshape(-1)
        counts[more.edges] = np.minimum(counts[more.edges].astype(np.int64) + more.counts, MOST)

    def forget(self, cells: np.ndarray) -> None:
        """Count as unused all edges that leave or enter the cells (M, 2)."""
        rows, columns = self.shape
        for heading, (across, along) in enumerate(HEADINGS):
            self.counts[heading, cells[:, 0], cells[:, 1]] = 0
            tails = cells - (along, across)
            tails = tails[((tails >= 0) & (tails < (rows, columns))).all(axis=1)]
            self.counts[heading, tails[:, 0], tails[:, 1]] = 0

    def edge_counts(self) -> EdgeCounts:
        """All edges that were used."""
        # One heading at a time: planning in another thread waits only for as long as one takes.
        size = self.shape[0] * self.shape[1]
        used = [np.flatnonzero(self.counts[heading]) + heading * size for heading in range(8)]
        edges = np.concatenate(used)
        return EdgeCounts(self.shape, edges, self.counts.reshape(-1)[edges])
