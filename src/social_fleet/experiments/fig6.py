"""Figure 6: paths of A*, RRT* and the social planner between the same ends."""

from typing import Dict, List, Sequence

import numpy as np
from matplotlib.figure import Figure

from social_fleet.experiments.frame import Experiment, Progress, Result, Row, World
from social_fleet.experiments.maps import map_panels
from social_fleet.experiments.metrics import heading_change, mean_wall_distance, paper_wall_distance, wall_samples
from social_fleet.experiments.trials import METHODS, Pair, Trials, solve
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import random_pose_pairs
from social_fleet.scenario.pictures.colours import INK, PALETTE
from social_fleet.scenario.pictures.fleet_layer import draw_path
from social_fleet.scenario.pictures.map_layer import content_box


class Figure6(Experiment):
    """Few pairs, so that single paths can be followed."""

    name = "fig6"
    trials = 6
    maps = ("environment_1",)
    adds_maps = False

    def _run(self, worlds: Sequence[World], trials: int, seed: int, progress: Progress) -> Result:
        world = worlds[0]
        planner = SocialPlanner(world.grid)
        pairs = random_pose_pairs(planner, trials, seed=seed)
        solved = solve(planner, pairs, list(METHODS), progress)
        rows = [_row(world, method, index, pair, each) for method, each in solved.items()
                for index, pair in enumerate(pairs)]
        caption = (f"{trials} random pairs on {world.name}, from the dot to the ring, seed {seed}. A* takes the "
                   "shortest way, along whichever side and through the middle; RRT* the same with detours that chance "
                   "leaves; the social planner keeps to the wall on its right.")
        details = {"paths": [{"method": method, "pair": index, "points": None if plan is None else plan.points}
                             for method, each in solved.items() for index, plan in enumerate(each.plans)]}
        return Result(self.name, caption, rows, {"maps": [world.name], "trials": trials, "seed": seed},
                      _draw(world, pairs, solved, caption), details)


def _row(world: World, method: str, index: int, pair: Pair, trials: Trials) -> Row:
    row: Row = {"map": world.name, "method": method, "pair": index, "start_x": pair[0][0], "start_y": pair[0][1],
                "goal_x": pair[1][0], "goal_y": pair[1][1], "time": float(trials.times[index])}
    plan = trials.plans[index]
    measures: Row = dict.fromkeys(("length", "right_distance", "right_distance_arc", "heading_change"))
    if plan is not None:
        samples = wall_samples(world.grid, plan.points)
        measures = {"length": plan.length, "right_distance": paper_wall_distance(samples),
                    "right_distance_arc": mean_wall_distance(samples), "heading_change": heading_change(plan.points)}
    return {**row, **measures}


def _draw(world: World, pairs: Sequence[Pair], solved: Dict[str, Trials], caption: str) -> Figure:
    figure, panels = map_panels(world.grid, len(solved), title=f"Figure 6: paths on {world.name.replace('_', ' ')}",
                                caption=caption)
    box = content_box(world.grid)
    for axes, (method, trials) in zip(panels, solved.items()):
        lengths: List[float] = []
        for index, (pair, plan) in enumerate(zip(pairs, trials.plans)):
            colour = PALETTE[index % len(PALETTE)]
            if plan is not None:
                draw_path(axes, plan.path, colour, box, width=1.6)
                lengths.append(plan.length)
            axes.plot(*pair[0], marker="o", color=colour, markersize=6, markeredgecolor="white", zorder=9)
            axes.plot(*pair[1], marker="o", markerfacecolor="white", markersize=6, markeredgecolor=colour,
                      markeredgewidth=2.0, zorder=9)
        mean = f", {np.mean(lengths):.1f} m on average" if lengths else ""
        axes.set_title(f"{METHODS[method]}{mean}", fontsize=10, color=INK, loc="left")
    return figure
