"""Random fleets whose encounter windows are searched by one robot, and by all of them in shares (3.4.2)."""

import functools
import time
from typing import Any, Dict, List, NamedTuple, Sequence

import numpy as np

from social_fleet.coordination.encounters import EncounterFinder
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.work_sharing import Pair, share_pairs
from social_fleet.experiments.cells import Cell
from social_fleet.experiments.frame import Row
from social_fleet.experiments.trials import mean_and_std
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import random_pose_pairs

REPEATS = 5  # a search's time is the median of so many
SEPARATION = 1.0  # least distance between two starts, and between two goals [m]
TOLERANCE = 0.1  # tracking tolerance of the windows [m]


class Search(NamedTuple):
    """What a search by a robot that knew no window before took, and how many windows it found.

    Time is the processor's [s]: a search waits for nothing, and a busy machine would make the unluckiest of several
    searches the slowest.
    """

    time: float
    windows: int


def fleet_cells(grids: Sequence[OccupancyGrid], sizes: Sequence[int], trials: int, seed: int) -> List[Cell]:
    """A cell per map, trial and size of fleet; the smaller fleets of a trial are the first robots of the largest."""
    @functools.lru_cache(maxsize=1)
    def planner(index: int) -> SocialPlanner:
        planner = SocialPlanner(grids[index])
        planner.prepare()
        return planner

    @functools.lru_cache(maxsize=1)
    def fleet(index: int, trial: int) -> List[Robot]:
        robots = random_fleet(planner(index), max(sizes), np.random.RandomState([seed, trial]).randint(2 ** 31))
        measure(robots[:2])  # so that compilation is in nobody's time
        return robots

    def compute(index: int, trial: int, size: int) -> Row:
        return measure(fleet(index, trial)[:size])

    return [Cell({"map": grid.digest, "seed": seed, "trial": trial, "robots": size, "of": max(sizes),
                  "repeats": REPEATS}, functools.partial(compute, index, trial, size))
            for index, grid in enumerate(grids) for trial in range(trials) for size in sizes]


def random_fleet(planner: SocialPlanner, robots: int, seed: int) -> List[Robot]:
    """Robots with social paths between random poses."""
    pairs = random_pose_pairs(planner, robots, seed=seed, separation=SEPARATION)
    return [Robot(f"robot_{index + 1:02d}", planner.plan(*pair)) for index, pair in enumerate(pairs)]


def measure(robots: Sequence[Robot]) -> Row:
    """One fleet's pairs, all searched by one robot, and in shares, in turn."""
    shares = share_pairs([robot.name for robot in robots])
    every = [pair for share in shares.values() for pair in share]
    rounds = [[search(robots, pairs) for pairs in (every, *shares.values())] for _ in range(REPEATS)]
    times = np.median([[done.time for done in searches] for searches in rounds], axis=0)
    return {"robots": len(robots), "pairs": len(every), "largest_share": max(map(len, shares.values())),
            "windows": rounds[0][0].windows, "windows_of_shares": sum(done.windows for done in rounds[0][1:]),
            "central_time": times[0], "shared_time": times[1:].max(), "robot_time": times[1:].mean()}


def search(robots: Sequence[Robot], pairs: Sequence[Pair]) -> Search:
    """Search some pairs of a fleet as a robot does that has just heard of the paths."""
    by_name = {robot.name: robot for robot in robots}
    begun = time.thread_time()
    finder = EncounterFinder(TOLERANCE)
    windows = sum(len(finder.between(by_name[r], by_name[s])) for r, s in pairs)
    return Search(time.thread_time() - begun, windows)


def row_of(map_name: str, values: Sequence[Dict[str, Any]]) -> Row:
    """The fleets of one map and size in one row.

    The fleet has its windows when the slowest robot has searched its share: that is `shared_time`; `robot_time` is
    the mean of all robots. An improvement is what is saved of the one robot's time, or pairs: until the windows are
    there (`time_improvement`), or of work for a robot on average (`work_time_improvement`).
    """
    row: Row = {"map": map_name, **{name: values[0][name] for name in ("robots", "pairs", "largest_share")}}
    row["fleets"] = len(values)
    row["windows"] = float(np.mean([value["windows"] for value in values]))
    for name in ("central_time", "shared_time", "robot_time"):
        row[f"{name}_mean"], row[f"{name}_std"] = mean_and_std([value[name] for value in values])
        row[f"{name}_median"] = float(np.median([value[name] for value in values]))
    row["pairs_improvement"] = 1.0 - row["largest_share"] / row["pairs"]
    for name, own in (("time_improvement", "shared_time"), ("work_time_improvement", "robot_time")):
        row[f"{name}_mean"], row[f"{name}_std"] = mean_and_std(
            [1.0 - value[own] / value["central_time"] for value in values])
    return row


def rows_of(names: Sequence[str], sizes: Sequence[int], trials: int, values: Sequence[Dict[str, Any]]) -> List[Row]:
    """A row per map and size, of the values of `fleet_cells`."""
    per_map = trials * len(sizes)
    return [row_of(name, values[index * per_map + place:(index + 1) * per_map:len(sizes)])
            for index, name in enumerate(names) for place in range(len(sizes))]
