"""How often the fleet's paths used every edge: one heatmap per heading."""

from typing import Tuple

import numpy as np

from social_fleet.errors import InvalidInput
from social_fleet.mapping.walls import HEADINGS

# Heading by (row step + 1, column step + 1); -1 stands still.
_HEADING_OF = np.full((3, 3), -1, dtype=np.int64)
_HEADING_OF[HEADINGS[:, 1] + 1, HEADINGS[:, 0] + 1] = np.arange(8)
_MOST = np.iinfo(np.uint16).max


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
        cells = np.asarray(cells, dtype=np.int64).reshape(-1, 2)
        if len(cells) and ((cells < 0).any() or (cells >= self.shape).any()):
            raise InvalidInput(f"a path leaves the map of {self.shape[0]} x {self.shape[1]} cells", field="cells")
        headings = headings_of(cells)
        used = (headings, cells[:-1, 0], cells[:-1, 1])
        self.counts[used] = np.minimum(self.counts[used], _MOST - 1) + 1
