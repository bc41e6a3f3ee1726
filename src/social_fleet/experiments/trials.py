"""Random pairs, solved by several planners in turn, with the time that each took."""

import time
from dataclasses import dataclass
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np

from social_fleet.errors import NoPath
from social_fleet.experiments.frame import Progress
from social_fleet.planning.plan import Plan
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import Position

METHODS = {"shortest": "A*", "rrt_star": "RRT*", "social": "social"}  # planner's name and the table's
COLOURS = {"shortest": "#0072B2", "rrt_star": "#E69F00", "social": "#009E73", "social_graph": "#CC79A7"}
Pair = Tuple[Position, Position]


@dataclass(frozen=True)
class Trials:
    """One method's plans of all pairs.

    Attributes
    ----------
    plans : list of Plan or None
        None where it found no path.
    times : (P,) array
        Wall time of each [s], smoothing included, whether it found a path or not.
    """

    plans: List[Optional[Plan]]
    times: np.ndarray

    @property
    def failed(self) -> int:
        """How many pairs it found no path for."""
        return sum(plan is None for plan in self.plans)


def solve(planner: SocialPlanner, pairs: Sequence[Pair], methods: Sequence[str],
          progress: Progress) -> Dict[str, Trials]:
    """All pairs by all methods, pair by pair, so that a busy spell of the machine hits all of them alike.

    The first pair is planned once beforehand, so that compilation is in nobody's time.
    """
    plans: Dict[str, List[Optional[Plan]]] = {method: [] for method in methods}
    times: Dict[str, List[float]] = {method: [] for method in methods}
    for method in methods:
        attempt(planner, pairs[0], method)
    for done, pair in enumerate(pairs, start=1):
        for method in methods:
            plan, taken = attempt(planner, pair, method)
            plans[method].append(plan)
            times[method].append(taken)
        progress(done / len(pairs))
    return {method: Trials(plans[method], np.array(times[method])) for method in methods}


def attempt(planner: SocialPlanner, pair: Pair, method: str) -> Tuple[Optional[Plan], float]:
    """A plan, None where there is no path, and the wall time that it took [s]."""
    begun = time.perf_counter()
    try:
        plan: Optional[Plan] = planner.plan(*pair, planner=method)
    except NoPath:
        plan = None
    return plan, time.perf_counter() - begun


def solved_by_all(trials: Dict[str, Trials]) -> np.ndarray:
    """Indices of the pairs that every method found a path for."""
    found = np.array([[plan is not None for plan in each.plans] for each in trials.values()])
    return np.flatnonzero(found.all(axis=0))


def mean_and_std(values: Sequence[float]) -> Tuple[Optional[float], Optional[float]]:
    """Mean and standard deviation over the trials; None of no values."""
    if not len(values):
        return None, None
    return float(np.mean(values)), float(np.std(values))
