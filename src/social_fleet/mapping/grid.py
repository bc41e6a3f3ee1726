"""The occupancy grid, and the frame in which its cells lie.

Index order is (row, column) with row 0 at the bottom, as nav_msgs/OccupancyGrid has it. Cell (row, column) covers
[column, column + 1) x [row, row + 1) resolutions along the grid's own axes, which start at `origin`, yaw included.
"""

import hashlib
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Sequence, Tuple, Union

import numpy as np

from social_fleet.errors import InvalidMap, InvalidPose
from social_fleet.geometry import Pose

UNKNOWN = -1
FREE = 0
OCCUPIED = 100
BLOCKED_FROM = 50  # a cell that is as likely a wall as not is no place for a robot

# A coordinate this close to a cell's edge [cells] lies on it: 0.6 m is three cells of 0.2 m, though 0.6 / 0.2 < 3.
_ON_THE_EDGE = 1e-9

FINEST, COARSEST = 1e-3, 1e3  # [m] of a cell's edge
FARTHEST = 1e8  # [m] of a map's origin from the frame's; beyond it a float tells no micrometres apart

Points = Union[np.ndarray, Sequence[Sequence[float]]]


@dataclass(frozen=True, eq=False)
class OccupancyGrid:
    """A map of free, occupied and unknown cells. Immutable; equal when every value, the resolution and the origin are.

    Parameters
    ----------
    values : (rows, columns) array_like of int
        -1 unknown, 0 free to 100 occupied; row 0 is the bottom row. Copied.
    resolution
        Edge length of a cell [m].
    origin
        Pose of cell (0, 0)'s lower left corner in the map frame [m, m, rad].

    Raises
    ------
    InvalidMap
        `field` names the parameter.
    """

    values: np.ndarray
    resolution: float
    origin: Pose = Pose(0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", _checked_values(self.values))
        object.__setattr__(self, "resolution", _checked_resolution(self.resolution))
        object.__setattr__(self, "origin", _checked_origin(self.origin))

    @property
    def shape(self) -> Tuple[int, int]:
        """Numbers of rows and columns."""
        return self.values.shape[0], self.values.shape[1]

    @property
    def size(self) -> Tuple[float, float]:
        """Extent along the grid's column and row axes [m]."""
        return self.shape[1] * self.resolution, self.shape[0] * self.resolution

    @cached_property
    def blocked(self) -> np.ndarray:
        """Where no robot may be: cells that are unknown or at least 50 % occupied, (rows, columns) bool, read-only."""
        blocked = (self.values == UNKNOWN) | (self.values >= BLOCKED_FROM)
        blocked.setflags(write=False)
        return blocked

    @cached_property
    def digest(self) -> str:
        """SHA-256 (hex) of values, resolution and origin: what is learnt on this map is keyed by it."""
        header = np.array([*self.shape, self.resolution, *self.origin], dtype="<f8") + 0.0
        return hashlib.sha256(header.tobytes() + self.values.tobytes()).hexdigest()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, OccupancyGrid) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def to_local(self, points: Points) -> np.ndarray:
        """Points (M, 2) [m] of the map frame, in metres along the grid's column and row axes."""
        offsets = np.asarray(points, dtype=float) - self.origin[:2]
        with np.errstate(invalid="ignore"):  # a point that is not finite stays so, quietly
            return offsets @ _rotation(self.origin.yaw)

    def from_local(self, points: Points) -> np.ndarray:
        """Points (M, 2) in metres along the grid's column and row axes, in the map frame."""
        return np.asarray(points, dtype=float) @ _rotation(self.origin.yaw).T + self.origin[:2]

    def contains(self, x: float, y: float) -> bool:
        """Whether (x, y) [m] of the map frame lies in a cell of the map."""
        return bool(self._inside(self._indices([(x, y)]))[0])

    def cell(self, x: float, y: float) -> Tuple[int, int]:
        """(row, column) of the cell that holds (x, y) [m] of the map frame.

        Raises
        ------
        InvalidPose
            When the point is not finite or off the map.
        """
        row, column = self.cells([(x, y)])[0]
        return int(row), int(column)

    def cells(self, points: Points) -> np.ndarray:
        """(row, column) of the cells that hold the points (M, 2) [m] of the map frame: shape (M, 2) int64.

        Raises
        ------
        InvalidPose
            When a point is not finite or off the map.
        """
        points = np.asarray(points, dtype=float).reshape(-1, 2)
        indices = self._indices(points)
        inside = self._inside(indices)
        if not inside.all():
            x, y = points[int(np.argmin(inside))]
            raise InvalidPose(f"({x:.2f}, {y:.2f}) {self._why_outside(x, y)}")
        return indices.astype(np.int64)

    def centre(self, row: int, column: int) -> Tuple[float, float]:
        """Centre (x, y) [m] of a cell in the map frame."""
        x, y = self.centres([(row, column)])[0]
        return float(x), float(y)

    def centres(self, cells: Union[np.ndarray, Sequence[Sequence[int]]]) -> np.ndarray:
        """Centres (M, 2) [m] in the map frame of the cells (M, 2) given as (row, column)."""
        cells = np.asarray(cells).reshape(-1, 2)
        return self.from_local((cells[:, ::-1] + 0.5) * self.resolution)

    def _indices(self, points: Points) -> np.ndarray:
        """(row, column) as whole floats, off the map and NaN included."""
        return np.floor(self.to_local(points)[:, ::-1] / self.resolution + _ON_THE_EDGE)

    def _inside(self, indices: np.ndarray) -> np.ndarray:
        # NaN compares false, which is the wanted answer
        with np.errstate(invalid="ignore"):
            return ((indices >= 0) & (indices < self.shape)).all(axis=1)

    def _why_outside(self, x: float, y: float) -> str:
        if not (math.isfinite(x) and math.isfinite(y)):
            return "is not finite"
        corners = self.from_local([(0, 0), (self.size[0], 0), self.size, (0, self.size[1])])
        low, high = corners.min(axis=0), corners.max(axis=0)
        return (f"is off the map, which lies within x {low[0]:.2f} to {high[0]:.2f} m "
                f"and y {low[1]:.2f} to {high[1]:.2f} m")


def _rotation(yaw: float) -> np.ndarray:
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array([[cos, -sin], [sin, cos]])


def _checked_values(values: Any) -> np.ndarray:
    array = np.asarray(values)
    if array.ndim != 2 or array.size == 0:
        raise InvalidMap(f"needs rows and columns of cells, not an array of shape {array.shape}", field="values")
    if array.dtype.kind not in "iu":
        raise InvalidMap(f"must be whole numbers from -1 to 100, not {array.dtype}", field="values")
    low, high = array.min(), array.max()
    if low < UNKNOWN or high > OCCUPIED:
        raise InvalidMap(f"must be -1 (unknown) or 0 to 100, not {low if low < UNKNOWN else high}", field="values")
    array = np.array(array, dtype=np.int8, order="C")
    array.setflags(write=False)
    return array


def _checked_resolution(resolution: Any) -> float:
    try:
        value = float(resolution)
    except (TypeError, ValueError, OverflowError):
        raise InvalidMap(f"must be a number of metres per cell, not {resolution!r}", field="resolution") from None
    if not FINEST <= value <= COARSEST:
        raise InvalidMap(f"must be a number of metres per cell from {FINEST:g} to {COARSEST:g}, not {resolution}",
                         field="resolution")
    return value


def _checked_origin(origin: Any) -> Pose:
    try:
        pose = Pose(*(float(part) for part in origin))
    except (TypeError, ValueError, OverflowError):
        raise InvalidMap(f"must be x, y and yaw, not {origin!r}", field="origin") from None
    if not all(map(math.isfinite, pose)):
        raise InvalidMap(f"must be finite, not {tuple(pose)}", field="origin")
    if max(abs(pose.x), abs(pose.y)) > FARTHEST:
        raise InvalidMap(f"must lie within {FARTHEST:g} m of the frame's, not at ({pose.x:g}, {pose.y:g})",
                         field="origin")
    return pose
