"""Figure 15: two and three robots at an intersection: one is inside at a time, the others wait outside."""

import functools
from dataclasses import asdict, replace
from typing import Any, Dict, List, Sequence, Tuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from social_fleet.experiments.cells import Cell, Work
from social_fleet.experiments.charts import add_caption, add_title
from social_fleet.experiments.fleet_panels import box_round, draw_meeting
from social_fleet.experiments.fleets import Outcome, coordinated, random_specs, seed_of, windows_of
from social_fleet.experiments.frame import Experiment, Result, Row, World
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.fleet import FleetPlanner
from social_fleet.scenario.pictures.colours import INK
from social_fleet.scenario.pictures.fleet_layer import window_pieces
from social_fleet.scenario.pictures.map_layer import Box
from social_fleet.scenario.pictures.space_time import draw_encounters, encounter_height
from social_fleet.scenario.pictures.style import add_axes, new_figure
from social_fleet.scenario.pictures.timeline import delays, occupancies
from social_fleet.scenario.scenario import RobotSpec

LATEST = 10.0  # [s] departures are drawn up to then
DRAWS = 50  # random fleets among which one is chosen that meets at one place
SURROUNDINGS = 2.0  # [m] round the windows, in the enlarged panels
PANEL, GAP, BARS = 2.8, 0.25, 3.4  # [inch]

TWO = (RobotSpec("blue", (2.7, 7.4), (14.5, 7.4)), RobotSpec("gold", (8.6, 1.5), (8.6, 14.5)))
THREE = (RobotSpec("blue", (2.7, 7.4), (14.5, 7.4)), RobotSpec("gold", (8.6, 1.5), (1.5, 8.6)),
         RobotSpec("green", (14.5, 8.6), (7.4, 1.5)))


class Figure15(Experiment):
    """Robots that come to a crossing at once; in the trials after the first they leave at random times."""

    name = "fig15"
    trials = 50
    maps = ("crossing",)
    adds_maps = False

    def _run(self, worlds: Sequence[World], trials: int, seed: int, work: Work) -> Result:
        world = worlds[0]
        cases = (TWO, THREE) if world.is_package(self.maps[0]) else fleets_that_meet(world.grid, seed)
        values = work.values([cell for specs in cases for cell in cells_of(world.grid, specs, trials, seed)])
        found = [[Outcome.from_value(value) for value in values[index * trials:(index + 1) * trials]]
                 for index in range(len(cases))]
        rows = [row_of(world, each) for each in found]
        longest = ", ".join(f"{row['together_max']:.1f} s with {row['robots']} robots" for row in rows
                            if row["together_max"] is not None)
        caption = (
            "Two and three robots that reach a crossing at the same time, on social paths. Left: all of it; beside "
            "that the crossing, enlarged, as one after the other passes; yellow and red: where two could touch. Bars: "
            "when each is there. In the paper, too, one passes at a time and the others wait outside. Here the second "
            "comes in once it cannot touch the first any more, which may be before that has left altogether; at most, "
            f"in {trials} trials with departures from 0 to {LATEST:g} s, {longest}.")
        details = {"schedules": [each[0].to_value()["fleet"] for each in found]}
        return Result(self.name, caption, rows, {"maps": [world.name], "trials": trials, "seed": seed},
                      _draw(world, [each[0] for each in found], caption), details)


def fleets_that_meet(grid: OccupancyGrid, seed: int) -> Tuple[Sequence[RobotSpec], Sequence[RobotSpec]]:
    """Of some random fleets of three the one in which most pairs get into each other's way; its first two, and all."""
    planners = FleetPlanner(grid)

    def meetings(specs: Sequence[RobotSpec]) -> int:
        windows = windows_of([planners.plan(spec) for spec in specs])
        return len({(window.robot_r, window.robot_s) for window in windows if window.kind == "intersection"})

    fleets = [random_specs(grid, [spec.name for spec in THREE], seed_of(seed, draw)) for draw in range(DRAWS)]
    best = max(fleets, key=meetings)
    return best[:2], best


def cells_of(grid: OccupancyGrid, specs: Sequence[RobotSpec], trials: int, seed: int) -> List[Cell]:
    """A cell per trial: the first with all leaving at once, the others at random times."""
    @functools.lru_cache(maxsize=None)
    def planners() -> FleetPlanner:
        return FleetPlanner(grid)

    def compute(trial: int) -> Dict[str, Any]:
        drawn = np.random.RandomState(seed_of(seed, trial)).uniform(0.0, LATEST, len(specs))
        departs = drawn if trial else np.zeros(len(specs))
        robots = [planners().plan(replace(spec, depart=float(depart))) for spec, depart in zip(specs, departs)]
        return coordinated(robots).to_value()

    key = {"map": grid.digest, "seed": seed, "robots": [asdict(spec) for spec in specs]}
    return [Cell({**key, "trial": trial}, functools.partial(compute, trial)) for trial in range(trials)]


def row_of(world: World, trials: Sequence[Outcome]) -> Row:
    """All trials of one fleet."""
    solved = [found for found in trials if found.feasible]
    late = [max(found.delays) for found in solved]
    clearances = [found.min_clearance for found in solved if found.min_clearance is not None]
    return {"map": world.name, "robots": len(trials[0].alone), "trials": len(trials),
            "without_schedule": len(trials) - len(solved), "together_max": max(map(together, solved), default=None),
            "longest_delay_mean": float(np.mean(late)) if late else None,
            "longest_delay_std": float(np.std(late)) if late else None,
            "min_clearance": min(clearances, default=None)}


def together(found: Outcome) -> float:
    """The longest that two robots are in one window that is no shared lane [s]."""
    return max((max(first.end - second.begin, 0.0) for kind, first, second in occupancies(found.fleet)
                if kind != "same_direction"), default=0.0)


def _draw(world: World, found: Sequence[Outcome], caption: str) -> Figure:
    figure = new_figure((1 + max(len(each.alone) for each in found)) * (PANEL + GAP) + BARS + 1.3,
                        len(found) * (PANEL + 0.8))
    for index, (letter, each) in enumerate(zip("ab", found)):
        bottom = figure.get_figheight() - (index + 1) * (PANEL + 0.8) + 0.35
        axes = add_axes(figure, 0.3, bottom, PANEL, PANEL)
        whole, close = _boxes(each)
        draw_meeting(axes, world.grid, each, whole)
        axes.add_patch(Rectangle(close[:2], close[2] - close[0], close[3] - close[1], fill=False, edgecolor=INK,
                                 linewidth=1.0, zorder=12))
        panels = [(axes, f"({letter}) {len(each.alone)} robots, before they start")]
        for moment, title in moments_of(each):
            axes = add_axes(figure, 0.3 + len(panels) * (PANEL + GAP), bottom, PANEL, PANEL)
            draw_meeting(axes, world.grid, each, close, moment=moment)
            panels.append((axes, title))
        for axes, title in panels:
            axes.set(xticks=[], yticks=[])
            axes.set_title(title, fontsize=9.5, color=INK, loc="left")
        height = encounter_height(each.fleet)
        if height:
            axes = add_axes(figure, 1.3 + len(panels) * (PANEL + GAP), bottom + PANEL - height, BARS, height)
            draw_encounters(axes, each.fleet, 1.01 * each.fleet.makespan)
            axes.set_title("When each robot is where it could meet another", fontsize=9.5, color=INK, loc="left")
    add_title(figure, "Figure 15: robots at an intersection, one at a time")
    add_caption(figure, caption)
    return figure


def _boxes(found: Outcome) -> Tuple[Box, Box]:
    """All of the paths, and the surroundings of where they meet, as squares [m]."""
    paths = [schedule.robot.path.points for schedule in found.fleet.schedules]
    pieces = [piece.points for window in found.fleet.windows if window.kind != "same_direction"
              for piece in window_pieces(found.fleet, window)]
    return _square(box_round(paths)), _square(box_round(pieces or paths, SURROUNDINGS))


def moments_of(found: Outcome) -> List[Tuple[float, str]]:
    """When each robot is amidst what it last shares with others, in order [s], and what happens then."""
    stays = {stay.robot: 0.5 * (stay.begin + stay.end) for _, stay in sorted(
        (stay.begin, stay) for _, *both in occupancies(found.fleet) for stay in both)}
    return [(time, f"{time:.0f} s: {name} passes{_waiting(found, name, time)}")
            for time, name in sorted((time, name) for name, time in stays.items())]


def _waiting(found: Outcome, passing: str, time: float) -> str:
    names = [schedule.name for schedule in found.fleet.schedules if schedule.name != passing
             and any(delay.times[0] <= time <= delay.times[-1] for delay in delays(found.fleet, schedule))]
    return f", {' and '.join(names)} wait{'s' * (len(names) == 1)}" if names else ""


def _square(box: Box) -> Box:
    """The smallest square round a box, about its middle [m]."""
    half = 0.5 * max(box[2] - box[0], box[3] - box[1])
    x, y = 0.5 * (box[0] + box[2]), 0.5 * (box[1] + box[3])
    return x - half, y - half, x + half, y + half
