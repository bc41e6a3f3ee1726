"""Pictures of what a norm does: the same trips under several configurations, one panel each."""

from typing import NamedTuple, Sequence, Tuple

import numpy as np

from social_fleet.files import PathLike
from social_fleet.geometry import Pose
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.plan import Plan
from social_fleet.planning.social_cost.zones import Zone
from social_fleet.scenario.pictures import fleet_layer
from social_fleet.scenario.pictures.colours import INK, PALETTE
from social_fleet.scenario.pictures.map_layer import content_box, draw_map
from social_fleet.scenario.pictures.style import add_axes, halo, new_figure, save_figure

ZONE = "#E8B400"
LONGEST = 7.0  # [inches] of a panel's longer side


class Panel(NamedTuple):
    """One map with plans on it, and the zones that they were made with."""

    title: str
    grid: OccupancyGrid
    plans: Sequence[Plan]
    zones: Sequence[Zone] = ()


def norm_picture(panels: Sequence[Panel], path: PathLike, *, columns: int = 1) -> None:
    """Write a PNG of panels side by side; a plan has the same colour in all of them.

    Raises
    ------
    InvalidInput
        When the file cannot be created.
    """
    boxes = [content_box(panel.grid) for panel in panels]
    sizes = [fleet_layer.map_inches(box, LONGEST / columns) for box in boxes]
    width, height = (max(size[axis] for size in sizes) for axis in (0, 1))
    rows = -(-len(panels) // columns)
    figure = new_figure(columns * (width + 0.7) + 0.2, rows * (height + 0.8) + 0.1)
    for index, (panel, box) in enumerate(zip(panels, boxes)):
        left = 0.6 + (index % columns) * (width + 0.7)
        bottom = 0.45 + (rows - 1 - index // columns) * (height + 0.8)
        axes = add_axes(figure, left, bottom, *sizes[index])
        draw_map(axes, panel.grid, box)
        for zone in panel.zones:
            corners = np.array(zone.polygon)
            axes.fill(corners[:, 0], corners[:, 1], facecolor=ZONE, alpha=0.25, edgecolor=ZONE, zorder=1)
            axes.text(*corners.mean(axis=0), zone.name, fontsize=8, color=INK, ha="center", va="center", zorder=8,
                      path_effects=halo())
        for colour, plan in zip(PALETTE, panel.plans):
            fleet_layer.draw_path(axes, plan.path, colour, box, width=2.0)
            fleet_layer.draw_ends(axes, *_ends(plan), plan.robot_radius, colour, box)
        axes.set_title(panel.title, fontsize=10, color=INK, loc="left", pad=5)
    save_figure(figure, path, dpi=110)


def _ends(plan: Plan) -> Tuple[Pose, Pose]:
    """Start and goal with the path's headings."""
    first, last = plan.points[0], plan.points[-1]
    return (Pose(first[0], first[1], plan.path.heading(0.0)),
            Pose(last[0], last[1], plan.path.heading(plan.length)))
