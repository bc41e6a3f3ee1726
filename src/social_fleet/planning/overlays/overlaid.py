"""A map with obstacles drawn in: what changes for a plan of one robot size, and only where it changes."""

import threading
from typing import List, NamedTuple, Sequence, Tuple

import numpy as np
from numba import njit

from social_fleet.errors import InvalidGoal, InvalidOverlay, InvalidStart
from social_fleet.geometry import Polyline
from social_fleet.mapping.clearance import TOUCH_TOLERANCE, ConfigurationSpace
from social_fleet.mapping.distances import centre_clearance, segment_clearance
from social_fleet.planning.lattice import DCOL, DROW, Lattice, Links, fitting_radius
from social_fleet.planning.overlays.overlay_set import Overlay, Overlays, as_overlays
from social_fleet.planning.overlays.raster import Raster, rasterised

_REMEMBERED = 4  # sets of obstacles whose arrays are kept


class Overlaid(NamedTuple):
    """What planning looks at.

    Attributes
    ----------
    overlays : tuple of Overlay
        The obstacles.
    rasters : tuple of Raster
        Their cells.
    blocked : (rows, columns) bool array
        The map's blocked cells and those of the obstacles.
    clearance : (rows, columns) float32 array
        Distance [m] of cell centres to the nearest of them, as `ConfigurationSpace` tells it.
    closed : (M,) int array
        Nodes without which no edge of the lattice comes nearer to an obstacle than the disc and its margin allow.
    closed_cells : (K, 2) int array
        (row, column) of these, and of the cells about the obstacles that were no nodes before.
    """

    overlays: Tuple[Overlay, ...]
    rasters: Tuple[Raster, ...]
    blocked: np.ndarray
    clearance: np.ndarray
    closed: np.ndarray
    closed_cells: np.ndarray


class OverlaidMaps:
    """The map of one lattice with obstacles drawn in; the last few results are remembered.

    Parameters
    ----------
    space, way : ConfigurationSpace
        The map for the robot's radius, and for the radius with the margin kept on the way.
    lattice : Lattice
        Of `way`.
    """

    def __init__(self, space: ConfigurationSpace, way: ConfigurationSpace, lattice: Lattice) -> None:
        self._space = space
        self._way = way
        self._lattice = lattice
        self._lock = threading.Lock()
        no_cells = np.zeros((0, 2), dtype=np.int64)
        self._known: List[Overlaid] = []
        self._plain = Overlaid((), (), space.grid.blocked, space.clearance, no_cells[:, 0], no_cells)

    def of(self, overlays: Overlays) -> Overlaid:
        """The map with these obstacles.

        Raises
        ------
        InvalidOverlay
            When one lies off the map; the message names it.
        """
        wanted = as_overlays(overlays)
        if not wanted:
            return self._plain
        with self._lock:
            for known in self._known:
                if known.overlays == wanted:
                    return known
            drawn = self._draw(wanted)
            self._known = [drawn] + self._known[:_REMEMBERED - 1]
            return drawn

    def _draw(self, overlays: Tuple[Overlay, ...]) -> Overlaid:
        grid = self._space.grid
        rasters = []
        blocked, clearance = grid.blocked.copy(), self._space.clearance.copy()
        for overlay in overlays:
            try:
                raster = rasterised(grid, overlay.shape)
            except InvalidOverlay as error:
                raise InvalidOverlay(error.message, field=overlay.name) from error
            rasters.append(raster)
            rows, columns = raster.mask.shape
            blocked[raster.row:raster.row + rows, raster.column:raster.column + columns] |= raster.mask
        cells = [self._close(raster, blocked, clearance) for raster in rasters]
        closed_cells = np.unique(np.concatenate(cells), axis=0)
        # As the map's own arrays are: for others, all kernels would have to be compiled once more.
        blocked.setflags(write=False)
        clearance.setflags(write=False)
        nodes = self._lattice.node[closed_cells[:, 0], closed_cells[:, 1]]
        return Overlaid(overlays, tuple(rasters), blocked, clearance, nodes[nodes >= 0], closed_cells)

    def _close(self, raster: Raster, blocked: np.ndarray, clearance: np.ndarray) -> np.ndarray:
        """Lower `clearance` about an obstacle, and return the cells (K, 2) to be closed."""
        resolution = self._space.grid.resolution
        limit = max(self._space.limit, self._way.limit) / resolution + 1.0
        row, column, field = _field(raster, int(np.ceil(limit)), limit, blocked.shape)
        window = clearance[row:row + field.shape[0], column:column + field.shape[1]]
        np.minimum(window, field * np.float32(resolution), out=window)
        shut = field < (self._way.radius - TOUCH_TOLERANCE) / resolution
        _shut_pinched(self._lattice.links, self._lattice.node, blocked, field, shut, row, column,
                      fitting_radius(self._way))
        return np.argwhere(shut) + (row, column)


def check_clear(overlaid: Overlaid, space: ConfigurationSpace, x: float, y: float, what: str) -> None:
    """Refuse a pose [m] that is fine on the map, but where the robot's disc would overlap an obstacle.

    Raises
    ------
    InvalidStart, InvalidGoal
        As `what` is ``start`` or ``goal``; the message names the obstacle.
    """
    grid = space.grid
    place = grid.to_local([(x, y)])[0] / grid.resolution
    for overlay, raster in zip(overlaid.overlays, overlaid.rasters):
        gaps = np.maximum(np.abs(raster.cells[:, ::-1] + 0.5 - place) - 0.5, 0.0)
        gap = float(np.hypot(gaps[:, 0], gaps[:, 1]).min()) * grid.resolution
        if gap < space.radius - TOUCH_TOLERANCE:
            reason = "lies in" if gap <= 0.0 else f"is {gap:.2f} m from"
            room = "" if gap <= 0.0 else f", closer than the robot's radius of {space.radius:g} m"
            error = InvalidStart if what == "start" else InvalidGoal
            raise error(f"({x:.2f}, {y:.2f}) {reason} the obstacle '{overlay.name}'{room}; "
                        "choose another place, or clear the obstacle when it is gone", field=what)


def near_overlays(overlays: Sequence[Overlay], points: np.ndarray, distance: float) -> Tuple[str, ...]:
    """Names of the obstacles that are not permanent and that the path through `points` (N, 2) [m] comes near to.

    Parameters
    ----------
    distance : float
        How near [m].
    """
    passing = [overlay for overlay in overlays if not overlay.permanent]
    if not passing:
        return ()
    path = Polyline(points)
    # Between two places a tenth of the distance apart, a path comes less than a thousandth of it nearer.
    places = path.position(np.linspace(0.0, path.length, 2 + int(path.length / max(0.1 * distance, 0.02))))
    names = []
    for overlay in passing:
        corners = overlay.shape.extent
        low, high = corners.min(axis=0) - distance, corners.max(axis=0) + distance
        close = places[((places >= low) & (places <= high)).all(axis=1)]
        if len(close) and overlay.shape.distances(close).min() <= distance:
            names.append(overlay.name)
    return tuple(names)


def _field(raster: Raster, reach: int, limit: float, shape: Tuple[int, ...]) -> Tuple[int, int, np.ndarray]:
    """Distances [cells] to an obstacle's cells alone, capped at `limit`, and the cell where the array begins."""
    # Twice the reach: what lies beyond the padding counts as blocked, and must be too far away to matter.
    padded = centre_clearance(np.pad(raster.mask, 2 * reach), limit)
    row, column = raster.row - 2 * reach, raster.column - 2 * reach
    low_row, low_column = max(raster.row - reach, 0), max(raster.column - reach, 0)
    high_row = min(raster.row + raster.mask.shape[0] + reach, shape[0])
    high_column = min(raster.column + raster.mask.shape[1] + reach, shape[1])
    return low_row, low_column, padded[low_row - row:high_row - row, low_column - column:high_column - column]


@njit(cache=True)
def _shut_pinched(links: Links, node: np.ndarray, blocked: np.ndarray, field: np.ndarray, shut: np.ndarray, row: int,
                  column: int, radius: float) -> None:
    """Shut the nearer end of every edge that passes an obstacle's corner too closely between two ends that do not.

    `field` and `shut` begin at (row, column) of the map. Between two ends at a distance d, an edge of length h comes
    as near as sqrt(d^2 - h^2/4); only edges for which that is too near are checked.
    """
    rows, columns = field.shape
    for r in range(rows):
        for c in range(columns):
            n = node[row + r, column + c]
            if n < 0 or shut[r, c]:
                continue
            for k in range(4):
                r2, c2 = r + DROW[k], c + DCOL[k]
                if not links.edges[n] >> k & 1 or r2 >= rows or c2 < 0 or c2 >= columns or shut[r2, c2]:
                    continue
                nearest = min(field[r, c], field[r2, c2])
                if nearest * nearest >= radius * radius + (0.25 if k % 2 == 0 else 0.5) + 1e-4:
                    continue
                ends = (column + c + 0.5, row + r + 0.5), (column + c2 + 0.5, row + r2 + 0.5)
                if segment_clearance(blocked, ends[0], ends[1], radius, radius) < radius:
                    if field[r, c] <= field[r2, c2]:
                        shut[r, c] = True
                        break
                    shut[r2, c2] = True
