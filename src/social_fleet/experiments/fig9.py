"""Figure 9: four robots of different speeds, coordinated at once: paths, windows, and progress over time."""

import functools
import time
from dataclasses import asdict, replace
from typing import Any, Dict, List, Sequence

import numpy as np
from matplotlib.figure import Figure

from social_fleet.coordination.replanning import PlannerReplanner
from social_fleet.experiments.cells import Cell, Work
from social_fleet.experiments.charts import add_caption
from social_fleet.experiments.fleets import Outcome, coordinated, random_specs
from social_fleet.experiments.frame import Experiment, Result, Row, World
from social_fleet.scenario.fleet import FleetPlanner
from social_fleet.scenario.pictures.schedule_picture import schedule_figure
from social_fleet.scenario.scenario import RobotSpec

ROBOTS = (RobotSpec("blue", (2.0, 25.0), (97.0, 40.0), max_speed=0.7),
          RobotSpec("purple", (2.0, 40.0), (97.0, 50.0), max_speed=0.7 / 1.2),
          RobotSpec("gold", (85.0, 50.0), (50.0, 80.0), max_speed=0.7 / 3.2),
          RobotSpec("green", (50.0, 20.0), (50.0, 65.0), max_speed=0.7 / 3.0))


class Figure9(Experiment):
    """The paper's four robots; on another map four random ones of the same speeds. Trials only repeat the timing."""

    name = "fig9"
    trials = 5
    maps = ("environment_1",)
    adds_maps = False

    def _run(self, worlds: Sequence[World], trials: int, seed: int, work: Work) -> Result:
        world = worlds[0]
        specs = robots_on(world, seed)
        compute = functools.partial(planned, world, specs)
        key = {"map": world.grid.digest, "robots": [asdict(spec) for spec in specs]}
        cells = [Cell({**key, "repeat": repeat}, compute) for repeat in range(trials)]
        found = [Outcome.from_value(value) for value in work.values(cells)]
        first = found[0]
        caption = (
            f"Four robots on {world.name.replace('_', ' ')}, speeds 0.7 m/s over 1, 1.2, 3.2 and 3, all leaving at "
            "once. Left: paths, and where two robots could touch. Right: progress; thick where "
            "the others hold a robot up. " + _orders(first))
        if world.is_package(self.maps[0]):
            caption += _beside_the_paper(first)
        times = {f"{part}_time": float(np.median([getattr(each.fleet, f"{part}_time") for each in found]))
                 for part in ("planning", "encounter", "solve")}
        details = {"min_clearance": first.min_clearance, "makespan": first.fleet.makespan, **times,
                   "windows": [vars(window) for window in first.fleet.windows], "message": first.fleet.message}
        return Result(self.name, caption, rows_of(world, first),
                      {"maps": [world.name], "trials": trials, "seed": seed}, _draw(world, first, caption), details)


def robots_on(world: World, seed: int) -> List[RobotSpec]:
    """The paper's robots where they fit, else random ones of their names and speeds."""
    if world.is_package("environment_1"):
        return list(ROBOTS)
    drawn = random_specs(world.grid, [spec.name for spec in ROBOTS], seed)
    return [replace(spec, max_speed=given.max_speed) for spec, given in zip(drawn, ROBOTS)]


def planned(world: World, specs: Sequence[RobotSpec]) -> Dict[str, Any]:
    """The fleet planned and coordinated, as a cell's value."""
    planners = FleetPlanner(world.grid)
    planners.plan(specs[0])  # so that what is worked out once per map is in nobody's time
    begun = time.perf_counter()
    robots = [planners.plan(spec) for spec in specs]
    taken = time.perf_counter() - begun
    found = coordinated(robots, replanner=PlannerReplanner(planners.for_radius))
    return found._replace(fleet=replace(found.fleet, planning_time=found.fleet.planning_time + taken)).to_value()


def rows_of(world: World, found: Outcome) -> List[Row]:
    """A row per robot."""
    rows = []
    for schedule, alone, delay in zip(found.fleet.schedules, found.alone, found.delays):
        own = [window for window in found.fleet.windows if schedule.name in (window.robot_r, window.robot_s)]
        rows.append({"map": world.name, "robot": schedule.name, "max_speed": schedule.robot.max_speed,
                     "path_length": schedule.robot.path.length, "arrival": schedule.arrival_time,
                     "arrival_alone": alone, "delay": round(delay, 6) + 0.0, "windows": len(own),
                     "first_in": sum(window.first == schedule.name for window in own)})
    return rows


def _orders(found: Outcome) -> str:
    """Who goes first, and how close they come, as a sentence."""
    if not found.feasible:
        return found.reason
    orders = ", ".join(f"{first} before {second}" for first, second in passing_orders(found))
    gap = "" if found.min_clearance is None else f"; no two come closer than {found.min_clearance:.2f} m"
    return f"Here {orders or 'nobody meets'}{gap}."


def _beside_the_paper(found: Outcome) -> str:
    """What the paper says of its figure, and how it is in ours."""
    orders = passing_orders(found)
    gold = [order for order in orders if "gold" in order]
    lane = [order[0] for order in orders if {"blue", "purple"} == set(order)]
    return (" In the paper gold, the slowest, goes through the crossing before the others; here it meets "
            + (" and ".join(next(name for name in order if name != "gold") for order in gold) or "nobody")
            + f" and goes first in {sum(order[0] == 'gold' for order in gold)} of {len(gold)} cases. Blue and purple "
            + f"keep their order all along their lane in the paper; here, {' and '.join(lane) or 'nobody'} leads.")


def passing_orders(found: Outcome) -> List[Sequence[str]]:
    """Pairs of names, first and second, once each; both ways when a pair changes its order between windows."""
    pairs = [(window.first, window.robot_s if window.first == window.robot_r else window.robot_r)
             for window in found.fleet.windows]
    return list(dict.fromkeys(pairs))


def _draw(world: World, found: Outcome, caption: str) -> Figure:
    figure = schedule_figure(world.grid, found.fleet, title="Figure 9")
    add_caption(figure, caption, below=0.3)
    return figure
