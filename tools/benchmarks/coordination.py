"""Windows and program of 16 robots in Environment 1, beside Eq. 5-8 as printed on the same windows."""

import time
from statistics import median
from typing import Callable

from .worlds import fleet, planner
from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.repair import PlannerReplanner
from social_fleet.coordination.verification import verify
from social_fleet.errors import Infeasible

ROBOTS = 16
FLEETS = 10


def run(say: Callable[[str], None]) -> bool:
    """Medians over ten fleets."""
    replanner = PlannerReplanner(lambda radius: planner("environment_1"))
    coordinate(fleet("environment_1", 2, 0), replanner=replanner)
    exact, printed, checks, safe, touching = [], [], [], True, 0
    for seed in range(FLEETS):
        robots = fleet("environment_1", ROBOTS, seed)
        schedule = coordinate(robots, replanner=replanner)
        exact.append(schedule.encounter_time + schedule.solve_time)
        begun = time.perf_counter()
        safe &= verify(schedule).safe
        checks.append(time.perf_counter() - begun)
        try:
            paper = coordinate(robots, formulation="paper")
        except Infeasible:
            continue
        printed.append(paper.encounter_time + paper.solve_time)
        touching += not verify(paper).safe
    say(f"{ROBOTS} robots, windows + program: median {median(exact):.3f} s, worst {max(exact):.3f} s, wanted <= 0.2 s; "
        f"verification {median(checks):.3f} s")
    say(f"as printed in the paper: median {median(printed):.3f} s, ratio {median(exact) / median(printed):.2f}; "
        f"no solution in {FLEETS - len(printed)} of {FLEETS} fleets, robots touch in {touching}")
    return safe
