"""Random starts and goals where a robot fits."""

import math
from typing import List, Tuple, Union

import numpy as np

from social_fleet.errors import InvalidInput
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.lattice import Lattice
from social_fleet.planning.planner import SocialPlanner

Position = Tuple[float, float]
_TRIES_PER_POSE = 1000


def random_pose_pairs(source: Union[SocialPlanner, ConfigurationSpace], count: int, *, seed: int,
                      separation: float = 0.0) -> List[Tuple[Position, Position]]:
    """Starts and goals at random cell centres of the largest connected part of the free space.

    Parameters
    ----------
    source : SocialPlanner or ConfigurationSpace
        Where the robot fits; of a space, the part that a planner with the default margin to walls reaches.
    count : int
        Number of pairs.
    seed : int
        The same seed gives the same pairs.
    separation : float
        Least distance [m] between any two starts, and between any two goals.

    Returns
    -------
    list of ((x, y), (x, y))
        Start and goal [m, map frame]; never the same cell.

    Raises
    ------
    InvalidInput
        When the free space does not hold so many poses so far apart.
    """
    lattice = source.lattice if isinstance(source, SocialPlanner) else _default_lattice(source)
    grid = source.grid
    nodes = lattice.largest_component
    if len(nodes) < 2:
        raise InvalidInput("the map has no room for a start and another goal", field="map")
    generator = np.random.RandomState(seed)
    centres = grid.centres(lattice.cells(nodes))
    starts: List[int] = []
    goals: List[int] = []
    for _ in range(count):
        starts.append(_draw(generator, centres, starts, separation, -1))
        goals.append(_draw(generator, centres, goals, separation, starts[-1]))
    return [(_position(centres[start]), _position(centres[goal])) for start, goal in zip(starts, goals)]


def _default_lattice(space: ConfigurationSpace) -> Lattice:
    return Lattice(ConfigurationSpace(space.grid, space.radius + PlannerConfig.wall_margin))


def _draw(generator: np.random.RandomState, centres: np.ndarray, taken: List[int], separation: float,
          other: int) -> int:
    """Index of a centre that is far enough from those taken, and is not `other`."""
    for _ in range(_TRIES_PER_POSE):
        index = int(generator.randint(len(centres)))
        gaps = np.hypot(*(centres[taken] - centres[index]).T) if taken and separation > 0.0 else np.zeros(0)
        if index != other and (not len(gaps) or gaps.min() >= separation):
            return index
    raise InvalidInput(f"found no room for {len(taken) + 1} poses {separation:g} m apart; ask for fewer robots, or "
                       "less separation", field="separation")


def _position(point: np.ndarray) -> Position:
    x, y = float(point[0]), float(point[1])
    assert math.isfinite(x) and math.isfinite(y)
    return x, y
