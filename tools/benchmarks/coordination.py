"""Windows, program and verification of 16 to 100 robots; one that joins 99; windows in a building that grows."""

import time
from dataclasses import replace
from statistics import median
from typing import Callable

import numpy as np

from .worlds import fleet, planner
from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.encounters import EncounterFinder
from social_fleet.coordination.replanning import PlannerReplanner
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.verification import verify
from social_fleet.errors import Infeasible

WANTED = {16: 0.2, 50: 0.25, 100: 1.0}  # median, windows + program + verification [s]
FLEETS = 10
BLOCKS = (1, 2, 4, 8)  # copies of Environment 1 side by side, ...
PER_BLOCK = 25  # ... each with so many robots

Say = Callable[[str], None]


def run(say: Say) -> bool:
    """Medians over ten fleets of Environment 1, given their paths."""
    replanner = PlannerReplanner(lambda radius: planner("environment_1"))
    coordinate(fleet("environment_1", 8, 0), replanner=replanner)
    held = True
    for size in WANTED:
        held &= _size(size, replanner, say)
    _printed(say)
    held &= _join(replanner, say)
    _growth(say)
    return held


def _size(size: int, replanner: PlannerReplanner, say: Say) -> bool:
    totals, windows, gaps, safe = [], [], [], True
    for seed in range(FLEETS):
        robots = fleet("environment_1", size, seed)
        begun = time.perf_counter()
        EncounterFinder(0.1).find(robots)
        windows.append(time.perf_counter() - begun)
        schedule = coordinate(robots, replanner=replanner)
        begun = time.perf_counter()
        safe &= verify(schedule).safe
        totals.append(schedule.encounter_time + schedule.solve_time + time.perf_counter() - begun)
        gaps.append(schedule.gap)
    pairs = size * (size - 1) / 2
    say(f"{size} robots, windows + program + verification: median {median(totals):.3f} s (wanted <= {WANTED[size]} "
        f"s), worst {max(totals):.3f} s; gap median {100 * median(gaps):.2f} %, worst {100 * max(gaps):.2f} % (wanted "
        f"<= 0.1 %), {sum(gap <= 1e-3 for gap in gaps)} of {FLEETS} within; windows "
        f"{1e3 * median(windows) / pairs:.3f} ms per pair (wanted <= 0.1)")
    return safe


def _printed(say: Say) -> None:
    """Eq. 5-8 on the same fleets of 16, and whether robots touch by it."""
    exact, printed, touching = [], [], 0
    for seed in range(FLEETS):
        robots = fleet("environment_1", 16, seed)
        try:
            paper = coordinate(robots, formulation="paper")
            ours = coordinate(robots)
        except Infeasible:
            continue
        printed.append(paper.encounter_time + paper.solve_time)
        exact.append(ours.encounter_time + ours.solve_time)
        touching += not verify(paper).safe
    say(f"16 robots as printed in the paper, {len(printed)} of {FLEETS} fleets that need no repair: median "
        f"{median(printed):.3f} s; ours {median(exact) / median(printed):.2f} of that; as printed, robots touch in "
        f"{touching}")


def _join(replanner: PlannerReplanner, say: Say) -> bool:
    """The last of a hundred joins when the others have been under way for 20 s."""
    times, safe = [], True
    for seed in range(FLEETS):
        robots = fleet("environment_1", 100, seed)
        moving = coordinate(robots[:-1], replanner=replanner)
        newcomer = replace(robots[-1], depart=20.0)
        begun = time.perf_counter()
        try:
            joined = coordinate([newcomer], mode="sequential", fixed=moving.schedules, replanner=replanner)
        except Infeasible:
            continue
        times.append(time.perf_counter() - begun)
        safe &= verify([*moving.schedules, *joined.schedules]).safe
    say(f"one robot joins 99 that move, all in: median {median(times):.3f} s (wanted <= 0.1 s), worst {max(times):.3f} "
        f"s, {len(times)} of {FLEETS} have a schedule")
    return safe


def _growth(say: Say) -> None:
    """Window search while building and fleet grow together: with R^2 the exponent would be 2."""
    sizes, times = [], []
    for blocks in BLOCKS:
        robots = [_shifted(body, block, 100.0 * block) for block in range(blocks)
                  for body in fleet("environment_1", PER_BLOCK, block)]
        measured = []
        for _ in range(5):
            begun = time.perf_counter()
            EncounterFinder(0.1).find(robots)
            measured.append(time.perf_counter() - begun)
        sizes.append(len(robots))
        times.append(median(measured))
    exponent = np.polyfit(np.log(sizes), np.log(times), 1)[0]
    say("windows in a building that grows with the fleet: " + ", ".join(
        f"{size} robots {1e3 * seconds:.0f} ms" for size, seconds in zip(sizes, times))
        + f"; grows as R^{exponent:.2f} (wanted below 2)")


def _shifted(body: Robot, block: int, offset: float) -> Robot:
    return Robot(f"{body.name}_{block}", body.path.points + (offset, 0.0), body.max_speed, body.body_radius)
