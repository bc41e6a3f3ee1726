"""Table 2: length, distance from the right-hand wall and planning time of A*, RRT* and the social planner."""

from typing import Dict, List, Optional, Sequence

import numpy as np

from social_fleet.experiments.cells import Work
from social_fleet.experiments.charts import Bars, bar_chart
from social_fleet.experiments.frame import Experiment, Result, Row, World
from social_fleet.experiments.metrics import (heading_change, mean_wall_distance, median_wall_distance,
                                              paper_wall_distance, wall_samples)
from social_fleet.experiments.paper import TABLE_2
from social_fleet.experiments.trials import COLOURS, METHODS, Attempt, Pair, mean_and_std, pair_cells
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.plan import Plan

PANELS = (("length", "path length [m]"), ("right_distance", "distance from the right wall,\nthe paper's rule [m]"),
          ("right_distance_median", "distance from the right wall,\nmedian of all of the way [m]"),
          ("time", "planning time [s]"))


class Table2(Experiment):
    """The same random pairs for every method."""

    name = "table2"
    trials = 500
    maps = ("environment_1", "environment_2", "office_floor")

    def _run(self, worlds: Sequence[World], trials: int, seed: int, work: Work) -> Result:
        cells = pair_cells([world.grid for world in worlds], trials, seed, measure)
        values = work.values([cell for own in cells for cell in own])
        rows = [row for index, world in enumerate(worlds)
                for row in rows_of(world.name, values[index * trials:(index + 1) * trials])]
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


def measure(grid: OccupancyGrid, _: Pair, attempts: Dict[str, Attempt]) -> Row:
    """By method, what its plan of a pair measures; but for the time all None where it found none."""
    return {method: {"time": found.time, **_measures(grid, found.plan)} for method, found in attempts.items()}


def _measures(grid: OccupancyGrid, plan: Optional[Plan]) -> Row:
    if plan is None:
        return dict.fromkeys(("length", "right_distance", "right_distance_arc", "right_distance_median", "turns"))
    samples = wall_samples(grid, plan.points)
    return {"length": plan.length, "right_distance": paper_wall_distance(samples),
            "right_distance_arc": mean_wall_distance(samples), "right_distance_median": median_wall_distance(samples),
            "turns": heading_change(plan.points)}


def rows_of(map_name: str, pairs: Sequence[Row]) -> List[Row]:
    """A row per method, from what `measure` gave for each pair: all are judged on the pairs that all of them solved."""
    common = [pair for pair in pairs if all(each["length"] is not None for each in pair.values())]
    judged = [pair for pair in common if all(each["right_distance"] is not None for each in pair.values())]
    rows = []
    for method in pairs[0]:
        own = [pair[method] for pair in common]
        row: Row = {"map": map_name, "method": method, "pairs": len(pairs),
                    "failed": sum(pair[method]["length"] is None for pair in pairs),
                    "solved_by_all": len(common), "with_right_distance": len(judged)}
        for name in ("length", "right_distance", "right_distance_arc", "right_distance_median", "time"):
            among = [pair[method] for pair in judged] if name == "right_distance" else own
            row[f"{name}_mean"], row[f"{name}_std"] = mean_and_std([each[name] for each in among
                                                                    if each[name] is not None])
        row["time_median"] = float(np.median([each["time"] for each in own])) if own else None
        way = sum(each["length"] for each in own)
        row["heading_change_per_metre"] = sum(each["turns"] for each in own) / way if way > 0.0 else 0.0
        rows.append({**row, **_paper(map_name, method)})
    return rows


def _paper(map_name: str, method: str) -> Row:
    """The paper's figures for the row, None where it has none."""
    printed = TABLE_2.get(map_name, {}).get(method, ((None, None),) * 3)
    return {f"paper_{name}_{kind}": value for name, values in zip(("length", "right_distance", "time"), printed)
            for kind, value in zip(("mean", "std"), values)}
