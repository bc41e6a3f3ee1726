"""Random fleets on any map, the same on every machine for the same seed."""

import math
from typing import Tuple

import numpy as np

from social_fleet.errors import InvalidInput, InvalidScenario
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.random_poses import random_pose_pairs
from social_fleet.scenario.scenario import Expect, RobotSpec, Scenario

ROOM = 0.5  # [m] between the surfaces of two robots at their starts, or at their goals
SLOWEST = 1.0 / 3.0  # of the maximum, in fleets of mixed speed
EXPECT = Expect(max_lateness=2.0, max_tracking_error=0.1)  # all arrive, on time, and none touches anything


def random_scenario(grid: OccupancyGrid, robots: int, *, seed: int, map_name: str, map_path: str,
                    max_speed: float = 0.7, radius: float = 0.25, mixed: bool = False, room: float = 0.0) -> Scenario:
    """Robots at random free poses with random headings, each with a goal that it can reach.

    Parameters
    ----------
    grid
        The map.
    robots
        How many.
    seed
        The same seed gives the same scenario.
    map_name, map_path
        The map as the scenario file is to name it, and its absolute path.
    max_speed, radius
        [m/s], [m].
    room
        What starts and goals keep from walls [m].
    mixed
        Draw each robot's speed between a third of `max_speed` and all of it.

    Raises
    ------
    InvalidScenario
        When so many robots find no room on the map.
    """
    separation = 2.0 * radius + ROOM
    try:
        pairs = random_pose_pairs(ConfigurationSpace(grid, radius + room), robots, seed=seed, separation=separation)
    except InvalidInput as error:
        raise InvalidScenario(f"no room for {robots} robots of radius {radius:g} m, {ROOM:g} m apart: {error.message}",
                              source=map_name, field="robots") from error
    generator = np.random.RandomState(seed + 1)
    yaws = generator.uniform(-math.pi, math.pi, size=(robots, 2))
    shares = generator.uniform(SLOWEST, 1.0, size=robots) if mixed else np.ones(robots)
    digits = len(str(robots))
    specs = [RobotSpec(f"robot_{index + 1:0{digits}d}", _pose(start, yaw[0]), _pose(goal, yaw[1]),
                       max_speed=round(float(share) * max_speed, 3) if mixed else max_speed, radius=radius)
             for index, ((start, goal), yaw, share) in enumerate(zip(pairs, yaws, shares))]
    return Scenario(map_name, map_path, tuple(specs), expect=EXPECT)


def _pose(position: Tuple[float, float], yaw: float) -> Tuple[float, float, float]:
    """Without the noise of binary fractions, as a person would write it."""
    return round(position[0], 9), round(position[1], 9), round(float(yaw), 3)
