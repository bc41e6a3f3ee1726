"""Panels of a figure that show a small fleet on a part of the map: its paths, where it meets, and where it is when."""

from typing import Optional, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from social_fleet.experiments.fleets import Outcome
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.pictures import fleet_layer
from social_fleet.scenario.pictures.colours import KIND_COLOURS, robot_colours
from social_fleet.scenario.pictures.map_layer import Box, draw_map
from social_fleet.scenario.pictures.style import halo

MARGIN = 1.0  # [m] round what is shown


def box_round(paths: Sequence[np.ndarray], margin: float = MARGIN) -> Box:
    """The box [m] round paths (N, 2)."""
    points = np.vstack(paths)
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def draw_meeting(axes: Axes, grid: OccupancyGrid, found: Outcome, box: Box, *, moment: Optional[float] = None) -> None:
    """Map, windows, paths and ends; at a `moment` [s] the robots themselves, to scale, instead of their starts."""
    draw_map(axes, grid, box)
    fleet = found.fleet
    for window in fleet.windows:
        for piece in fleet_layer.window_pieces(fleet, window):
            axes.plot(*piece.points.T, color=KIND_COLOURS[window.kind], linewidth=9.0, alpha=0.55, zorder=3,
                      solid_capstyle="round")
    colours = robot_colours([schedule.name for schedule in fleet.schedules])
    for schedule in fleet.schedules:
        robot, colour = schedule.robot, colours[schedule.name]
        fleet_layer.draw_path(axes, robot.path, colour, box, width=1.8)
        if moment is None:
            fleet_layer.draw_ends(axes, robot.start, robot.goal, robot.body_radius, colour, box, robot.name)
            # Once more on top, smaller: another robot's goal may lie there.
            axes.plot(robot.start.x, robot.start.y, marker="o", markersize=8, color=colour, zorder=11)
        else:
            _draw_robot(axes, schedule.position(moment), robot.body_radius, colour, robot.name)
    axes.set(xlabel="", ylabel="")


def _draw_robot(axes: Axes, place: np.ndarray, radius: float, colour: str, name: str) -> None:
    axes.add_patch(Circle((place[0], place[1]), radius, facecolor=colour, edgecolor="white", linewidth=1.0, zorder=9))
    axes.annotate(name, (place[0], place[1]), xytext=(9, 9), textcoords="offset points", fontsize=9,
                  fontweight="bold", color=colour, zorder=12, path_effects=halo(), clip_on=True)
