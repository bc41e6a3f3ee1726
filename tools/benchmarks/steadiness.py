"""How much driven paths turn: social ones beside the shortest of the same pairs, both as smoothed for driving."""

import math
import time
from typing import Callable, List

import numpy as np

from .worlds import map_files, planner
from social_fleet.planning import planner as planning
from social_fleet.planning.plan import Plan
from social_fleet.planning.random_poses import random_pose_pairs

PAIRS = 200
WANTED = 1.3  # heading change per metre, social / shortest
SMOOTHING = {"environment_1": 0.4e-3}  # wanted mean time of smoothing a social path [s]
OTHER_SMOOTHING = 0.6e-3


def run(say: Callable[[str], None]) -> bool:
    """Sum of the turns at all vertices over the sum of the lengths, for every map; and the time of smoothing."""
    held = True
    for name in map_files():
        pairs = random_pose_pairs(planner(name), PAIRS, seed=0)
        turns, times = {}, {}
        for kind in ("shortest", "social"):
            clock = _Clock()
            planning.smooth = clock  # type: ignore[assignment]
            try:
                plans = [planner(name).plan(start, goal, planner=kind) for start, goal in pairs]
            finally:
                planning.smooth = clock.smooth
            turns[kind], times[kind] = _turns_per_metre(plans), float(np.mean(clock.taken[1:]))
        ratio = turns["social"] / turns["shortest"]
        say(f"{name}: {turns['social']:.4f} rad/m social, {turns['shortest']:.4f} shortest, ratio {ratio:.2f}, "
            f"wanted <= {WANTED}; smoothing {1e3 * times['social']:.2f} ms social, wanted <= "
            f"{1e3 * SMOOTHING.get(name, OTHER_SMOOTHING):.1f} ms, {1e3 * times['shortest']:.2f} ms shortest")
        held &= ratio <= WANTED
    return held


def _turns_per_metre(plans: List[Plan]) -> float:
    turned = way = 0.0
    for plan in plans:
        change = np.diff(plan.path.segment_headings)
        turned += float(np.abs((change + math.pi) % (2.0 * math.pi) - math.pi).sum())
        way += plan.length
    return turned / way


class _Clock:
    """`smooth`, with the time that each call takes."""

    smooth = staticmethod(planning.smooth)

    def __init__(self) -> None:
        self.taken: List[float] = []

    def __call__(self, *arguments: object, **options: object) -> np.ndarray:
        begun = time.perf_counter()
        path = self.smooth(*arguments, **options)  # type: ignore[arg-type]
        self.taken.append(time.perf_counter() - begun)
        return path
