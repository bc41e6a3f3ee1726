"""Two robots sent against each other down every corridor: they must pass without an encounter window.

Each corridor of `corridors` at least 1.5 m wide is driven from the middle of one end to the middle of the other, and
back by a second robot, with both ends moved off the middle by each of `OFFSETS`. A pair counts as passing when no
encounter window, at the coordinator's default tracking tolerance, reaches beyond the `ENDS` metres at either end of
either path: there the two paths meet because they end at one place. Left out are pairs with an end where no robot can
stand, and with a trip that leaves the corridor for a way of more than `DETOUR` times its length.
"""

import itertools
import math
from typing import Callable, List, Tuple

import numpy as np

from .corridors import Corridor, corridors
from .worlds import map_files, planner
from social_fleet.coordination.encounters import EncounterFinder
from social_fleet.coordination.robot import Robot
from social_fleet.errors import InvalidPose, NoPath

OFFSETS = (-0.2, 0.0, 0.2)  # [m] across the corridor
ENDS = 3.0  # [m]
TOLERANCE = 0.1  # [m]; the coordinator's default
DETOUR = 1.2
WANTED = 0.95


def run(say: Callable[[str], None]) -> bool:
    """Share of pairs that pass, for every map."""
    held = True
    for name in map_files():
        found = corridors(planner(name).grid)
        outcomes: List[Tuple[bool, Corridor]] = []
        for corridor in found:
            outcomes += [(passed, corridor) for passed in _passes(name, corridor)]
        share = float(np.mean([passed for passed, _ in outcomes])) if outcomes else 1.0
        say(f"{name}: {100.0 * share:.1f} % of {len(outcomes)} pairs in {len(found)} corridors pass, wanted >= "
            f"{100.0 * WANTED:.0f} %")
        for corridor in sorted({corridor for passed, corridor in outcomes if not passed}):
            failed = sum(not passed for passed, where in outcomes if where == corridor)
            say(f"  {failed} windows between ({corridor.start[0]:.1f}, {corridor.start[1]:.1f}) and "
                f"({corridor.end[0]:.1f}, {corridor.end[1]:.1f}), {corridor.width:.2f} m wide")
        held &= share >= WANTED
    return held


def _passes(name: str, corridor: Corridor) -> List[bool]:
    """Whether each pair of opposite trips passes; trips whose ends are not free are left out."""
    start, end = np.array(corridor.start), np.array(corridor.end)
    along = (end - start) / np.hypot(*(end - start))
    across = np.array([-along[1], along[0]])
    outcomes = []
    for a, b in itertools.product(OFFSETS, OFFSETS):
        try:
            there = planner(name).plan(start + a * across, end + a * across)
            back = planner(name).plan(end + b * across, start + b * across)
        except (InvalidPose, NoPath):
            continue
        if max(there.length, back.length) > DETOUR * math.hypot(*(end - start)):
            continue
        outcomes.append(_is_clear(Robot("there", there), Robot("back", back)))
    return outcomes


def _is_clear(there: Robot, back: Robot) -> bool:
    for window in EncounterFinder(TOLERANCE).find([there, back]):
        for extent, robot in ((window.r_extent, there), (window.s_extent, back)):
            if extent[1] > ENDS and extent[0] < robot.path.length - ENDS:
                return False
    return True
