"""Random fleets of mixed speeds and sizes: every one must have a schedule, and no schedule may let discs touch.

FLEETS=100 ./tools/bench fleets              for fewer than the thousand
FIRST=100 FLEETS=100 ./tools/bench fleets    for those from the hundredth on
"""

import os
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from statistics import median
from typing import Callable, List, NamedTuple, Optional, Tuple

import numpy as np

from .worlds import map_files, mixed_fleet, planner
from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.replanning import PlannerReplanner
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.verification import verify
from social_fleet.errors import InvalidInput, SocialFleetError

SIZES = (2, 101)
PRINTED = 24  # robots up to which a fleet is also scheduled as printed in the paper, ...
LIMIT = 5.0  # ... for so long at most [s]
PATIENCE = 120.0  # for a fleet [s]
EVERY = 50  # fleets between two summaries

Say = Callable[[str], None]


def run(say: Say) -> bool:
    """As many fleets as FLEETS says, of 2 to 100 robots, on all maps in turn, one on each processor."""
    first, count = int(os.environ.get("FIRST", "0")), int(os.environ.get("FLEETS", "1000"))
    names = list(map_files())
    rng = np.random.RandomState(0)
    drawn = [(names[seed % len(names)], int(rng.randint(*SIZES)), seed) for seed in range(first + count)][first:]
    results = Results()
    with ProcessPoolExecutor(os.cpu_count()) as workers:
        for place, outcome in enumerate(workers.map(_outcome, drawn), 1):
            results.add(outcome, say)
            if place % EVERY == 0 and place < count:
                results.sum_up(say)
    results.sum_up(say)
    return results.clearance >= 0.0 and len(results.failed) < 0.01 * count


class Outcome(NamedTuple):
    """What came of one fleet."""

    what: str
    map: str
    full: bool = False  # the map does not hold so many starts
    failure: str = ""
    clearance: float = float("inf")  # [m]
    seconds: float = 0.0
    gap: float = 0.0
    repaired: bool = False
    printed: Optional[float] = None  # clearance by Eq. 5-8 [m], None where not solved ...
    by_print: bool = False  # ... or not asked for


@dataclass
class Results:
    """What came of the fleets so far."""

    clearances: List[float] = field(default_factory=list)  # [m]
    seconds: List[float] = field(default_factory=list)
    gaps: List[float] = field(default_factory=list)
    failed: List[str] = field(default_factory=list)
    printed: List[Optional[float]] = field(default_factory=list)  # as in `Outcome`
    full: Counter = field(default_factory=Counter)  # fleets that did not fit, per map
    repaired: int = 0

    def add(self, outcome: Outcome, say: Say) -> None:
        """Count one more."""
        if outcome.full:
            self.full[outcome.map] += 1
            return
        if outcome.failure:
            self.failed.append(outcome.what)
            say(f"{outcome.what}: {outcome.failure[:400]}")
            return
        self.clearances.append(outcome.clearance)
        self.seconds.append(outcome.seconds)
        self.gaps.append(outcome.gap)
        self.repaired += outcome.repaired
        if outcome.by_print:
            self.printed.append(outcome.printed)

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


def _outcome(drawn: Tuple[str, int, int]) -> Outcome:
    """Schedule one fleet, and judge it."""
    name, size, seed = drawn
    what = f"{name}, {size} robots, seed {seed}"
    try:
        robots = mixed_fleet(name, size, seed)
    except InvalidInput:
        return Outcome(what, name, full=True)
    try:
        schedule = coordinate(robots, time_limit=PATIENCE,
                              replanner=PlannerReplanner(lambda radius: planner(name, radius)))
    except SocialFleetError as error:
        return Outcome(what, name, failure=str(error))
    few = size <= PRINTED
    return Outcome(what, name, clearance=verify(schedule).min_clearance, gap=schedule.gap,
                   seconds=schedule.encounter_time + schedule.solve_time + schedule.planning_time,
                   repaired=bool(schedule.message), by_print=few, printed=_as_printed(robots) if few else None)


def _as_printed(robots: List[Robot]) -> Optional[float]:
    """Smallest clearance under Eq. 5-8 [m]; None where they have no solution in time."""
    try:
        return verify(coordinate(robots, formulation="paper", time_limit=LIMIT)).min_clearance
    except SocialFleetError:
        return None
