"""Predictability of routes: how well a place tells where a robot that drives through it is heading."""

from typing import Dict, List, Optional, Sequence

from social_fleet.experiments.charts import Bars, bar_chart
from social_fleet.experiments.frame import Experiment, Progress, Result, Row, World, part
from social_fleet.experiments.metrics import heading_change_per_metre, predictability
from social_fleet.experiments.trials import COLOURS, METHODS, Trials, solve, solved_by_all
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import random_pose_pairs
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

    def _run(self, worlds: Sequence[World], trials: int, seed: int, progress: Progress) -> Result:
        rows: List[Row] = []
        for index, world in enumerate(worlds):
            rows += measure(world, trials, seed, part(progress, index, len(worlds)))
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


def measure(world: World, trials: int, seed: int, progress: Progress) -> List[Row]:
    """A row per method."""
    planner = SocialPlanner(world.grid)
    planner.prepare()
    pairs = random_pose_pairs(planner, trials, seed=seed)
    solved: Dict[str, Trials] = solve(planner, pairs, list(METHODS), part(progress, 0, 2))
    planner.graph = learn(planner, paths=LEARNT, seed=seed + 1,
                          progress=lambda done, count: progress(0.5 + 0.25 * done / count))
    solved["social_graph"] = solve(planner, pairs, ["social"], lambda share: progress(0.75 + 0.25 * share))["social"]
    common = solved_by_all(solved)
    rows = []
    for method, each in solved.items():
        points = [plan.points for plan in (each.plans[index] for index in common) if plan is not None]
        measured = predictability(points)
        entropy: Optional[float] = measured.entropy if points else None
        rows.append({"map": world.name, "method": method, "pairs": trials, "failed": each.failed,
                     "solved_by_all": len(common), "entropy": entropy, "squares": measured.squares,
                     "paths_per_square": measured.paths_per_square,
                     "heading_change_per_metre": heading_change_per_metre(points)})
    return rows
