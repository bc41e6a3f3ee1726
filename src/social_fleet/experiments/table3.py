"""Table 3: how much sooner a few robots that share the search for encounter windows have them than one alone."""

from typing import List, Optional, Sequence

from matplotlib.figure import Figure

from social_fleet.experiments.cells import Work
from social_fleet.experiments.charts import Bars, bar_chart
from social_fleet.experiments.frame import Experiment, Result, Row, World
from social_fleet.experiments.paper import TABLE_3
from social_fleet.experiments.sharing import REPEATS, fleet_cells, rows_of

SIZES = (3, 4, 5)
NAMES = {"central": "one robot alone", "shared": "the last to be done of those that share",
         "robot": "mean of those that share"}
COLOURS = {"central": "#B0B0B0", "shared": "#009E73", "robot": "#56B4E9"}


class Table3(Experiment):
    """Fleets of three to five robots."""

    name = "table3"
    trials = 100
    maps = ("office_floor",)

    def _run(self, worlds: Sequence[World], trials: int, seed: int, work: Work) -> Result:
        values = work.values(fleet_cells([world.grid for world in worlds], SIZES, trials, seed))
        rows: List[Row] = []
        for row in rows_of([world.name for world in worlds], SIZES, trials, values):
            mean, std = TABLE_3.get(row["robots"], (None, None))
            rows.append({**row, "paper_time_improvement_mean": mean, "paper_time_improvement_std": std})
        saved = max(row["central_time_mean"] - row["shared_time_mean"] for row in rows)
        caption = (
            f"{trials} random fleets of each size. Processor time, each the median of {REPEATS}, mean over the fleets; "
            "saved: of the time that one robot takes for all pairs. All windows are there when the last robot is done. "
            "Time saved is less than pairs saved: pairs take unequally long, and each robot cuts the paths of its "
            "pairs into links itself. Hollow marks are the paper's figures, from robots that also had to talk. Here "
            f"nobody talks: sharing pays as long as that takes less than the {1e3 * saved:.2g} ms saved at most.")
        settings = {"maps": [world.name for world in worlds], "trials": trials, "seed": seed, "repeats": REPEATS}
        return Result(self.name, caption, rows, settings, _draw(rows, caption, several=len(worlds) > 1))


def _draw(rows: Sequence[Row], caption: str, *, several: bool) -> Figure:
    groups = [f"{row['map']}\n{row['robots']} robots" if several else f"{row['robots']} robots" for row in rows]
    series = [name for name in NAMES for _ in rows]
    nothing: List[Optional[float]] = [None] * len(rows)
    pairs = [row["pairs"] for row in rows], [row["largest_share"] for row in rows], [
        row["pairs"] / row["robots"] for row in rows]
    times = [1e3 * row[f"{name}_time_mean"] for name in NAMES for row in rows]
    saved = [100.0 * row[key] for key in ("time_improvement_mean", "work_time_improvement_mean") for row in rows]
    printed = [None if mean is None else 100.0 * mean for mean in (row["paper_time_improvement_mean"] for row in rows)]
    panels = [Bars("pairs searched", groups * 3, series, sum(pairs, []), nothing * 3),
              Bars("time of the search [ms]", groups * 3, series, times, nothing * 3),
              Bars("saved [%]", groups * 3, series, [*nothing, *saved], [*nothing, *printed, *nothing])]
    return bar_chart(panels, NAMES, COLOURS, title="Table 3: sharing the search for encounter windows", caption=caption)
