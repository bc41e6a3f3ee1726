"""Random fleets of mixed speeds and sizes: every one must have a schedule, and no schedule may let discs touch.

FLEETS=100 ./tools/bench fleets   for fewer than the thousand
"""

import os
from collections import Counter
from dataclasses import dataclass, field
from statistics import median
from typing import Callable, List, Optional

import numpy as np

from .worlds import map_files, mixed_fleet, planner
from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.replanning import PlannerReplanner
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.verification import verify
from social_fleet.errors import InvalidInput, SocialFleetError

SIZES = (2, 101)
PRINTED = 24  # robots up to which a fleet is also scheduled as printed in the paper, ...
LIMIT = 10.0  # ... for so long at most [s]
PATIENCE = 60.0  # for a fleet [s]
EVERY = 50  # fleets between two summaries

Say = Callable[[str], None]


def run(say: Say) -> bool:
    """As many fleets as FLEETS says, of 2 to 100 robots, on all maps in turn."""
    count = int(os.environ.get("FLEETS", "1000"))
    names = list(map_files())
    rng = np.random.RandomState(0)
    results = Results()
    for seed in range(count):
        name, size = names[seed % len(names)], int(rng.randint(*SIZES))
        try:
            robots = mixed_fleet(name, size, seed)
        except InvalidInput:  # the map does not hold so many starts
            results.full[name] += 1
            continue
        _schedule(f"{name}, {size} robots, seed {seed}", robots, name, results, say)
        if (seed + 1) % EVERY == 0 and seed + 1 < count:
            results.sum_up(say)
    results.sum_up(say)
    return results.clearance >= 0.0 and len(results.failed) < 0.01 * count


@dataclass
class Results:
    """What came of the fleets so far."""

    clearances: List[float] = field(default_factory=list)  # [m]
    seconds: List[float] = field(default_factory=list)
    gaps: List[float] = field(default_factory=list)
    failed: List[str] = field(default_factory=list)
    printed: List[Optional[float]] = field(default_factory=list)  # clearances by Eq. 5-8 [m], None where unsolved
    full: Counter = field(default_factory=Counter)  # fleets that did not fit, per map
    repaired: int = 0

    @property
    def clearance(self) -> float:
        """The smallest of all [m]."""
        return min(self.clearances, default=float("inf"))

    def sum_up(self, say: Say) -> None:
        """What there is to say."""
        tried = len(self.clearances) + len(self.failed)
        say(f"{len(self.clearances)} of {tried} fleets scheduled ({self.repaired} after repair), smallest clearance "
            f"{self.clearance:.3f} m; median {median(self.seconds or [0.0]):.2f} s, gap median "
            f"{100 * median(self.gaps or [0.0]):.2f} %; did not fit on the map: {dict(self.full) or 'none'}")
        solved = [clearance for clearance in self.printed if clearance is not None]
        if solved:
            say(f"as printed in the paper, fleets of up to {PRINTED}: {len(solved)} of {len(self.printed)} solved; "
                f"robots touch in {sum(clearance < 0.0 for clearance in solved)}, smallest clearance "
                f"{min(solved):.2f} m")


def _schedule(what: str, robots: List[Robot], name: str, results: Results, say: Say) -> None:
    try:
        schedule = coordinate(robots, time_limit=PATIENCE,
                              replanner=PlannerReplanner(lambda radius: planner(name, radius)))
    except SocialFleetError as error:
        results.failed.append(what)
        say(f"{what}: {str(error)[:400]}")
        return
    results.clearances.append(verify(schedule).min_clearance)
    results.seconds.append(schedule.encounter_time + schedule.solve_time + schedule.planning_time)
    results.gaps.append(schedule.gap)
    results.repaired += bool(schedule.message)
    if len(robots) <= PRINTED:
        results.printed.append(_as_printed(robots))


def _as_printed(robots: List[Robot]) -> Optional[float]:
    """Smallest clearance under Eq. 5-8 [m]; None where they have no solution in time."""
    try:
        return verify(coordinate(robots, formulation="paper", time_limit=LIMIT)).min_clearance
    except SocialFleetError:
        return None
