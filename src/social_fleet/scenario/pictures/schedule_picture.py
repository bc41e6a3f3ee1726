"""Everything about a schedule on one sheet: the map, and the space-time diagram beside or below it."""

from matplotlib.figure import Figure

from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.errors import InvalidInput
from social_fleet.files import PathLike
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.pictures.colours import INK
from social_fleet.scenario.pictures.fleet_layer import map_inches, path_points
from social_fleet.scenario.pictures.map_layer import content_box
from social_fleet.scenario.pictures.map_picture import draw_fleet
from social_fleet.scenario.pictures.space_time import draw_sheet, sheet_height
from social_fleet.scenario.pictures.style import add_axes, new_figure, save_figure

LONG = 2.2  # maps wider than this, in heights, stand above the diagram
HEADING = 0.6  # [inch]
FOOTER = 1.1  # [inch] for scale bar and legend


def schedule_picture(grid: OccupancyGrid, fleet: FleetSchedule, path: PathLike, *, title: str = "") -> None:
    """Write a PNG of `fleet` on its map with its space-time diagram.

    Raises
    ------
    InvalidInput
        When no robot has a schedule, or the file cannot be created.
    """
    if not fleet.schedules:
        raise InvalidInput("no robot has a schedule that could be drawn", source=str(path))
    save_figure(schedule_figure(grid, fleet, title=title), path, dpi=110)


def schedule_figure(grid: OccupancyGrid, fleet: FleetSchedule, *, title: str = "") -> Figure:
    """What `schedule_picture` writes."""
    box = content_box(grid, path_points(fleet))
    shape = (box[2] - box[0]) / (box[3] - box[1])
    if shape > LONG:
        map_width, map_height = map_inches(box, 9.5)
        diagram, width = sheet_height(fleet, 4.5), 8.0
        figure = new_figure(max(map_width, width + 2.6) + 1.0, diagram + map_height + FOOTER + HEADING)
        map_bottom, left = diagram + FOOTER, 1.5
    else:
        height = max(sheet_height(fleet, 4.8), 9.0 / max(shape, 1.0) + FOOTER)
        map_height = min(height - FOOTER, 11.0 / shape)
        map_width, diagram, width, left = map_height * shape, height, 7.0, map_height * shape + 2.3
        figure = new_figure(left + width + 1.5, height + HEADING)
        map_bottom = height - map_height
    axes = add_axes(figure, 0.7, map_bottom - 0.55, map_width, map_height)
    draw_fleet(axes, grid, fleet, box)
    axes.set_title("Paths, and where robots meet", fontsize=12, color=INK, loc="left", pad=8)
    draw_sheet(figure, fleet, left, width, ceiling=diagram)
    heading = f"{len(fleet.schedules)} robots, all there after {fleet.makespan:.0f} s"
    figure.text(0.25 / figure.get_figwidth(), 1.0 - 0.2 / figure.get_figheight(), f"{title}: {heading}" if title else
                heading, fontsize=14, color=INK, ha="left", va="top")
    return figure
