"""Maps that the benchmarks run on, and fleets on them."""

import functools
import os
from typing import Dict, List

from social_fleet.coordination.robot import Robot
from social_fleet.mapping.files import load_map
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import random_pose_pairs

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def map_files() -> Dict[str, str]:
    """Name and file of every map; the Willow Garage map where it lies beside the project."""
    files = {name: os.path.join(ROOT, "maps", name + ".yaml")
             for name in ("environment_1", "environment_2", "office_floor")}
    willow = os.path.join(os.path.dirname(ROOT), "shared", "maps", "willow-full-0.05.yaml")
    if os.path.exists(willow):
        files["willow"] = willow
    return files


@functools.lru_cache(maxsize=None)
def planner(name: str) -> SocialPlanner:
    """The planner of a map, for robots of radius 0.25 m."""
    return SocialPlanner(load_map(map_files()[name]), PlannerConfig())


def fleet(name: str, robots: int, seed: int) -> List[Robot]:
    """Robots of one size and speed between random poses at least 1 m apart, each on its social path."""
    pairs = random_pose_pairs(planner(name), robots, seed=seed, separation=1.0)
    return [Robot(f"robot_{index:03d}", planner(name).plan(start, goal)) for index, (start, goal) in enumerate(pairs)]
