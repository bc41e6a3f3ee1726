"""C-space: where a round robot fits, at cell centres and along continuous paths."""

import math
from typing import Tuple, Union

import numpy as np

from social_fleet.errors import InvalidGoal, InvalidParameter, InvalidPose, InvalidStart
from social_fleet.geometry import Polyline
from social_fleet.mapping.distances import centre_clearance, polyline_clearance, segment_clearance
from social_fleet.mapping.grid import UNKNOWN, OccupancyGrid, Points

__all__ = ["ConfigurationSpace", "TOUCH_TOLERANCE", "clearance_field", "segment_clearance"]

TOUCH_TOLERANCE = 1e-6  # [m]; a robot that fits exactly fits, whatever its radius is in binary


def clearance_field(grid: OccupancyGrid, *, limit: float) -> np.ndarray:
    """Distance from every cell's centre to the nearest blocked area.

    Blocked cells count as closed squares, and beyond the map's border all is blocked.

    Parameters
    ----------
    grid
        The map.
    limit
        Distances are capped at this [m].

    Returns
    -------
    (rows, columns) float32
        [m], exact; 0 in blocked cells.
    """
    return centre_clearance(grid.blocked, limit / grid.resolution) * np.float32(grid.resolution)


class ConfigurationSpace:
    """The places where a disc of one radius overlaps neither walls nor unknown space.

    Parameters
    ----------
    grid
        The map.
    radius
        The robot's radius [m].
    limit
        Clearances are told up to this [m]; never less than the radius.

    Raises
    ------
    InvalidParameter
        When the radius is not a positive number.
    """

    def __init__(self, grid: OccupancyGrid, radius: float, *, limit: float = 2.0) -> None:
        if not (math.isfinite(radius) and radius > 0.0):
            raise InvalidParameter(f"must be a positive number of metres, not {radius}", field="radius")
        self.grid = grid
        self.radius = float(radius)
        self.limit = max(float(limit), self.radius)
        self.clearance = clearance_field(grid, limit=self.limit)  # (rows, columns) [m], capped at `limit`
        self.free = self.clearance >= np.float32(self.radius - TOUCH_TOLERANCE)  # (rows, columns) bool
        self.clearance.setflags(write=False)
        self.free.setflags(write=False)

    def path_clearance(self, points: Union[Points, Polyline]) -> float:
        """Least distance [m] from the continuous path through `points` (N, 2) to a blocked area, capped at `limit`."""
        return self._clearance(points, 0.0)

    def is_free_path(self, points: Union[Points, Polyline]) -> bool:
        """Whether the robot overlaps nothing anywhere on the continuous path through `points` (N, 2) [m]."""
        enough = self.radius - TOUCH_TOLERANCE
        return self._clearance(points, enough) >= enough

    def check_pose(self, x: float, y: float, what: str = "start") -> Tuple[int, int]:
        """(row, column) of the cell that holds (x, y) [m], where the robot has to fit; the cell's centre need not.

        Raises
        ------
        InvalidStart, InvalidGoal
            As `what` is "start" or "goal" (else InvalidPose): not finite, off the map, in a wall, in unknown space, or
            closer to one of them than the radius. The message has the nearest place where the robot fits.
        """
        error = {"start": InvalidStart, "goal": InvalidGoal}.get(what, InvalidPose)
        try:
            row, column = self.grid.cell(x, y)
        except InvalidPose as problem:
            raise error(f"{problem.message}{self._remedy(x, y)}", field=what) from None
        reason = ""
        if self.grid.blocked[row, column]:
            reason = "lies in unknown space" if self.grid.values[row, column] == UNKNOWN else "lies in a wall"
        elif not self.is_free_path([(x, y)]):
            reason = (f"is {self.path_clearance([(x, y)]):.2f} m from the nearest wall or unknown space, "
                      f"closer than the robot's radius of {self.radius:g} m")
        if reason:
            raise error(f"({x:.2f}, {y:.2f}) {reason}{self._remedy(x, y)}", field=what)
        return row, column

    def _clearance(self, points: Union[Points, Polyline], enough: float) -> float:
        """Least clearance [m]; or any that is below `enough` [m], as soon as one is found."""
        corners = points.points if isinstance(points, Polyline) else points
        local = np.ascontiguousarray(self.grid.to_local(corners).reshape(-1, 2) / self.grid.resolution)
        resolution = self.grid.resolution
        return resolution * polyline_clearance(self.grid.blocked, local, self.limit / resolution, enough / resolution)

    def _remedy(self, x: float, y: float) -> str:
        """The end of a complaint about (x, y): where the robot would fit."""
        cells = np.argwhere(self.free)
        if not len(cells):
            return f"; the map has no room for a robot of radius {self.radius:g} m"
        if not (math.isfinite(x) and math.isfinite(y)):
            return "; give two numbers in metres"
        centres = self.grid.centres(cells)
        x, y = centres[int(np.argmin(np.hypot(*(centres - (x, y)).T)))]
        return f"; the nearest place where it fits is ({x:.2f}, {y:.2f})"
