"""Random fleets of mixed speeds and sizes: every one must have a schedule, and no schedule may let discs touch.

FLEETS=100 ./tools/bench fleets   for fewer than the thousand
"""

import os
from collections import Counter
from statistics import median
from typing import Callable, List, Optional

import numpy as np

from .worlds import map_files, mixed_fleet, planner
from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.repair import PlannerReplanner
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.verification import verify
from social_fleet.errors import InvalidInput, SocialFleetError

SIZES = (2, 101)
PRINTED = 24  # robots up to which a fleet is also scheduled as printed in the paper, ...
LIMIT = 10.0  # ... for so long at most [s]

Say = Callable[[str], None]


def run(say: Say) -> bool:
    """As many fleets as FLEETS says, of 2 to 100 robots, on all maps in turn."""
    count = int(os.environ.get("FLEETS", "1000"))
    names = list(map_files())
    rng = np.random.RandomState(0)
    held, printed = True, []
    clearances, failed, full = [], [], Counter()  # type: ignore[var-annotated]
    times, gaps, repaired = [], [], 0
    for seed in range(count):
        name, size = names[seed % len(names)], int(rng.randint(*SIZES))
        try:
            robots = mixed_fleet(name, size, seed)
        except InvalidInput:  # the map does not hold so many starts
            full[name] += 1
            continue
        try:
            schedule = coordinate(robots, replanner=PlannerReplanner(lambda radius: planner(name, radius)))
        except SocialFleetError as error:
            failed.append(f"{name}, {size} robots, seed {seed}: {error}")
            continue
        clearances.append(verify(schedule).min_clearance)
        times.append((size, schedule.encounter_time + schedule.solve_time + schedule.planning_time))
        gaps.append(schedule.gap)
        repaired += bool(schedule.message)
        if size <= PRINTED:
            printed.append(_as_printed(robots))
    say(f"{len(clearances)} of {count - sum(full.values())} fleets scheduled ({repaired} after repair), smallest "
        f"clearance {min(clearances):.3f} m; median {median(seconds for _, seconds in times):.2f} s, gap median "
        f"{100 * median(gaps):.2f} %, worst {100 * max(gaps):.2f} %; did not fit on the map: {dict(full) or 'none'}")
    held &= min(clearances) >= 0.0
    for line in failed:
        say("  " + line[:600])
    _say_printed(printed, say)
    return held and len(failed) < 0.01 * count


def _as_printed(robots: List[Robot]) -> Optional[float]:
    """Smallest clearance under Eq. 5-8 [m]; None where they have no solution in time."""
    try:
        return verify(coordinate(robots, formulation="paper", time_limit=LIMIT)).min_clearance
    except SocialFleetError:
        return None


def _say_printed(found: List[Optional[float]], say: Say) -> None:
    solved = [clearance for clearance in found if clearance is not None]
    touching = [clearance for clearance in solved if clearance < 0.0]
    if solved:
        say(f"as printed in the paper, fleets of up to {PRINTED}: {len(solved)} of {len(found)} solved; robots touch "
            f"in {len(touching)}, the worst by {-min(solved):.2f} m")
