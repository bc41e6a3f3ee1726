"""Which places a robot can drive between, when discs are closed to it."""

from typing import Sequence, Tuple

import numpy as np
from scipy import ndimage

from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.lattice import Lattice
from social_fleet.planning.overlays.discs import Disc, covered_nodes, local_discs

_BESIDE = 4  # cells from a place to the nearest node that counts as its own


class Regions:
    """The connected parts of a lattice.

    Parameters
    ----------
    grid : OccupancyGrid
    lattice : Lattice
        Where the robot's centre may be.
    avoid : sequence of Disc
        Where it may not.
    """

    def __init__(self, grid: OccupancyGrid, lattice: Lattice, avoid: Sequence[Disc] = ()) -> None:
        self._grid = grid
        free = lattice.node >= 0
        closed = covered_nodes(lattice.node, local_discs(grid, avoid))
        free[lattice.row[closed], lattice.col[closed]] = False
        self._labels = ndimage.label(free)[0]

    def holding(self, places: np.ndarray) -> np.ndarray:
        """The number of the part that each of some places (M, 2) [m] lies in; 0 for none."""
        return self._looked_up(places)[0]

    def of(self, places: np.ndarray) -> np.ndarray:
        """The number of the part that each of some places (M, 2) [m] lies in, or just beside; 0 for none."""
        labels, rows, columns = self._looked_up(places)
        for index in np.flatnonzero(labels == 0):
            labels[index] = self._beside(rows[index], columns[index])
        return labels

    def _looked_up(self, places: np.ndarray) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The labels at some places, and their rows and columns."""
        rows, columns = np.floor(self._grid.to_local(places) / self._grid.resolution).astype(int).T[::-1]
        inside = (rows >= 0) & (rows < self._labels.shape[0]) & (columns >= 0) & (columns < self._labels.shape[1])
        labels = np.zeros(len(rows), dtype=self._labels.dtype)
        labels[inside] = self._labels[rows[inside], columns[inside]]
        return labels, rows, columns

    def touching(self, disc: Disc) -> np.ndarray:
        """The numbers of all parts that a disc touches."""
        part = self._round(disc)[0]
        return np.unique(part[part > 0])

    def may_be_cut_by(self, disc: Disc) -> bool:
        """Whether closing one more disc could divide a part: False where what is left round it hangs together."""
        part, gaps = self._round(disc)
        return bool(ndimage.label((part > 0) & (gaps > disc.radius / self._grid.resolution + 1.0))[1] > 1)

    def _round(self, disc: Disc) -> Tuple[np.ndarray, np.ndarray]:
        """The numbers round a disc, and how far [cells] each cell's centre is from the disc's."""
        x, y = self._grid.to_local([(disc.x, disc.y)])[0] / self._grid.resolution
        reach = disc.radius / self._grid.resolution + 4.0
        top, left = max(int(y - reach), 0), max(int(x - reach), 0)
        part = self._labels[top:int(y + reach) + 1, left:int(x + reach) + 1]
        rows, columns = np.ogrid[:part.shape[0], :part.shape[1]]
        return part, np.hypot(rows + top + 0.5 - y, columns + left + 0.5 - x)

    def _beside(self, row: int, column: int) -> int:
        low_row, low_column = max(row - _BESIDE, 0), max(column - _BESIDE, 0)
        part = self._labels[low_row:row + _BESIDE + 1, low_column:column + _BESIDE + 1]
        rows, columns = np.nonzero(part)
        if not len(rows):
            return 0
        nearest = np.argmin(np.hypot(rows + low_row - row, columns + low_column - column))
        return int(part[rows[nearest], columns[nearest]])
