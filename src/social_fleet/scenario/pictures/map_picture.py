"""The picture of a coordinated fleet on its map, with what was driven when that is known."""

from typing import Optional

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.files import PathLike
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.pictures import fleet_layer
from social_fleet.scenario.pictures.colours import INK, robot_colours
from social_fleet.scenario.pictures.map_layer import Box, content_box, draw_map
from social_fleet.scenario.pictures.style import add_axes, new_figure, save_figure
from social_fleet.scenario.recording import Recording

DASHES = (0, (3, 4))  # what was driven lets the path's colour through


def map_picture(grid: OccupancyGrid, fleet: FleetSchedule, path: PathLike, *, title: str = "",
                recording: Optional[Recording] = None) -> None:
    """Write a PNG of the paths of `fleet`, coloured by robot, and of where robots meet, coloured by kind.

    Parameters
    ----------
    recording
        What was driven, drawn as a thin dashed line over each path.

    Raises
    ------
    InvalidInput
        When the file cannot be created.
    """
    box = content_box(grid, fleet_layer.path_points(fleet))
    width, height = fleet_layer.map_inches(box)
    figure = new_figure(width + 1.0, height + 1.6)
    axes = add_axes(figure, 0.7, 1.1, width, height)
    draw_fleet(axes, grid, fleet, box, recording=recording)
    axes.set_title(title or "Paths of the fleet and where robots meet", fontsize=12, color=INK, loc="left", pad=8)
    save_figure(figure, path)


def draw_fleet(axes: Axes, grid: OccupancyGrid, fleet: FleetSchedule, box: Box, *,
               recording: Optional[Recording] = None) -> None:
    """Map, encounters, paths, ends, names, legend and scale on `axes`."""
    draw_map(axes, grid, box)
    fleet_layer.draw_windows(axes, fleet)
    names = [schedule.name for schedule in fleet.schedules]
    colours = robot_colours(names)
    for schedule, width in zip(fleet.schedules, fleet_layer.path_widths(len(names))):
        robot, colour = schedule.robot, colours[schedule.name]
        fleet_layer.draw_path(axes, robot.path, colour, box, width=width)
        fleet_layer.draw_ends(axes, robot.start, robot.goal, robot.body_radius, colour, box, robot.name)
    extra = []
    if recording is not None:
        for index in range(len(recording.names)):
            axes.plot(recording.poses[:, index, 0], recording.poses[:, index, 1], color=INK, linewidth=0.6,
                      linestyle=DASHES, zorder=8)
        extra.append(Line2D([], [], color=INK, linewidth=0.7, linestyle=DASHES, label="driven"))
    fleet_layer.draw_footer(axes, box, fleet_layer.legend_entries([window.kind for window in fleet.windows], extra))
