"""Figure 6: paths of A*, RRT* and the social planner between the same ends."""

from typing import Dict, List, Optional, Sequence

import numpy as np
from matplotlib.figure import Figure

from social_fleet.experiments.cells import Work
from social_fleet.experiments.frame import Experiment, Result, Row, World
from social_fleet.experiments.maps import map_panels
from social_fleet.experiments.metrics import heading_change, mean_wall_distance, paper_wall_distance, wall_samples
from social_fleet.experiments.trials import METHODS, Attempt, Pair, pair_cells
from social_fleet.geometry import Polyline
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.plan import Plan
from social_fleet.scenario.pictures.colours import INK, PALETTE
from social_fleet.scenario.pictures.fleet_layer import draw_path
from social_fleet.scenario.pictures.map_layer import content_box


class Figure6(Experiment):
    """Few pairs, so that single paths can be followed."""

    name = "fig6"
    trials = 6
    maps = ("environment_1",)
    adds_maps = False

    def _run(self, worlds: Sequence[World], trials: int, seed: int, work: Work) -> Result:
        world = worlds[0]
        pairs = work.values(pair_cells([world.grid], trials, seed, measure)[0])
        rows = [{"map": world.name, "method": method, "pair": index,
                 **{key: value for key, value in pair[method].items() if key != "points"}}
                for method in METHODS for index, pair in enumerate(pairs)]
        caption = (f"{trials} random pairs on {world.name}, from the dot to the ring, seed {seed}. A* takes the "
                   "shortest way, along whichever side and through the middle; RRT* the same with detours that chance "
                   "leaves; the social planner keeps to the wall on its right.")
        details = {"paths": [{"method": method, "pair": index, "points": pair[method]["points"]}
                             for method in METHODS for index, pair in enumerate(pairs)]}
        return Result(self.name, caption, rows, {"maps": [world.name], "trials": trials, "seed": seed},
                      _draw(world, pairs, caption), details)


def measure(grid: OccupancyGrid, pair: Pair, attempts: Dict[str, Attempt]) -> Dict[str, Row]:
    """By method, its path and what that measures."""
    start, goal = pair
    ends = {"start_x": start[0], "start_y": start[1], "goal_x": goal[0], "goal_y": goal[1]}
    return {method: {**ends, "time": found.time, **_measures(grid, found.plan)} for method, found in attempts.items()}


def _measures(grid: OccupancyGrid, plan: Optional[Plan]) -> Row:
    if plan is None:
        return dict.fromkeys(("length", "right_distance", "right_distance_arc", "heading_change", "points"))
    samples = wall_samples(grid, plan.points)
    return {"length": plan.length, "right_distance": paper_wall_distance(samples),
            "right_distance_arc": mean_wall_distance(samples), "heading_change": heading_change(plan.points),
            "points": plan.points}


def _draw(world: World, pairs: Sequence[Dict[str, Row]], caption: str) -> Figure:
    figure, panels = map_panels(world.grid, len(METHODS), title=f"Figure 6: paths on {world.name.replace('_', ' ')}",
                                caption=caption)
    box = content_box(world.grid)
    for axes, (method, name) in zip(panels, METHODS.items()):
        lengths: List[float] = []
        for index, pair in enumerate(pairs):
            path, colour = pair[method], PALETTE[index % len(PALETTE)]
            if path["points"] is not None:
                draw_path(axes, Polyline(path["points"]), colour, box, width=1.6)
                lengths.append(path["length"])
            axes.plot(path["start_x"], path["start_y"], marker="o", color=colour, markersize=6,
                      markeredgecolor="white", zorder=9)
            axes.plot(path["goal_x"], path["goal_y"], marker="o", markerfacecolor="white", markersize=6,
                      markeredgecolor=colour, markeredgewidth=2.0, zorder=9)
        mean = f", {np.mean(lengths):.1f} m on average" if lengths else ""
        axes.set_title(f"{name}{mean}", fontsize=10, color=INK, loc="left")
    return figure
