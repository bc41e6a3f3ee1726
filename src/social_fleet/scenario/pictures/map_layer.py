"""The map as the ground layer of a picture: its colours, the part worth showing, axes and a scale bar."""

import math
from typing import Optional, Tuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.transforms import Affine2D

from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.pictures.colours import FAINT, FREE, INK, UNKNOWN, WALL
from social_fleet.scenario.pictures.style import halo

Box = Tuple[float, float, float, float]  # x from, y from, x to, y to [m, map frame]


def cell_colours(grid: OccupancyGrid) -> np.ndarray:
    """(rows, cols, 3) uint8: walls dark, unknown light grey, free space white."""
    colours = np.empty(grid.values.shape + (3,), dtype=np.uint8)
    colours[:] = FREE
    colours[grid.blocked] = WALL
    colours[grid.values < 0] = UNKNOWN
    return colours


def content_box(grid: OccupancyGrid, points: Optional[np.ndarray] = None) -> Box:
    """The box [m] round all known cells and `points` (N, 2), with a small margin."""
    rows, columns = np.nonzero(grid.values >= 0)
    if len(rows) == 0:
        rows, columns = np.array([0, grid.values.shape[0] - 1]), np.array([0, grid.values.shape[1] - 1])
    low = np.array([columns.min(), rows.min()], dtype=float) * grid.resolution
    high = np.array([columns.max() + 1, rows.max() + 1], dtype=float) * grid.resolution
    corners = grid.from_local(np.array([low, (high[0], low[1]), high, (low[0], high[1])]))
    if points is not None and len(points):
        corners = np.vstack([corners, points])
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = 0.015 * float(max(high - low))
    return float(low[0] - margin), float(low[1] - margin), float(high[0] + margin), float(high[1] + margin)


def draw_map(axes: Axes, grid: OccupancyGrid, box: Optional[Box] = None) -> Box:
    """Draw the part of `grid` within `box`, by default all that is known, and return the box."""
    box = content_box(grid) if box is None else box
    rows, columns = grid.values.shape
    axes.set_facecolor(tuple(level / 255.0 for level in UNKNOWN))
    image = axes.imshow(cell_colours(grid), origin="lower", zorder=0,
                        extent=(0.0, columns * grid.resolution, 0.0, rows * grid.resolution))
    frame = Affine2D().rotate(grid.origin.yaw).translate(grid.origin.x, grid.origin.y)
    image.set_transform(frame + axes.transData)
    axes.set_xlim(box[0], box[2])
    axes.set_ylim(box[1], box[3])
    axes.set_aspect("equal")
    axes.tick_params(labelsize=8, color=FAINT, labelcolor=FAINT)
    axes.set_xlabel("x [m]", fontsize=8, color=FAINT, labelpad=1)
    axes.set_ylabel("y [m]", fontsize=8, color=FAINT, labelpad=1)
    for spine in axes.spines.values():
        spine.set_color("#C8C8C8")
    return box


def round_length(span: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above `span`."""
    power = 10.0 ** math.floor(math.log10(span))
    return max(factor * power for factor in (1.0, 2.0, 5.0) if factor * power <= span * 1.0001)


def draw_scale_bar(axes: Axes, box: Box, level: float) -> None:
    """A bar of a round length below the lower right corner, at `level` in shares of the axes' height."""
    length = round_length(0.2 * (box[2] - box[0]))
    under = axes.get_xaxis_transform()  # x in metres, y as a share of the axes
    right = box[2]
    axes.plot([right - length, right], [level, level], transform=under, color=INK, linewidth=2.5,
              solid_capstyle="butt", clip_on=False, zorder=20)
    axes.annotate(f"{length:g} m", (right - 0.5 * length, level), xycoords=under, xytext=(0, 3),
                  textcoords="offset points", ha="center", va="bottom", fontsize=8, color=INK, path_effects=halo(),
                  annotation_clip=False, zorder=20)
