"""Table 3: how much sooner a few robots that share the search for encounter windows have them than one alone."""

from typing import List, Sequence

from matplotlib.figure import Figure

from social_fleet.experiments.cells import Work
from social_fleet.experiments.charts import Bars, bar_chart
from social_fleet.experiments.frame import Experiment, Result, Row, World
from social_fleet.experiments.paper import TABLE_3
from social_fleet.experiments.sharing import REPEATS, fleet_cells, rows_of

SIZES = (3, 4, 5)
NAMES = {"time": "time until all windows are there", "work_time": "work of a robot, mean",
         "pairs": "pairs of the busiest robot"}
COLOURS = {"time": "#009E73", "work_time": "#56B4E9", "pairs": "#B0B0B0"}


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
            f"{trials} random fleets of each size; what sharing saves of the time that one robot takes to search all "
            f"pairs, mean over the fleets, each time the median of {REPEATS}. All windows are there when the slowest "
            "robot is done, and pairs take unequally long: those that never come near cost next to nothing. Hollow "
            "marks are the paper's figures, from robots that also had to talk to each other. Here nobody talks: "
            f"sharing pays as long as that takes less than the {1e3 * saved:.2g} ms that are saved at most.")
        settings = {"maps": [world.name for world in worlds], "trials": trials, "seed": seed, "repeats": REPEATS}
        return Result(self.name, caption, rows, settings, _draw(rows, caption, several=len(worlds) > 1))


def _draw(rows: Sequence[Row], caption: str, *, several: bool) -> Figure:
    groups = [f"{row['map']}\n{row['robots']} robots" if several else f"{row['robots']} robots" for row in rows]
    keys = {"time": "time_improvement_mean", "work_time": "work_time_improvement_mean", "pairs": "pairs_improvement"}
    papers = [row["paper_time_improvement_mean"] if name == "time" else None for name in keys for row in rows]
    bars = Bars("saved by sharing the search [%]", groups * len(keys), [name for name in keys for _ in rows],
                [100.0 * row[key] for key in keys.values() for row in rows],
                [None if share is None else 100.0 * share for share in papers])
    return bar_chart([bars], NAMES, COLOURS, title="Table 3: what sharing saves", caption=caption)
