"""Random fleets: every one must have a schedule, and no schedule may let discs touch."""

from statistics import median
from typing import Callable

from .worlds import fleet, map_files, planner
from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.repair import PlannerReplanner
from social_fleet.coordination.verification import verify
from social_fleet.errors import SocialFleetError

SIZES = (2, 4, 8, 16)
SEEDS = range(25)


def run(say: Callable[[str], None]) -> bool:
    """25 fleets of each size in Environment 1 and on the Willow map."""
    held = True
    for name in [name for name in ("environment_1", "willow") if name in map_files()]:
        for size in SIZES:
            held &= _series(name, size, say)
    return held


def _series(name: str, size: int, say: Callable[[str], None]) -> bool:
    clearances, times, repaired, failed = [], [], 0, []
    for seed in SEEDS:
        try:
            schedule = coordinate(fleet(name, size, seed), time_limit=120.0,
                                  replanner=PlannerReplanner(lambda radius: planner(name)))
        except SocialFleetError as error:
            failed.append(f"seed {seed}: {error}")
            continue
        clearances.append(verify(schedule).min_clearance)
        times.append(schedule.encounter_time + schedule.solve_time)
        repaired += bool(schedule.message)
    say(f"{name}, {size} robots: {len(clearances)} of {len(SEEDS)} scheduled ({repaired} after repair), smallest "
        f"clearance {min(clearances):.3f} m, median {median(times):.3f} s")
    for line in failed:
        say("  " + line)
    return not failed and min(clearances) >= 0.0
