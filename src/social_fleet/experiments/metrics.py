"""What a driven path is judged by: how near it keeps to its wall, how much it turns, how predictable a route it takes.

Distances are those of rays across the path's own, continuous heading, on the map itself: nothing here knows the eight
headings, the stretches or the caps of the planner's cost.

References
----------
Sato and Law, Socially consistent multi-robot navigation, section 4.1 and Table 2.
"""

import math
from typing import Dict, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np
from numba import njit

from social_fleet.errors import InvalidParameter
from social_fleet.geometry import Polyline
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.simulation.lidar import cast_rays

OPEN_AREA = 7.0  # [m] a vertex with both walls this far away or more does not count in the paper's mean
END_RADIUS = 5.0  # [m] nor does one this near to start or goal

Path = Union[np.ndarray, Polyline]


class WallSamples(NamedTuple):
    """Places along a path with the walls beside them; all arrays have one entry per place.

    Attributes
    ----------
    points : (N, 2) array
        [m, map frame].
    near, far : (N,) arrays
        Distance of the wall on the side that is kept, and of the other [m]; the map's border counts as a wall.
    lengths : (N,) array
        Way that a place stands for [m]; they add up to the path's length.
    ends : (2, 2) array
        The path's start and goal [m, map frame].
    """

    points: np.ndarray
    near: np.ndarray
    far: np.ndarray
    lengths: np.ndarray
    ends: np.ndarray


def wall_samples(grid: OccupancyGrid, path: Path, *, side: str = "right") -> WallSamples:
    """The walls beside a path, once per cell of every segment's digital line.

    That is how densely a grid path has its vertices: a segment that runs d_x, d_y along the grid's axes gets
    max(d_x, d_y) / resolution places (rounded up), in the middles of as many equal pieces.

    Parameters
    ----------
    grid : OccupancyGrid
        Occupied and unknown cells stop a ray, where it enters them.
    path : (N, 2) array or Polyline
        [m, map frame].
    side : str
        ``right`` or ``left``: which wall is `near`.

    Raises
    ------
    InvalidParameter
        When the side is neither.
    """
    if side not in ("right", "left"):
        raise InvalidParameter(f"must be right or left, not {side!r}", field="side")
    line = _polyline(path)
    corners = grid.to_local(line.points) / grid.resolution
    steps = np.diff(corners, axis=0)
    counts = np.maximum(np.ceil(np.abs(steps).max(axis=1, initial=0.0) - 1e-6), 1).astype(np.int64)
    which, shares = _pieces(counts)
    local = corners[which] + shares[:, None] * steps[which]
    headings = np.arctan2(steps[which, 1], steps[which, 0])
    # A rim of blocked cells is the border as a wall.
    walls = np.pad(grid.blocked, 1, constant_values=True)
    quarter = 0.5 * math.pi if side == "left" else -0.5 * math.pi
    near, far = (grid.resolution * _ranges(walls, local + 1.0, headings + turn) for turn in (quarter, -quarter))
    lengths = np.diff(line.arc_lengths)[which] / counts[which]
    return WallSamples(grid.from_local(local * grid.resolution), near, far, lengths, line.points[[0, -1]])


@njit(cache=True)
def _ranges(walls: np.ndarray, places: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Distance from each place to the wall in its own direction, in cells."""
    ranges = np.empty(len(places))
    for index in range(len(places)):
        ranges[index] = cast_rays(walls, places[index, 0], places[index, 1], angles[index:index + 1], np.inf)[0]
    return ranges


def paper_wall_distance(samples: WallSamples, *, open_area: float = OPEN_AREA,
                        end_radius: float = END_RADIUS) -> Optional[float]:
    """Mean distance of the wall that is kept [m] by the rule of the paper's Table 2.

    The mean is over places, one per cell, whatever way they stand for. A place is dropped where both walls are
    `open_area` away or more, and within `end_radius` of the path's start or goal as the crow flies.

    Returns
    -------
    float or None
        None where no place is left.
    """
    gaps = np.hypot(*(samples.points[:, None] - samples.ends[None]).transpose(2, 0, 1)).min(axis=1)
    kept = (np.minimum(samples.near, samples.far) < open_area) & (gaps > end_radius)
    return float(samples.near[kept].mean()) if kept.any() else None


def mean_wall_distance(samples: WallSamples) -> Optional[float]:
    """Mean distance of the wall that is kept [m] over the path's arc length, all of it; None for no way at all."""
    total = float(samples.lengths.sum())
    return float(samples.near @ samples.lengths) / total if total > 0.0 else None


def median_wall_distance(samples: WallSamples) -> Optional[float]:
    """Distance of the wall that is kept [m] which half of the way does not exceed; None for no way at all.

    Nothing is left out, and yet a look down a side corridor of forty metres weighs no more than its width.
    """
    if not len(samples.lengths):
        return None
    order = np.argsort(samples.near, kind="stable")
    driven = np.cumsum(samples.lengths[order])
    return float(samples.near[order][np.searchsorted(driven, 0.5 * driven[-1])])


def right_distance(grid: OccupancyGrid, path: Path) -> Optional[float]:
    """`paper_wall_distance` of the right-hand wall [m]: the figure of the paper's Table 2."""
    return paper_wall_distance(wall_samples(grid, path))


def heading_change(path: Path) -> float:
    """Sum of the turns at all vertices, either way [rad]."""
    turns = np.diff(_polyline(path).segment_headings)
    return float(np.abs((turns + math.pi) % (2.0 * math.pi) - math.pi).sum())


def heading_change_per_metre(paths: Sequence[Path]) -> float:
    """Turns of all paths together over the way of all together [rad/m]; 0 without any way."""
    way = sum(_polyline(path).length for path in paths)
    return sum(map(heading_change, paths)) / way if way > 0.0 else 0.0


class Predictability(NamedTuple):
    """How well a place tells where a robot that drives through it is heading.

    Attributes
    ----------
    entropy : float
        Shannon entropy of the eight headings in a square [bit], averaged over the metres driven; 0: always the same.
    squares : int
        Squares that are driven through.
    paths_per_square : float
        Different paths through a square that is driven through, on average: the more, the more routes are shared.
    """

    entropy: float
    squares: int
    paths_per_square: float


def predictability(paths: Sequence[Path], *, square: float = 0.5) -> Predictability:
    """Entropy of headings per square of the plane, over many paths.

    In each square, p_k is the share of the metres driven there within 22.5 degrees of heading k * 45 degrees;
    its entropy is -sum p_k log2 p_k, and squares weigh in by their metres.

    Parameters
    ----------
    paths : sequence of (N, 2) arrays or Polylines
        [m, map frame].
    square : float
        Edge of a square [m]; about a robot's width. It is not the map's cell, so that maps of any resolution compare.

    Raises
    ------
    InvalidParameter
        When `square` is not positive.
    """
    if not square > 0.0:
        raise InvalidParameter(f"must be a positive number of metres, not {square}", field="square")
    metres: Dict[Tuple[int, int], np.ndarray] = {}
    visits = 0
    for path in paths:
        own = _metres_by_square(_polyline(path), square)
        visits += len(own)
        for place, driven in own.items():
            metres[place] = metres.get(place, np.zeros(8)) + driven
    if not metres:
        return Predictability(0.0, 0, 0.0)
    table = np.array(list(metres.values()))
    use = table.sum(axis=1)
    shares = table / use[:, None]
    entropies = -np.where(shares > 0.0, shares * np.log2(np.where(shares > 0.0, shares, 1.0)), 0.0).sum(axis=1)
    return Predictability(float(entropies @ use / use.sum()) + 0.0, len(metres), visits / len(metres))


def _metres_by_square(line: Polyline, square: float) -> Dict[Tuple[int, int], np.ndarray]:
    """Metres driven in each of eight headings, by square of the plane; in pieces of at most an eighth of a square."""
    steps = np.diff(line.points, axis=0)
    counts = np.ceil(np.hypot(*steps.T) / (0.125 * square)).astype(np.int64)
    which, shares = _pieces(counts)
    middles = line.points[which] + shares[:, None] * steps[which]
    headings = np.rint(line.segment_headings[which] / (0.25 * math.pi)).astype(np.int64) % 8
    lengths = (np.diff(line.arc_lengths) / counts)[which]
    squares = np.floor(middles / square).astype(np.int64)
    places, index = np.unique(squares, axis=0, return_inverse=True)
    table = np.zeros((len(places), 8))
    np.add.at(table, (index, headings), lengths)
    return {(int(x), int(y)): row for (x, y), row in zip(places, table)}


def _pieces(counts: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Segments in `counts` equal pieces each: a piece's segment, and where on it the piece's middle lies (0 to 1)."""
    which = np.repeat(np.arange(len(counts)), counts)
    order = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
    return which, (order + 0.5) / counts[which]


def _polyline(path: Path) -> Polyline:
    return path if isinstance(path, Polyline) else Polyline(path)
