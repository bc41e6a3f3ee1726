"""Figure 10: whole fleets by our coordination, conflict-based search and prioritized planning."""

import functools
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from social_fleet.experiments.cells import Cell, Work
from social_fleet.experiments.charts import add_caption, add_title, plain_frame
from social_fleet.experiments.fleet_methods import METHODS, FleetMethods
from social_fleet.experiments.fleets import random_specs, seed_of
from social_fleet.experiments.frame import Experiment, Result, Row, World
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.pictures.colours import INK
from social_fleet.scenario.pictures.style import add_axes, new_figure

SIZES = (2, 4, 8, 16, 32, 64, 100)
COLOURS = {"ours": "#009E73", "cbs": "#D55E00", "pp": "#0072B2", "pp_fine": "#56B4E9"}
PANELS = (("success_rate", "fleets solved", False), ("time_mean", "time [s], all in", True),
          ("makespan_ratio_mean", "makespan / longest way alone", False),
          ("sum_ratio_mean", "sum of completion / alone", False))
MEANS = ("time", "planning_time", "windows_time", "solving_time", "makespan", "sum_of_completion", "gap")
NOT_RUN: Dict[str, Any] = {"failure": "not_run", "reason": "the method solved no fleet of a smaller size", "time": None}

Trials = Dict[Tuple[int, str], List[Any]]  # by size and method, or "alone": a value per trial


class Figure10(Experiment):
    """Random fleets, the same for all methods; a smaller one is the first robots of a larger one."""

    name = "fig10"
    trials = 25
    maps = ("environment_1",)
    adds_maps = False
    limit = 120.0

    def _run(self, worlds: Sequence[World], trials: int, seed: int, work: Work) -> Result:
        world = worlds[0]
        limit = float(self.limit)
        values = measure(world.grid, trials, seed, limit, work)
        rows = rows_of(world, values)
        not_run = [{"method": row["method"], "robots": row["robots"]} for row in rows if row["not_run"]]
        caption = (
            f"{trials} random fleets per size on {world.name.replace('_', ' ')}, the same for all; a solve that takes "
            f"more than {limit:g} s has failed, and where a method has solved no fleet of a size, larger ones count as "
            "failed without a try. Times are from starts and goals to the schedule, means over the fleets solved; "
            "dotted, our solving alone, which is what the paper times. Ratios are to robots that nobody meets, on the "
            "shortest way at full speed: ours drive social ways, accelerate, turn in place and keep a second and 0.2 m "
            "between each other; those of CBS and PP are at full speed at once and may all but touch. The paper's "
            "curves have no printed numbers.")
        settings = {"maps": [world.name], "trials": trials, "seed": seed, "robots": list(SIZES), "limit": limit}
        details = {"not_run": not_run, "trials": [
            {"robots": size, "method": method, "trial": trial, **value}
            for (size, method), own in values.items() if method in METHODS for trial, value in enumerate(own)]}
        return Result(self.name, caption, rows, settings, _draw(rows, caption), details)


def measure(grid: OccupancyGrid, trials: int, seed: int, limit: float, work: Work) -> Trials:
    """All trials, size by size: a method that has solved no fleet of a size is not run on larger ones."""
    @functools.lru_cache(maxsize=1)
    def methods() -> FleetMethods:
        return FleetMethods(grid)

    names = [*METHODS, "alone"]
    values: Trials = {}
    running = set(names)
    total, done = len(SIZES) * trials * len(names), 0
    for size in SIZES:
        pairs = [(trial, name) for trial in range(trials) for name in names if name in running]
        cells = [_cell(grid, methods, size, trial, name, seed, limit) for trial, name in pairs]
        found = dict(zip(pairs, work.values(cells, before=done, total=total)))
        for name in names:
            values[size, name] = [found.get((trial, name), NOT_RUN) for trial in range(trials)]
            if name in METHODS and all(value["failure"] for value in values[size, name]):
                running.discard(name)
        done += trials * len(names)
        work.progress(done, total)
    return values


def _cell(grid: OccupancyGrid, methods: Callable[[], FleetMethods], size: int, trial: int, name: str, seed: int,
          limit: float) -> Cell:
    """One fleet by one method."""
    def compute() -> Any:
        specs = random_specs(grid, [f"robot_{index + 1:03d}" for index in range(size)], seed_of(seed, trial))
        return methods().alone(specs) if name == "alone" else methods().attempt(name, specs, limit)

    return Cell({"map": grid.digest, "seed": seed, "robots": size, "trial": trial, "method": name, "limit": limit},
                compute)


def rows_of(world: World, values: Trials) -> List[Row]:
    """A row per size and method. Means are over the fleets that the method solved, ratios each to its own fleet's."""
    rows: List[Row] = []
    for size in SIZES:
        alone = values[size, "alone"]
        for method in METHODS:
            own = values[size, method]
            solved = [(value, times) for value, times in zip(own, alone) if not value["failure"]]
            row: Row = {"map": world.name, "robots": size, "method": method, "trials": len(own), "solved": len(solved),
                        "success_rate": len(solved) / len(own), "not_run": own[0]["failure"] == "not_run"}
            for name in MEANS:
                row[f"{name}_mean"] = _mean([value[name] for value, _ in solved])
            row["time_max"] = max((value["time"] for value, _ in solved), default=None)
            row["makespan_ratio_mean"] = _mean([value["makespan"] / max(times) for value, times in solved])
            row["sum_ratio_mean"] = _mean([value["sum_of_completion"] / sum(times) for value, times in solved])
            row["min_clearance"] = min((value["min_clearance"] for value, _ in solved), default=None)
            rows.append(row)
    return rows


def _mean(values: Sequence[float]) -> Optional[float]:
    return float(np.mean(values)) if len(values) else None


def _draw(rows: Sequence[Row], caption: str) -> Figure:
    figure = new_figure(4 * 3.45 + 0.3, 4.15)
    for index, (name, label, logarithmic) in enumerate(PANELS):
        axes = add_axes(figure, 0.7 + index * 3.45, 0.6, 2.65, 3.1)
        _draw_lines(axes, rows, name, label, logarithmic)
        if name == "time_mean":
            own = [row for row in rows if row["method"] == "ours" and row["solving_time_mean"] is not None]
            axes.plot([row["robots"] for row in own], [row["solving_time_mean"] for row in own], color=COLOURS["ours"],
                      linewidth=1.4, linestyle=":", label="ours, solving alone")
    handles, labels = figure.axes[1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper right", ncol=len(labels), frameon=False, fontsize=9)
    add_title(figure, "Figure 10: whole fleets")
    add_caption(figure, caption)
    return figure


def _draw_lines(axes: Axes, rows: Sequence[Row], name: str, label: str, logarithmic: bool) -> None:
    for index, (method, title) in enumerate(METHODS.items()):
        own = [row for row in rows if row["method"] == method and row[name] is not None]
        axes.plot([row["robots"] for row in own], [row[name] for row in own], color=COLOURS[method], marker="o",
                  markersize=6 - index, linewidth=3.4 - 0.7 * index, label=title)  # a line on another leaves it seen
    axes.set_xscale("log", base=2)
    axes.set_xticks(SIZES)
    axes.set_xticklabels([str(size) for size in SIZES])
    if logarithmic:
        axes.set_yscale("log")
    else:
        axes.set_ylim(*((0.0, 1.05) if name == "success_rate" else (1.0, None)))
    axes.set_xlabel("robots", fontsize=9, color=INK)
    axes.set_ylabel(label, fontsize=9, color=INK)
    plain_frame(axes)
