"""Table 2: length, distance from the right-hand wall and planning time of A*, RRT* and the social planner."""

from typing import Any, Dict, Iterable, List, Optional, Sequence, Tuple

import numpy as np

from social_fleet.experiments.charts import Bars, bar_chart
from social_fleet.experiments.frame import Experiment, Progress, Result, Row, World, part
from social_fleet.experiments.metrics import (heading_change_per_metre, mean_wall_distance, median_wall_distance,
                                              paper_wall_distance, wall_samples)
from social_fleet.experiments.paper import TABLE_2
from social_fleet.experiments.trials import COLOURS, METHODS, Trials, mean_and_std, solve, solved_by_all
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import random_pose_pairs

PANELS = (("length", "path length [m]"), ("right_distance", "distance from the right wall,\nthe paper's rule [m]"),
          ("right_distance_median", "distance from the right wall,\nmedian of all of the way [m]"),
          ("time", "planning time [s]"))


class Table2(Experiment):
    """The same random pairs for every method."""

    name = "table2"
    trials = 500
    maps = ("environment_1", "environment_2", "office_floor")

    def _run(self, worlds: Sequence[World], trials: int, seed: int, progress: Progress) -> Result:
        rows: List[Row] = []
        for index, world in enumerate(worlds):
            planner = SocialPlanner(world.grid)
            planner.prepare()
            pairs = random_pose_pairs(planner, trials, seed=seed)
            solved = solve(planner, pairs, list(METHODS), part(progress, index, len(worlds)))
            rows += rows_of(world, solved)
        caption = (
            f"{trials} random pairs per map, the same for all methods; mean and standard deviation over the pairs that "
            "every method solved. Right distance by the paper's rule: mean over a vertex per cell, without those where "
            "both walls are 7 m away or more and those within 5 m of start and goal; pairs where that leaves a method "
            "nothing do not count. Beside it the median over the arc length, nothing left out (the table has the mean, "
            "too). Planning time includes smoothing. Hollow marks are the paper's figures; its Environment 3 is "
            "another floor than office_floor.")
        settings = {"maps": [world.name for world in worlds], "trials": trials, "seed": seed}
        bars = [Bars(label, [row["map"] for row in rows], [row["method"] for row in rows],
                     [row[f"{key}_mean"] for row in rows], [row.get(f"paper_{key}_mean") for row in rows],
                     logarithmic=key == "time") for key, label in PANELS]
        figure = bar_chart(bars, METHODS, COLOURS, title=f"Table 2: {trials} random pairs per map", caption=caption)
        return Result(self.name, caption, rows, settings, figure)


def rows_of(world: World, solved: Dict[str, Trials]) -> List[Row]:
    """A row per method: all methods are judged on the pairs that all of them solved."""
    common = solved_by_all(solved)
    distances = {method: [_distances(world.grid, trials.plans[index]) for index in common]
                 for method, trials in solved.items()}
    judged = [k for k in range(len(common)) if all(found[k][0] is not None for found in distances.values())]
    rows = []
    for method, trials in solved.items():
        plans = [plan for plan in (trials.plans[index] for index in common) if plan is not None]
        figures = {"length": [plan.length for plan in plans],
                   "right_distance": [distances[method][k][0] for k in judged],
                   "right_distance_arc": _known(mean for _, mean, _ in distances[method]),
                   "right_distance_median": _known(median for _, _, median in distances[method]),
                   "time": trials.times[common]}
        row: Row = {"map": world.name, "method": method, "pairs": len(trials.plans), "failed": trials.failed,
                    "solved_by_all": len(common), "with_right_distance": len(judged)}
        for name, values in figures.items():
            row[f"{name}_mean"], row[f"{name}_std"] = mean_and_std(values)
        row["time_median"] = float(np.median(figures["time"])) if len(common) else None
        row["heading_change_per_metre"] = heading_change_per_metre([plan.points for plan in plans])
        rows.append({**row, **_paper(world.name, method)})
    return rows


def _distances(grid: OccupancyGrid, plan: Any) -> Tuple[Optional[float], Optional[float], Optional[float]]:
    """Right distance by the paper's rule, and its mean and median over the arc length [m]."""
    samples = wall_samples(grid, plan.points)
    return paper_wall_distance(samples), mean_wall_distance(samples), median_wall_distance(samples)


def _known(values: Iterable[Optional[float]]) -> List[float]:
    return [value for value in values if value is not None]


def _paper(map_name: str, method: str) -> Row:
    """The paper's figures for the row, None where it has none."""
    printed = TABLE_2.get(map_name, {}).get(method, ((None, None),) * 3)
    return {f"paper_{name}_{kind}": value for name, values in zip(("length", "right_distance", "time"), printed)
            for kind, value in zip(("mean", "std"), values)}
