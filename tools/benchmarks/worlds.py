"""Maps that the benchmarks run on, and fleets on them."""

import functools
import os
from typing import Dict, List

import numpy as np

from social_fleet.coordination.robot import Robot
from social_fleet.mapping.files import load_map
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import random_pose_pairs

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

RADII = (0.2, 0.25, 0.3, 0.35, 0.4)  # of mixed fleets [m]


def map_files() -> Dict[str, str]:
    """Name and file of every map; the Willow Garage map where it lies beside the project."""
    files = {name: os.path.join(ROOT, "maps", name + ".yaml")
             for name in ("environment_1", "environment_2", "office_floor")}
    willow = os.path.join(os.path.dirname(ROOT), "shared", "maps", "willow-full-0.05.yaml")
    if os.path.exists(willow):
        files["willow"] = willow
    return files


@functools.lru_cache(maxsize=None)
def planner(name: str, radius: float = 0.25) -> SocialPlanner:
    """The planner of a map, for robots of a radius [m]."""
    return SocialPlanner(load_map(map_files()[name]), PlannerConfig(robot_radius=radius))


def fleet(name: str, robots: int, seed: int) -> List[Robot]:
    """Robots of one size and speed between random poses at least 1 m apart, each on its social path."""
    pairs = random_pose_pairs(planner(name), robots, seed=seed, separation=1.0)
    return [Robot(f"robot_{index:03d}", planner(name).plan(start, goal)) for index, (start, goal) in enumerate(pairs)]


def mixed_fleet(name: str, robots: int, seed: int) -> List[Robot]:
    """Robots of 0.2 to 0.4 m and 0.2 to 1.2 m/s between random poses at least 1.1 m apart, where the widest fit."""
    rng = np.random.RandomState(seed)
    pairs = random_pose_pairs(planner(name, RADII[-1]), robots, seed=seed, separation=1.1)
    fleet_ = []
    for index, (start, goal) in enumerate(pairs):
        radius, speed = float(rng.choice(RADII)), float(rng.uniform(0.2, 1.2))
        fleet_.append(Robot(f"robot_{index:03d}", planner(name, radius).plan(start, goal), max_speed=speed))
    return fleet_
