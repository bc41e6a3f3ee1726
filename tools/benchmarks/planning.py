"""Planning times: the social plan beside the shortest path of the same pairs, smoothing included."""

import time
from typing import Callable, List

import numpy as np

from .worlds import map_files, planner
from social_fleet.planning.random_poses import random_pose_pairs

PAIRS = 100
LIMITS = {"environment_1": 0.015, "willow": 0.060}  # wanted mean of one social plan [s]


def run(say: Callable[[str], None]) -> bool:
    """Mean over random pairs after the first plan, for every map."""
    for name in map_files():
        pairs = random_pose_pairs(planner(name), PAIRS, seed=1)
        means = {}
        for kind in ("shortest", "social"):
            planner(name).plan(*pairs[0], planner=kind)
            means[kind] = float(np.mean(_times(name, pairs, kind)))
        wanted = f", wanted <= {1e3 * LIMITS[name]:.0f} ms" if name in LIMITS else ""
        say(f"{name}: social {1e3 * means['social']:.1f} ms{wanted}; shortest {1e3 * means['shortest']:.1f} ms; "
            f"ratio {means['social'] / means['shortest']:.2f}")
    return True


def _times(name: str, pairs: List, kind: str) -> List[float]:
    taken = []
    for start, goal in pairs:
        begun = time.perf_counter()
        planner(name).plan(start, goal, planner=kind)
        taken.append(time.perf_counter() - begun)
    return taken
