"""Predictability of routes: how well a place tells where a robot that drives through it is heading."""

from typing import Dict, List, Sequence

import numpy as np

from social_fleet.experiments.cells import Work
from social_fleet.experiments.charts import Bars, bar_chart
from social_fleet.experiments.frame import Experiment, Result, Row, World
from social_fleet.experiments.metrics import heading_change_per_metre, predictability
from social_fleet.experiments.trials import COLOURS, METHODS, Attempt, Methods, Pair, pair_cells, three_methods
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.routes.social_graph import learn

LEARNT = 250  # paths that the graph is made of
NAMES = {**METHODS, "social_graph": "social with graph"}
PANELS = (("entropy", "entropy of headings per square [bit]"), ("paths_per_square", "paths per square in use"),
          ("heading_change_per_metre", "heading change [rad/m]"))


class PredictabilityOfRoutes(Experiment):
    """The same random pairs for every method, the graph learnt from others."""

    name = "predictability"
    trials = 500
    maps = ("environment_1", "environment_2", "office_floor")

    def _run(self, worlds: Sequence[World], trials: int, seed: int, work: Work) -> Result:
        cells = pair_cells([world.grid for world in worlds], trials, seed, paths_of,
                           methods_on=lambda grid: four_methods(grid, seed))
        values = work.values([cell for own in cells for cell in own])
        rows = [row for index, world in enumerate(worlds)
                for row in rows_of(world.name, values[index * trials:(index + 1) * trials])]
        caption = (
            f"{trials} random pairs per map, those that every method solved. Entropy: of the eight headings driven "
            "in a square of 0.5 m, averaged over the metres driven; 0 where all robots go one way, 1 where two ways "
            "are as likely. Paths per square: how far routes are shared. The graph is learnt from "
            f"{LEARNT} other random paths.")
        bars = [Bars(label, [row["map"] for row in rows], [row["method"] for row in rows],
                     [row[key] for row in rows], [None] * len(rows)) for key, label in PANELS]
        figure = bar_chart(bars, NAMES, COLOURS, title=f"Predictability: {trials} random pairs per map",
                           caption=caption)
        settings = {"maps": [world.name for world in worlds], "trials": trials, "seed": seed, "learnt_paths": LEARNT}
        return Result(self.name, caption, rows, settings, figure)


def four_methods(grid: OccupancyGrid, seed: int) -> Methods:
    """The three, and the social planner with a graph that it has learnt."""
    methods = dict(three_methods(grid))
    on_graph = SocialPlanner(grid, graph=learn(methods["social"][0], paths=LEARNT, seed=seed + 1))
    on_graph.prepare()
    return {**methods, "social_graph": (on_graph, "social")}


def paths_of(_: OccupancyGrid, __: Pair, attempts: Dict[str, Attempt]) -> Row:
    """By method, its path of a pair (N, 2) [m]; None where it found none."""
    return {method: None if found.plan is None else found.plan.points for method, found in attempts.items()}


def rows_of(map_name: str, pairs: Sequence[Row]) -> List[Row]:
    """A row per method, on the pairs that all of them solved."""
    common = [pair for pair in pairs if all(points is not None for points in pair.values())]
    rows = []
    for method in pairs[0]:
        points = [np.array(pair[method]) for pair in common]
        measured = predictability(points)
        rows.append({"map": map_name, "method": method, "pairs": len(pairs),
                     "failed": sum(pair[method] is None for pair in pairs), "solved_by_all": len(common),
                     "entropy": measured.entropy if points else None, "squares": measured.squares,
                     "paths_per_square": measured.paths_per_square,
                     "heading_change_per_metre": heading_change_per_metre(points)})
    return rows
