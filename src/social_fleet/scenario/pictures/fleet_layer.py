"""A fleet's paths on a map: starts, goals, names, directions, and where the robots meet."""

import math
from typing import List, Sequence, Tuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from social_fleet.coordination.schedule import EncounterWindow, FleetSchedule
from social_fleet.geometry import Polyline, Pose
from social_fleet.scenario.pictures.colours import FAINT, INK, KIND_COLOURS, KIND_LABELS
from social_fleet.scenario.pictures.map_layer import Box, draw_scale_bar
from social_fleet.scenario.pictures.style import halo, inches

MOST_NOTES = 10  # encounters that are written out; more would hide the map
ARROWS_ACROSS = 7  # arrows on a path as long as the picture is wide


def path_widths(number: int) -> np.ndarray:
    """Line widths [pt] such that of paths on top of each other every one shows."""
    if number <= 8:
        return np.linspace(min(1.8 + 0.8 * (number - 1), 4.2), 1.8, number)
    return np.full(number, 1.8)


def draw_path(axes: Axes, path: Polyline, colour: str, box: Box, *, width: float = 1.8, level: float = 5.0) -> None:
    """The line of a path with arrow heads along it."""
    axes.plot(path.points[:, 0], path.points[:, 1], color=colour, linewidth=width, solid_capstyle="round",
              solid_joinstyle="round", zorder=level)
    spacing = max(box[2] - box[0], box[3] - box[1]) / ARROWS_ACROSS
    number = max(1, int(path.length / spacing))
    for arc in (np.arange(number) + 0.6) * path.length / number:
        x, y = path.position(arc)
        turn = math.degrees(path.heading(float(arc))) - 90.0
        axes.plot([x], [y], marker=(3, 0, turn), markersize=8.5, color=colour, markeredgecolor="white",
                  markeredgewidth=0.9, zorder=level + 1.0)


def draw_ends(axes: Axes, start: Pose, goal: Pose, radius: float, colour: str, box: Box, name: str = "") -> None:
    """The start as a disc to scale with its heading, the goal as a ring, never smaller than one can see."""
    seen = max(radius, 0.009 * max(box[2] - box[0], box[3] - box[1]))
    axes.add_patch(Circle((start.x, start.y), seen, facecolor=colour, edgecolor="white", linewidth=1.0, zorder=9))
    axes.add_patch(Circle((goal.x, goal.y), seen, facecolor="white", edgecolor=colour, linewidth=2.0, zorder=9))
    axes.add_patch(Circle((goal.x, goal.y), 0.4 * seen, facecolor=colour, edgecolor="none", zorder=9))
    nose = start.x + 0.8 * seen * math.cos(start.yaw), start.y + 0.8 * seen * math.sin(start.yaw)
    axes.plot([start.x, nose[0]], [start.y, nose[1]], color="white", linewidth=1.3, zorder=10, solid_capstyle="round")
    if name:
        _name(axes, start, seen, name, colour, box)


def _name(axes: Axes, start: Pose, seen: float, name: str, colour: str, box: Box) -> None:
    """The robot's name beside its start, towards the middle of the map, in the first corner that is free."""
    inwards = -1.0 if start.x > 0.5 * (box[0] + box[2]) else 1.0
    span = max(box[2] - box[0], box[3] - box[1])
    taken = [text.get_position() for text in axes.texts]
    corners = [(inwards, 1.0), (inwards, -1.0), (-inwards, 1.0), (-inwards, -1.0)]
    for aside, up in corners:
        x, y = start.x + 1.3 * aside * seen, start.y + up * (0.9 * seen + 0.008 * span)
        if all(abs(x - other[0]) > 0.08 * span or abs(y - other[1]) > 0.018 * span for other in taken):
            break
    axes.text(x, y, name, color=colour, fontsize=9, fontweight="bold", ha="left" if aside > 0.0 else "right",
              va="center", zorder=12, path_effects=halo())


def draw_windows(axes: Axes, fleet: FleetSchedule) -> None:
    """A coloured band under both paths where two robots meet, one colour for each kind."""
    for window in sorted(fleet.windows, key=lambda window: -(window.r_exit - window.r_enter)):
        for piece in window_pieces(fleet, window):
            axes.plot(piece.points[:, 0], piece.points[:, 1], color=KIND_COLOURS[window.kind], linewidth=13.0,
                      alpha=0.55, solid_capstyle="round", solid_joinstyle="round", zorder=3)
    if len(fleet.windows) <= MOST_NOTES:
        _note_orders(axes, fleet)


def _note_orders(axes: Axes, fleet: FleetSchedule) -> None:
    """Who goes first, beside the middle of each window; notes at one place stand below each other."""
    taken: List[np.ndarray] = []
    across = axes.get_xlim()[1] - axes.get_xlim()[0]
    for window in fleet.windows:
        pieces = window_pieces(fleet, window)
        if window.first and pieces:
            second = window.robot_s if window.first == window.robot_r else window.robot_r
            place = pieces[0].position(0.5 * pieces[0].length)
            line = sum(abs(other[0] - place[0]) < 0.2 * across and abs(other[1] - place[1]) < 0.02 * across
                       for other in taken)
            taken.append(place)
            axes.annotate(f"{window.first} before {second}", place, xytext=(10, -10 * line - 10),
                          textcoords="offset points", fontsize=7.5, fontstyle="italic", color=INK, va="center",
                          zorder=11, path_effects=halo(2.0))


def window_pieces(fleet: FleetSchedule, window: EncounterWindow) -> List[Polyline]:
    """The stretches of both robots' paths in a window; only the planned robots' are known."""
    pieces = []
    for name, enter, leave in ((window.robot_r, window.r_enter, window.r_exit),
                               (window.robot_s, window.s_enter, window.s_exit)):
        if name in fleet.by_name:
            pieces.append(fleet[name].robot.path.slice(enter, leave))
    return pieces


def legend_entries(kinds: Sequence[str], extra: Sequence[Line2D] = ()) -> List[Line2D]:
    """What the marks mean, without the robots, whose names stand beside them."""
    entries = [Line2D([], [], marker="o", linestyle="", color=FAINT, markersize=8, markeredgecolor="white",
                      label="start"),
               Line2D([], [], marker="o", linestyle="", markerfacecolor="white", markeredgecolor=FAINT,
                      markeredgewidth=2.0, markersize=8, label="goal")]
    entries += [Line2D([], [], color=KIND_COLOURS[kind], linewidth=9, alpha=0.6, solid_capstyle="round",
                       label=KIND_LABELS[kind]) for kind in KIND_COLOURS if kind in kinds]
    return entries + list(extra)


def draw_footer(axes: Axes, box: Box, entries: Sequence[Line2D]) -> None:
    """Scale bar and legend below the map, wherever it stands on the sheet."""
    width, height = inches(axes)
    draw_scale_bar(axes, box, -0.36 / height)
    columns = max(1, min(len(entries), int((width + 0.3) / 1.75)))
    axes.legend(handles=list(entries), loc="upper left", bbox_to_anchor=(-0.05 / width, -0.44 / height), ncol=columns,
                frameon=False, fontsize=8, handlelength=1.6, columnspacing=1.6, borderaxespad=0.0)


def path_points(fleet: FleetSchedule) -> np.ndarray:
    """All vertices of all paths, shape (N, 2) [m]."""
    return np.vstack([schedule.robot.path.points for schedule in fleet.schedules])


def map_inches(box: Box, longest: float = 8.5) -> Tuple[float, float]:
    """Width and height [inch] of a map whose longer side is `longest`."""
    width, height = box[2] - box[0], box[3] - box[1]
    return longest * width / max(width, height), longest * height / max(width, height)
