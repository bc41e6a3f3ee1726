"""Figure 14: two robots head-on in a hallway, on A* paths and on social ones."""

import functools
from dataclasses import asdict
from typing import Any, Dict, List, NamedTuple, Sequence, Tuple

import numpy as np
from matplotlib.figure import Figure

from social_fleet.experiments.cells import Cell, Work
from social_fleet.experiments.charts import add_caption, add_title
from social_fleet.experiments.fleet_panels import box_round, draw_meeting
from social_fleet.experiments.fleets import Outcome, coordinated, random_specs, seed_of
from social_fleet.experiments.frame import Experiment, Result, Row, World
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.fleet import FleetPlanner
from social_fleet.scenario.pictures.colours import INK
from social_fleet.scenario.pictures.style import add_axes, new_figure
from social_fleet.scenario.scenario import RobotSpec

PLANNERS = {"shortest": "A*", "social": "social"}
WIDTH, BETWEEN = 9.5, 0.7  # of a hallway in the picture, and what is above it [inch]


class Case(NamedTuple):
    """Two robots that meet head-on, and what is special about it."""

    name: str
    specs: Sequence[RobotSpec]


HALLWAY = (
    Case("from room to room", (RobotSpec("blue", (10.0, 8.0), (38.0, 9.0)),
                               RobotSpec("gold", (36.0, 9.3), (14.5, 8.5)))),
    Case("changing places", (RobotSpec("blue", (11.0, 10.7), (34.0, 11.2)),
                             RobotSpec("gold", (34.0, 11.2), (11.0, 10.7)))))


class Figure14(Experiment):
    """Two hallway scenes as in the paper, and as many random pairs of robots that change places as there are trials."""

    name = "fig14"
    trials = 100
    maps = ("office_floor",)
    adds_maps = False

    def _run(self, worlds: Sequence[World], trials: int, seed: int, work: Work) -> Result:
        world = worlds[0]
        cases = cases_on(world, trials, seed)
        found = [{method: Outcome.from_value(value) for method, value in values.items()}
                 for values in work.values(cells_of(world.grid, cases))]
        own = len(cases) - trials
        rows = [row for case, each in zip(cases[:own], found) for row in rows_of(world, case.name, [each])]
        rows += rows_of(world, "random pairs", found[own:])
        caption = (
            "Two robots drive towards each other, from dot to ring, both leaving at once. Red and yellow: where one "
            "has to let the other pass. In the paper, A* makes one robot wait until the other has arrived (above) or "
            "leaves no schedule at all (below), and social paths let both drive on. " + _in_words(rows[-2:], trials))
        shown = list(zip(cases, found))[:own or len(HALLWAY)]
        details = {"scenes": [{"case": case.name, "method": method, **outcome.to_value()}
                              for case, each in shown for method, outcome in each.items()]}
        return Result(self.name, caption, rows, {"maps": [world.name], "trials": trials, "seed": seed},
                      _draw(world, shown, caption), details)


def cases_on(world: World, trials: int, seed: int) -> List[Case]:
    """The paper's scenes where they fit, and random pairs of robots that change places."""
    own = list(HALLWAY) if world.is_package(Figure14.maps[0]) else []
    pairs = []
    for trial in range(trials):
        blue, = random_specs(world.grid, ["blue"], seed_of(seed, trial))
        pairs.append(Case(f"random pair {trial + 1}", (blue, RobotSpec("gold", blue.goal, blue.start))))
    return own + pairs


def cells_of(grid: OccupancyGrid, cases: Sequence[Case]) -> List[Cell]:
    """A cell per case: both planners' paths, coordinated."""
    @functools.lru_cache(maxsize=None)
    def planners(method: str) -> FleetPlanner:
        return FleetPlanner(grid, planner=method)

    def compute(case: Case) -> Dict[str, Any]:
        return {method: coordinated([planners(method).plan(spec) for spec in case.specs]).to_value()
                for method in PLANNERS}

    return [Cell({"map": grid.digest, "robots": [asdict(spec) for spec in case.specs]},
                 functools.partial(compute, case)) for case in cases]


def rows_of(world: World, name: str, found: Sequence[Dict[str, Outcome]]) -> List[Row]:
    """A row per planner over some cases; delays and makespans over those in which both have a schedule."""
    rows = []
    both = [each for each in found if all(outcome.feasible for outcome in each.values())]
    for method in PLANNERS:
        own = [each[method] for each in found]
        delays = [sum(each[method].delays) for each in both]
        rows.append({"map": world.name, "case": name, "method": method, "pairs": len(own),
                     "without_schedule": sum(not each.feasible for each in own),
                     "unhindered": sum(each.unhindered for each in own),
                     "contested": float(np.mean([each.contested for each in own])),
                     "delay": float(np.mean(delays)) if both else None,
                     "makespan": float(np.mean([each[method].fleet.makespan for each in both])) if both else None})
    return rows


def _in_words(rows: Sequence[Row], trials: int) -> str:
    a_star, social = rows
    return (f"Of {trials} random pairs that change places, {a_star['without_schedule']} have no schedule on A* paths, "
            f"and {a_star['unhindered']} drive on as if alone; on social paths {social['without_schedule']} and "
            f"{social['unhindered']}.")


def _draw(world: World, shown: Sequence[Tuple[Case, Dict[str, Outcome]]], caption: str) -> Figure:
    boxes = [box_round([schedule.robot.path.points for outcome in each.values()
                        for schedule in outcome.fleet.schedules]) for _, each in shown]
    heights = [WIDTH * (box[3] - box[1]) / (box[2] - box[0]) for box in boxes]
    figure = new_figure(WIDTH + 0.9, sum(len(PLANNERS) * (height + BETWEEN) for height in heights) + 0.1)
    top = figure.get_figheight() - 0.1
    for letter, (case, each), box, height in zip("abcdefgh", shown, boxes, heights):
        for method, outcome in each.items():
            top -= height + BETWEEN
            axes = add_axes(figure, 0.6, top + 0.3, WIDTH, height)
            draw_meeting(axes, world.grid, outcome, box)
            axes.set_title(f"({letter}) {case.name}, {PLANNERS[method]}: {story(outcome)}", fontsize=10, color=INK,
                           loc="left")
    add_title(figure, f"Figure 14: head-on in a hallway of {world.name.replace('_', ' ')}")
    add_caption(figure, caption, below=0.2)
    return figure


def story(found: Outcome) -> str:
    """What happens, in a line."""
    if not found.feasible:
        return "no schedule, for each stands in the other's way"
    if found.unhindered:
        return f"nobody waits; both are there after {found.fleet.makespan:.0f} s"
    late = max(range(len(found.alone)), key=lambda index: found.delays[index])
    return (f"{found.fleet.schedules[late].name} loses {found.delays[late]:.0f} s; "
            f"both are there after {found.fleet.makespan:.0f} s")
