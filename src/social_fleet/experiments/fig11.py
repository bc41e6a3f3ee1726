"""Figure 11: path segments in which robots get into each other's way, against the size of the fleet."""

import functools
from typing import Any, Dict, List, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from social_fleet.coordination.robot import Robot
from social_fleet.experiments.cells import Cell, Work
from social_fleet.experiments.charts import add_caption, add_title, label_ends, plain_frame
from social_fleet.experiments.fleets import random_specs, seed_of, windows_of
from social_fleet.experiments.frame import Experiment, Result, Row, World
from social_fleet.experiments.overlaps import overlaps_of
from social_fleet.experiments.trials import COLOURS, METHODS, solve, three_methods
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.pictures.colours import INK
from social_fleet.scenario.pictures.fleet_layer import map_inches
from social_fleet.scenario.pictures.map_layer import content_box, draw_map
from social_fleet.scenario.pictures.style import add_axes, new_figure

SIZES = tuple(range(2, 21))
SHOWN = 20  # robots of the fleet whose paths are drawn
RADIUS = 0.25  # [m]
MEETING = "#D0202B"


class Figure11(Experiment):
    """Random fleets; a smaller one is the first robots of a larger one, so that their difference is no chance."""

    name = "fig11"
    trials = 100
    maps = ("environment_1",)
    adds_maps = False

    def _run(self, worlds: Sequence[World], trials: int, seed: int, work: Work) -> Result:
        world = worlds[0]
        values = work.values(cells_of(world.grid, trials, seed))
        rows = rows_of(world, values[:-1])
        last = {row["method"]: row for row in rows if row["robots"] == SIZES[-1]}
        counts = ", ".join(f"{title} {last[method]['segments_mean']:.0f}" for method, title in METHODS.items())
        caption = (
            f"{trials} random fleets on {world.name.replace('_', ' ')}, the same for all planners. Above: segments of "
            "0.2 m on which a robot's disc could touch another one that is not going its way; mean, and as a band two "
            "standard errors. Right: windows in which one has to let the other pass. The paper prints no numbers; it "
            f"finds fewest segments with the social planner. Here, with {SIZES[-1]} robots: {counts}. Below: the first "
            "of the fleets; red where two get into each other's way.")
        settings = {"maps": [world.name], "trials": trials, "seed": seed, "robots": list(SIZES), "radius": RADIUS}
        return Result(self.name, caption, rows, settings, _draw(world, rows, values[-1], caption),
                      {"example": values[-1]})


def cells_of(grid: OccupancyGrid, trials: int, seed: int) -> List[Cell]:
    """A cell per fleet, and last one that keeps the paths of the first fleet."""
    @functools.lru_cache(maxsize=1)
    def methods() -> Any:
        return three_methods(grid)

    def fleets(trial: int, count: int) -> Dict[str, List[Robot]]:
        specs = random_specs(grid, [f"robot_{index + 1}" for index in range(count)], seed_of(seed, trial))
        made: Dict[str, List[Robot]] = {method: [] for method in METHODS}
        for spec in specs:
            found = solve(methods(), (spec.start, spec.goal))  # type: ignore[arg-type]
            plans = {method: attempt.plan for method, attempt in found.items() if attempt.plan is not None}
            if len(plans) == len(METHODS):  # else nobody's fleet has this robot
                for method, plan in plans.items():
                    made[method].append(Robot(spec.name, plan, radius=RADIUS))
        return made

    def count(trial: int) -> Dict[str, List[Row]]:
        return {method: measure(fleet) for method, fleet in fleets(trial, SIZES[-1]).items()}

    def example() -> Dict[str, Row]:
        return {method: {"paths": [robot.path.points for robot in fleet],
                         "meeting": overlaps_of([robot.path for robot in fleet], 2.0 * RADIUS).middles}
                for method, fleet in fleets(0, SHOWN).items()}

    key = {"map": grid.digest, "seed": seed}
    cells = [Cell({**key, "sizes": SIZES, "trial": trial}, functools.partial(count, trial)) for trial in range(trials)]
    return [*cells, Cell({**key, "example": SHOWN}, example)]


def measure(fleet: Sequence[Robot]) -> List[Row]:
    """What Figure 11 counts, segments and windows, of the first robots of a fleet, for every size."""
    overlaps = overlaps_of([robot.path for robot in fleet], 2.0 * RADIUS)
    places = {robot.name: index for index, robot in enumerate(fleet)}
    windows = np.array([max(places[window.robot_r], places[window.robot_s]) + 1 for window in windows_of(fleet)
                        if window.kind != "same_direction"])
    return [{"robots": size, "segments": overlaps.count(size), "windows": int((windows <= size).sum())}
            for size in SIZES]


def rows_of(world: World, trials: Sequence[Dict[str, List[Row]]]) -> List[Row]:
    """A row per size and method, over all trials."""
    rows = []
    for index, size in enumerate(SIZES):
        for method in METHODS:
            row: Row = {"map": world.name, "robots": size, "method": method, "trials": len(trials)}
            for name in ("segments", "windows"):
                values = [trial[method][index][name] for trial in trials]
                row[f"{name}_mean"], row[f"{name}_std"] = float(np.mean(values)), float(np.std(values))
            rows.append(row)
    return rows


def _draw(world: World, rows: Sequence[Row], example: Dict[str, Row], caption: str) -> Figure:
    box = content_box(world.grid)
    width, height = map_inches(box, 3.5)
    figure = new_figure(3.0 * (width + 0.4) + 0.7, height + 4.6)
    across = 0.5 * (figure.get_figwidth() - 2.0)
    for index, (name, label) in enumerate((("segments", "overlapping segments per fleet"),
                                           ("windows", "windows, one at a time, per fleet"))):
        axes = add_axes(figure, 0.8 + index * (across + 0.8), height + 1.4, across, 3.0)
        _draw_counts(axes, rows, name, label)
    for index, (method, shown) in enumerate(example.items()):
        axes = add_axes(figure, 0.6 + index * (width + 0.4), 0.4, width, height)
        draw_map(axes, world.grid, box)
        for points in shown["paths"]:
            axes.plot(*np.array(points).T, color=COLOURS[method], linewidth=1.4, zorder=5)
        if shown["meeting"]:
            axes.scatter(*np.array(shown["meeting"]).T, s=9.0, color=MEETING, linewidths=0, zorder=6)
        axes.set(xlabel="", ylabel="", xticks=[], yticks=[])
        axes.set_title(f"{METHODS[method]}, {len(shown['paths'])} robots: {len(shown['meeting'])} segments",
                       fontsize=9.5, color=INK, loc="left")
    add_title(figure, "Figure 11: how much robots get into each other's way")
    add_caption(figure, caption)
    return figure


def _draw_counts(axes: Axes, rows: Sequence[Row], name: str, label: str) -> None:
    ends = []
    for method, title in METHODS.items():
        own = [row for row in rows if row["method"] == method]
        sizes = np.array([row["robots"] for row in own])
        means = np.array([row[f"{name}_mean"] for row in own])
        errors = 2.0 * np.array([row[f"{name}_std"] / np.sqrt(row["trials"]) for row in own])
        axes.fill_between(sizes, means - errors, means + errors, color=COLOURS[method], alpha=0.2, linewidth=0)
        axes.plot(sizes, means, color=COLOURS[method], linewidth=2.0)
        ends.append((title, COLOURS[method], sizes[-1], means[-1]))
    axes.set_ylim(bottom=0.0)
    label_ends(axes, ends)
    axes.set_xticks(range(2, SIZES[-1] + 1, 2))
    axes.set_xlabel("robots", fontsize=9, color=INK)
    axes.set_ylabel(label, fontsize=9, color=INK)
    plain_frame(axes)
