"""Maps side by side in one figure."""

from typing import List, Tuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from social_fleet.experiments.charts import add_caption, add_title
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.mapping.walls import HEADINGS
from social_fleet.planning.routes.heatmaps import EdgeCounts
from social_fleet.scenario.pictures.fleet_layer import map_inches
from social_fleet.scenario.pictures.map_layer import content_box, draw_map
from social_fleet.scenario.pictures.style import add_axes, new_figure

BETWEEN = 0.7  # [inch]


def map_panels(grid: OccupancyGrid, count: int, *, title: str, caption: str,
               longest: float = 4.6) -> Tuple[Figure, List[Axes]]:
    """A figure with the same map `count` times, the longer side of each `longest` inches."""
    box = content_box(grid)
    width, height = map_inches(box, longest)
    figure = new_figure(count * (width + BETWEEN) + 0.1, height + 0.95)
    panels = [add_axes(figure, 0.6 + index * (width + BETWEEN), 0.5, width, height) for index in range(count)]
    for axes in panels:
        draw_map(axes, grid, box)
    add_title(figure, title)
    add_caption(figure, caption)
    return figure, panels


def draw_edges(axes: Axes, grid: OccupancyGrid, edges: EdgeCounts, colour: str, *, width: float = 1.2,
               level: float = 4.0) -> None:
    """Edges of a graph or heatmap as lines from cell to cell; one that more paths use is less transparent."""
    if not len(edges.edges):
        return
    heading, row, column = edges.places
    tails = np.stack([row, column], axis=1)
    ends = np.stack([grid.centres(tails), grid.centres(tails + HEADINGS[heading][:, ::-1])], axis=1)
    strength = np.clip(0.35 + 0.65 * edges.counts / max(float(np.percentile(edges.counts, 95)), 1.0), 0.0, 1.0)
    lines = LineCollection(ends, linewidths=width, colors=colour, alpha=strength, zorder=level)
    axes.add_collection(lines)
