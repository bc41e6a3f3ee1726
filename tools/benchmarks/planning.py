"""Planning times per map: plain A*, the social plan and the social plan on learnt routes, all in one run."""

import os
import time
from typing import Callable, Dict, List, Sequence, Tuple

import numpy as np

from social_fleet.mapping.files import load_map
from social_fleet.planning.cache import FOLDER
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import random_pose_pairs
from social_fleet.planning.routes.social_graph import learn

from .worlds import map_files, planner

PAIRS = 100
REPEATS = 5
LEARNT = 250  # paths that the social graph is learnt from
SOCIAL, GRAPH = 1.5, 0.3  # wanted share of plain A*'s time, at most
FIRST, AGAIN = 1.5, 0.2  # [s] wanted for what a map needs at first, and from the cache
Pairs = Sequence[Tuple[Tuple[float, float], Tuple[float, float]]]


def run(say: Callable[[str], None]) -> bool:
    """For every map the mean over random pairs of the median of several tries; then what precomputation takes."""
    for name in map_files():
        _series(name, say)
    for name in [name for name in ("office_floor", "willow") if name in map_files()]:
        _precomputation(name, say)
    return True


def _series(name: str, say: Callable[[str], None]) -> None:
    pairs = random_pose_pairs(planner(name), PAIRS, seed=1)
    unprepared = SocialPlanner(load_map(map_files()[name]), PlannerConfig())
    plain, slow = _times(unprepared, pairs, "shortest"), _times(unprepared, pairs, "social")
    planner(name).prepare()
    social = _times(planner(name), pairs, "social")
    with_graph = SocialPlanner(planner(name).grid, planner(name).config)
    with_graph.prepare()
    with_graph.graph = learn(planner(name), paths=LEARNT, seed=1)
    graph = _times(with_graph, pairs, "social")
    say(f"{name}: plain A* {1e3 * plain:.2f} ms; social {1e3 * social:.2f} ms, ratio {social / plain:.2f}, wanted <= "
        f"{SOCIAL} (unprepared {slow / plain:.2f}); with a graph of {LEARNT} paths {1e3 * graph:.2f} ms, ratio "
        f"{graph / plain:.2f}, wanted <= {GRAPH}")


def _times(maker: SocialPlanner, pairs: Pairs, kind: str) -> float:
    """Mean time of a plan [s]."""
    maker.plan(*pairs[0], planner=kind)
    means: List[float] = []
    for start, goal in pairs:
        taken = []
        for _ in range(REPEATS):
            begun = time.perf_counter()
            maker.plan(start, goal, planner=kind)
            taken.append(time.perf_counter() - begun)
        means.append(float(np.median(taken)))
    return float(np.mean(means))


def _precomputation(name: str, say: Callable[[str], None]) -> None:
    """With an empty cache, and with what that has left in it."""
    import tempfile
    grid = load_map(map_files()[name])
    kept: Dict[str, str] = {FOLDER: os.environ.get(FOLDER, "")}
    first, again = [], []
    try:
        for _ in range(3):
            with tempfile.TemporaryDirectory() as folder:
                os.environ[FOLDER] = folder
                for taken in (first, again):
                    begun = time.perf_counter()
                    SocialPlanner(grid, PlannerConfig()).prepare()
                    taken.append(time.perf_counter() - begun)
    finally:
        os.environ.update(kept)
    say(f"{name}, {grid.shape[0]} x {grid.shape[1]} cells: precomputation {np.median(first):.2f} s at first, wanted <= "
        f"{FIRST} s, {np.median(again):.2f} s from the cache, wanted <= {AGAIN} s")
