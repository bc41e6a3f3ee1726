"""The picture of single plans on a map."""

from typing import List, Optional, Sequence, Tuple

import numpy as np

from social_fleet.files import PathLike
from social_fleet.geometry import Pose
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.plan import Plan
from social_fleet.scenario.pictures import fleet_layer
from social_fleet.scenario.pictures.colours import INK, PALETTE
from social_fleet.scenario.pictures.map_layer import content_box, draw_map
from social_fleet.scenario.pictures.style import add_axes, new_figure, save_figure

Task = Tuple[Sequence[float], Sequence[float], Optional[Plan]]  # start, goal, and the plan where there is one
MOST_ENDS = 12  # tasks whose ends are drawn


def plan_picture(grid: OccupancyGrid, tasks: Sequence[Task], path: PathLike, *, robot_radius: float) -> None:
    """Write a PNG of plans; of many, only the lines.

    Raises
    ------
    InvalidInput
        When the file cannot be created.
    """
    plans = [plan for _, _, plan in tasks if plan is not None]
    ends = [pose[:2] for start, goal, _ in tasks for pose in (start, goal)]
    box = content_box(grid, np.vstack([ends, *(plan.points for plan in plans)]))
    width, height = fleet_layer.map_inches(box)
    figure = new_figure(width + 1.0, height + 1.6)
    axes = add_axes(figure, 0.7, 1.1, width, height)
    draw_map(axes, grid, box)
    for index, (start, goal, plan) in enumerate(tasks):
        colour = PALETTE[index % len(PALETTE)]
        if plan is not None and len(tasks) <= MOST_ENDS:
            fleet_layer.draw_path(axes, plan.path, colour, box, width=2.2)
        elif plan is not None:
            axes.plot(plan.points[:, 0], plan.points[:, 1], color=colour, linewidth=0.9, alpha=0.6, zorder=5)
        if len(tasks) <= MOST_ENDS:
            fleet_layer.draw_ends(axes, _pose(start, plan, 0.0), _pose(goal, plan, 1.0), robot_radius, colour, box)
    axes.set_title(_title(tasks, plans), fontsize=12, color=INK, loc="left", pad=8)
    fleet_layer.draw_footer(axes, box, fleet_layer.legend_entries([]) if len(tasks) <= MOST_ENDS else [])
    save_figure(figure, path)


def _pose(given: Sequence[float], plan: Optional[Plan], share: float) -> Pose:
    """The pose with its heading, or the path's where any will do."""
    if len(given) > 2:
        return Pose(*given)
    return Pose(given[0], given[1], 0.0 if plan is None else plan.path.heading(share * plan.length))


def _title(tasks: Sequence[Task], plans: List[Plan]) -> str:
    if not plans:
        return "no path" if len(tasks) == 1 else f"no path for any of {len(tasks)} pairs"
    name = plans[0].planner.replace("_star", "*").replace("rrt", "RRT")
    if len(tasks) == 1:
        return f"{name} path, {plans[0].length:.1f} m"
    return f"{len(plans)} {name} paths, {np.mean([plan.length for plan in plans]):.1f} m on average"
