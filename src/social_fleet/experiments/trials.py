"""Random pairs, solved by several planners in turn, with the time that each took."""

import functools
import time
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from social_fleet.errors import NoPath
from social_fleet.experiments.cells import Cell
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.plan import Plan
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import Position, random_pose_pairs

METHODS = {"shortest": "A*", "rrt_star": "RRT*", "social": "social"}  # planner's name and the table's
COLOURS = {"shortest": "#0072B2", "rrt_star": "#E69F00", "social": "#009E73", "social_graph": "#CC79A7"}
Pair = Tuple[Position, Position]
Methods = Mapping[str, Tuple[SocialPlanner, str]]  # by a method's name: who plans, and which of its planners


class Attempt(NamedTuple):
    """What came of one pair with one method: a plan, None where it found no path, and the wall time taken [s]."""

    plan: Optional[Plan]
    time: float


def three_methods(grid: OccupancyGrid) -> Methods:
    """A*, RRT* and the social planner on one map."""
    planner = SocialPlanner(grid)
    planner.prepare()
    return {method: (planner, method) for method in METHODS}


def pair_cells(grids: Sequence[OccupancyGrid], trials: int, seed: int,
               measure: Callable[[OccupancyGrid, Pair, Dict[str, Attempt]], Any], *,
               methods_on: Callable[[OccupancyGrid], Methods] = three_methods) -> List[List[Cell]]:
    """For each map a cell per random pair; the pairs of fewer trials are the first ones of more.

    Parameters
    ----------
    grids : sequence of OccupancyGrid
        Maps; planners of one at a time are there.
    trials, seed : int
        How many pairs, and which.
    measure : callable
        Makes a cell's value of a map, a pair, and what each method made of it.
    methods_on : callable
        The methods on a map; the first one's planner tells where robots fit.
    """
    @functools.lru_cache(maxsize=1)
    def ready(index: int) -> Tuple[Methods, List[Pair]]:
        methods = methods_on(grids[index])
        pairs = random_pose_pairs(next(iter(methods.values()))[0], trials, seed=seed)
        solve(methods, pairs[0])  # so that compilation is in nobody's time
        return methods, pairs

    def compute(index: int, trial: int) -> Any:
        methods, pairs = ready(index)
        return measure(grids[index], pairs[trial], solve(methods, pairs[trial]))

    return [[Cell({"map": grid.digest, "seed": seed, "pair": trial}, functools.partial(compute, index, trial))
             for trial in range(trials)] for index, grid in enumerate(grids)]


def solve(methods: Methods, pair: Pair) -> Dict[str, Attempt]:
    """A pair by all methods in turn, so that a busy spell of the machine hits all of them alike."""
    return {method: attempt(planner, pair, which) for method, (planner, which) in methods.items()}


def attempt(planner: SocialPlanner, pair: Pair, method: str) -> Attempt:
    """One pair by one method."""
    begun = time.perf_counter()
    try:
        plan: Optional[Plan] = planner.plan(*pair, planner=method)
    except NoPath:
        plan = None
    return Attempt(plan, time.perf_counter() - begun)


def mean_and_std(values: Sequence[float]) -> Tuple[Optional[float], Optional[float]]:
    """Mean and standard deviation over the trials; None of no values."""
    if not len(values):
        return None, None
    return float(np.mean(values)), float(np.std(values))
