"""Figure 8: planning time on the social graph, relative to plain A*, against the paths that the graph is made of."""

import functools
from typing import Dict, List, NamedTuple, Sequence, Tuple

import numpy as np
from matplotlib.figure import Figure

from social_fleet.experiments.cells import Cell, Work
from social_fleet.experiments.charts import add_caption, add_title, plain_frame
from social_fleet.experiments.frame import Experiment, Result, Row, World
from social_fleet.experiments.trials import Pair, attempt
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import random_pose_pairs
from social_fleet.planning.routes.heatmaps import Heatmaps
from social_fleet.planning.routes.social_graph import SocialGraph
from social_fleet.scenario.pictures.colours import INK, PALETTE
from social_fleet.scenario.pictures.style import add_axes, new_figure

PATHS = (0, 10, 25, 50, 100, 150, 200, 250)  # aggregated paths at which planning is timed
REPEATS = 3  # a pair's time is the median of so many


class Timing(NamedTuple):
    """Medians over the repeats, one value per pair."""

    social: np.ndarray
    shortest: np.ndarray
    social_expanded: np.ndarray
    shortest_expanded: np.ndarray


class Figure8(Experiment):
    """The same pairs are planned again and again while the graph grows from others."""

    name = "fig8"
    trials = 100
    maps = ("environment_1", "environment_2", "office_floor")

    def _run(self, worlds: Sequence[World], trials: int, seed: int, work: Work) -> Result:
        cells = cells_of([world.grid for world in worlds], trials, seed)
        names = [world.name for world in worlds for _ in PATHS]
        rows = [{"map": name, **value} for name, value in zip(names, work.values(cells))]
        caption = (
            "Planning with Eq. 4 on a graph of so many random paths, relative to plain A* of the same minute: the "
            f"same {trials} pairs each time, each pair the median of {REPEATS}, A* and social in turn, smoothing "
            "included. Below 1 the social planner would be faster than plain A*, which the paper reports for "
            "Environments 1 and 2. Dashed: the same ratio of nodes taken from the queue, which no machine's noise "
            "touches.")
        settings = {"maps": [world.name for world in worlds], "trials": trials, "seed": seed, "repeats": REPEATS}
        return Result(self.name, caption, rows, settings, _draw(worlds, rows, caption))


def cells_of(grids: Sequence[OccupancyGrid], trials: int, seed: int) -> List[Cell]:
    """A cell for every size of the graph, map by map; planner and graphs of one map at a time are there."""
    @functools.lru_cache(maxsize=1)
    def ready(index: int) -> Tuple[SocialPlanner, List[Pair], Dict[int, SocialGraph]]:
        planner = SocialPlanner(grids[index])
        planner.prepare()
        return planner, random_pose_pairs(planner, trials, seed=seed), _graphs(planner, seed + 1)

    def compute(index: int, paths: int) -> Row:
        planner, pairs, graphs = ready(index)
        planner.graph = graphs[paths]
        return {"paths": paths, "edges": graphs[paths].edge_count, **measure(planner, pairs)}

    return [Cell({"map": grid.digest, "trials": trials, "seed": seed, "repeats": REPEATS, "paths": paths},
                 functools.partial(compute, index, paths)) for index, grid in enumerate(grids) for paths in PATHS]


def measure(planner: SocialPlanner, pairs: Sequence[Pair]) -> Row:
    """Times and nodes of both methods, and their ratios."""
    timing = time_pairs(planner, pairs)
    found = ~np.isnan(timing.social_expanded + timing.shortest_expanded)
    expanded = timing.social_expanded[found].sum(), timing.shortest_expanded[found].sum()
    return {"social_time": float(timing.social.mean()), "shortest_time": float(timing.shortest.mean()),
            "time_ratio": float(timing.social.sum() / timing.shortest.sum()),
            "expanded_ratio": float(expanded[0] / expanded[1]) if expanded[1] > 0 else None,
            "failed": int((~found).sum())}


def _graphs(planner: SocialPlanner, seed: int) -> Dict[int, SocialGraph]:
    """The graph after each number of paths in `PATHS`; the paths are planned without one."""
    heatmaps = Heatmaps(planner.grid.shape)
    graphs = {}
    pairs = random_pose_pairs(planner, max(PATHS), seed=seed)
    for count in range(max(PATHS) + 1):
        if count in PATHS:
            graphs[count] = SocialGraph.extract(heatmaps, planner.config.heatmap_threshold,
                                                planner.config.min_component, grid=planner.grid)
        if count < max(PATHS):
            heatmaps.add(planner.plan(*pairs[count]).cells)
    return graphs


def time_pairs(planner: SocialPlanner, pairs: Sequence[Pair]) -> Timing:
    """Plain A* and the social planner in turn, pair by pair, several times; the first pass only warms up."""
    methods = ("social", "shortest")
    times = np.zeros((REPEATS + 1, len(pairs), 2))
    expanded = np.full((len(pairs), 2), np.nan)
    for repeat in range(REPEATS + 1):
        for index, pair in enumerate(pairs):
            for which, method in enumerate(methods):
                plan, times[repeat, index, which] = attempt(planner, pair, method)
                expanded[index, which] = np.nan if plan is None else plan.expanded
    medians = np.median(times[1:], axis=0)
    return Timing(medians[:, 0], medians[:, 1], expanded[:, 0], expanded[:, 1])


def _draw(worlds: Sequence[World], rows: Sequence[Row], caption: str) -> Figure:
    figure = new_figure(8.0, 4.8)
    axes = add_axes(figure, 0.75, 0.6, 6.9, 3.8)
    for world, colour in zip(worlds, PALETTE):
        own = [row for row in rows if row["map"] == world.name]
        counts = [row["paths"] for row in own]
        axes.plot(counts, [row["time_ratio"] for row in own], color=colour, marker="o", linewidth=1.8,
                  label=world.name.replace("_", " "))
        axes.plot(counts, [row["expanded_ratio"] for row in own], color=colour, linewidth=1.0, linestyle="--")
    axes.axhline(1.0, color=INK, linewidth=1.0, zorder=1)
    axes.annotate("plain A*", (max(PATHS), 1.0), xytext=(0, 3), textcoords="offset points", ha="right", fontsize=8,
                  color=INK)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("aggregated paths", fontsize=9, color=INK)
    axes.set_ylabel("planning time relative to plain A*", fontsize=9, color=INK)
    plain_frame(axes)
    axes.legend(frameon=False, fontsize=9)
    add_title(figure, "Figure 8: what the social graph does to planning time")
    add_caption(figure, caption)
    return figure
