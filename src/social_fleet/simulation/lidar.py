"""A planar lidar by ray cast: through the map cell by cell, against discs in closed form."""

import math

import numpy as np
from numba import njit

from social_fleet.geometry import Pose
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.simulation.config import LidarConfig


class Lidar:
    """Scans a map and discs from a pose.

    Parameters
    ----------
    config : LidarConfig
        Ranges, beams and noise.
    seed : int
        Of the noise.
    """

    def __init__(self, config: LidarConfig = LidarConfig(), *, seed: int = 0) -> None:
        self.config = config
        count = int(math.floor((config.angle_max - config.angle_min) / config.angle_increment + 1e-9)) + 1
        self.angles = config.angle_min + config.angle_increment * np.arange(count)
        self._random = np.random.RandomState(seed)

    def scan(self, grid: OccupancyGrid, pose: Pose, discs: np.ndarray) -> np.ndarray:
        """Ranges of all beams.

        Parameters
        ----------
        grid : OccupancyGrid
            Blocked cells stop a beam; unknown ones do, the world beyond the border does not.
        pose : Pose
            Of the sensor [m, rad, map frame].
        discs : (N, 3) array
            Centres and radii [m, map frame].

        Returns
        -------
        (B,) float32 array
            Ranges [m]; infinite where nothing is within `range_max`, as REP 117 has it.
        """
        config = self.config
        local = (np.asarray(grid.to_local(np.array([[pose.x, pose.y]])), dtype=float)[0]) / grid.resolution
        ranges = cast_rays(grid.blocked, local[0], local[1], pose.yaw - grid.origin.yaw + self.angles,
                           config.range_max / grid.resolution) * grid.resolution
        if len(discs):
            ranges = np.minimum(ranges, disc_ranges(pose.x, pose.y, pose.yaw + self.angles,
                                                    np.ascontiguousarray(discs, dtype=float)))
        if config.noise > 0.0:
            ranges = ranges + self._random.normal(0.0, config.noise, len(ranges))
        ranges = np.where(ranges > config.range_max, np.inf, np.maximum(ranges, config.range_min))
        return ranges.astype(np.float32)


@njit(cache=True)
def cast_rays(blocked: np.ndarray, x: float, y: float, angles: np.ndarray, limit: float) -> np.ndarray:
    """Distances from (x, y) to the first blocked cell, all in cells; infinite beyond `limit` or off the map.

    A beam walks from cell border to cell border (Amanatides and Woo, Eurographics 1987).
    """
    rows, columns = blocked.shape
    ranges = np.full(len(angles), np.inf)
    for index in range(len(angles)):
        dx, dy = math.cos(angles[index]), math.sin(angles[index])
        column, row = int(math.floor(x)), int(math.floor(y))
        step_column, step_row = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
        delta_x = abs(1.0 / dx) if abs(dx) > 1e-12 else np.inf
        delta_y = abs(1.0 / dy) if abs(dy) > 1e-12 else np.inf
        next_x = (column + (1 if dx > 0.0 else 0) - x) / dx if abs(dx) > 1e-12 else np.inf
        next_y = (row + (1 if dy > 0.0 else 0) - y) / dy if abs(dy) > 1e-12 else np.inf
        distance = 0.0
        while distance <= limit and 0 <= row < rows and 0 <= column < columns:
            if blocked[row, column]:
                ranges[index] = distance
                break
            if next_x < next_y:
                distance = next_x
                next_x += delta_x
                column += step_column
            else:
                distance = next_y
                next_y += delta_y
                row += step_row
    return ranges


@njit(cache=True)
def disc_ranges(x: float, y: float, angles: np.ndarray, discs: np.ndarray) -> np.ndarray:
    """Distances from (x, y) along `angles` to the nearest disc [m]; infinite where there is none, 0 inside one."""
    ranges = np.full(len(angles), np.inf)
    for disc in range(len(discs)):
        dx, dy, radius = discs[disc, 0] - x, discs[disc, 1] - y, discs[disc, 2]
        room = dx * dx + dy * dy - radius * radius
        for index in range(len(angles)):
            if room <= 0.0:
                ranges[index] = 0.0
                continue
            along = dx * math.cos(angles[index]) + dy * math.sin(angles[index])
            reach = along * along - room
            if along > 0.0 and reach >= 0.0:
                ranges[index] = min(ranges[index], along - math.sqrt(reach))
    return ranges
