"""The space-time diagram: how far each robot has come at each moment, where it waits and for whom."""

from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.files import PathLike
from social_fleet.scenario.pictures.colours import FAINT, INK, KIND_COLOURS, KIND_LABELS, robot_colours
from social_fleet.scenario.pictures.style import add_axes, halo, inches, new_figure, save_figure
from social_fleet.scenario.pictures.timeline import Delay, Progress, delays, driven_arcs, occupancies, when
from social_fleet.scenario.recording import Recording

MOST_ROWS = 24  # encounters drawn as rows; the tightest are chosen
MOST_WORDS = 10  # delays that are explained in words; the longest are chosen


def space_time_picture(fleet: FleetSchedule, path: PathLike, *, title: str = "",
                       recording: Optional[Recording] = None) -> None:
    """Write a PNG: above, distance over time for each robot; below, who is in which encounter when.

    Parameters
    ----------
    recording
        What was driven, drawn as dashed lines that show where it differs from the schedule.

    Raises
    ------
    InvalidInput
        When the file cannot be created.
    """
    figure = new_figure(10.5, sheet_height(fleet, 4.8))
    draw_sheet(figure, fleet, 1.5, 7.5, None if recording is None else driven_arcs(fleet, recording), title=title)
    save_figure(figure, path)


def sheet_height(fleet: FleetSchedule, progress: float) -> float:
    """Height [inch] of a figure with a progress diagram of height `progress`, the encounters, and what is between."""
    rows = encounter_height(fleet)
    return progress + 1.2 + (rows + 1.0 if rows else 0.0)


def draw_sheet(figure: Figure, fleet: FleetSchedule, left: float, width: float,
               driven: Optional[Dict[str, Progress]] = None, *, title: str = "", ceiling: float = 0.0) -> None:
    """Progress above, encounters below; `left`, `width` and `ceiling` (the figure's height when 0) in inches."""
    rows = encounter_height(fleet)
    floor = 0.65
    if rows:
        draw_encounters(add_axes(figure, left, floor, width, rows), fleet, horizon(fleet, driven))
        floor += rows + 1.0
    axes = add_axes(figure, left, floor, width, (ceiling or figure.get_figheight()) - floor - 0.55)
    draw_progress(axes, fleet, driven)
    axes.set_title(title or "How far each robot is at each moment", fontsize=12, color=INK, loc="left", pad=8)


def draw_progress(axes: Axes, fleet: FleetSchedule,
                  driven: Optional[Dict[str, Progress]] = None) -> None:
    """Arc length over time: a steep line is fast, a flat one waits; arrows lead to a wait from what ends it."""
    colours = robot_colours([schedule.name for schedule in fleet.schedules])
    held: List[Tuple[float, str, Delay]] = []
    for schedule in fleet.schedules:
        colour = colours[schedule.name]
        axes.plot(schedule.times, schedule.arc_lengths, color=colour, linewidth=2.2, zorder=5)
        axes.plot(schedule.times[-1], schedule.arc_lengths[-1], marker="o", color=colour, markersize=6, zorder=6)
        for delay in delays(fleet, schedule):
            held.append((delay.seconds, schedule.name, delay))
            axes.plot(delay.times, delay.arc_lengths, color=colour, linewidth=9, alpha=0.35, zorder=4,
                      solid_capstyle="butt")
    for _, _, delay in sorted(held, reverse=True, key=lambda item: item[:2])[:MOST_WORDS]:
        _explain(axes, fleet, delay, colours)
    for name, (times, arcs) in (driven or {}).items():
        axes.plot(times, arcs, color=colours[name], linewidth=1.5, linestyle=(0, (4, 2)), zorder=4)
    _dress(axes, fleet, horizon(fleet, driven))
    _label_ends(axes, fleet, colours)
    entries: List[Line2D] = []
    if held:
        entries.append(Line2D([], [], color=FAINT, linewidth=8, alpha=0.45, label="held up: waits, or drives slower"))
    if driven:
        entries.append(Line2D([], [], color=FAINT, linewidth=1.5, linestyle=(0, (4, 2)),
                              label="driven, where it differs"))
    if entries:
        axes.legend(handles=entries, loc="upper left", fontsize=8, frameon=False)


def _explain(axes: Axes, fleet: FleetSchedule, delay: Delay, colours: Dict[str, str]) -> None:
    """Words at a delay, and at a wait an arrow to its end from the moment at which the other robot has moved on."""
    text = f"waits {delay.seconds:.0f} s" if delay.standing else f"slowed by {delay.seconds:.0f} s"
    if delay.reason is not None:
        text += f" for {delay.reason.other}"
    if delay.reason is not None and delay.standing:
        moment = when(fleet[delay.reason.other], delay.reason.other_at)
        axes.annotate("", delay.end, (moment, delay.reason.other_at), zorder=6,
                      arrowprops={"arrowstyle": "-|>", "color": colours[delay.reason.other], "linewidth": 1.2,
                                  "linestyle": (0, (3, 2)), "shrinkA": 0, "shrinkB": 1})
    middle = 0.5 * (delay.times[0] + delay.times[-1])
    axes.annotate(text, (middle, np.interp(middle, delay.times, delay.arc_lengths)), xytext=(7, -7),
                  textcoords="offset points", ha="left", va="top", fontsize=8, color=INK, zorder=8, path_effects=halo())


def _label_ends(axes: Axes, fleet: FleetSchedule, colours: Dict[str, str]) -> None:
    """Names and arrival times in a column on the right, none on top of another, each with a thin line to its end."""
    latest, top = axes.get_xlim()[1], axes.get_ylim()[1]
    gap = min(0.042, 1.0 / max(len(fleet.schedules), 1)) * top
    level = -gap
    for schedule in sorted(fleet.schedules, key=lambda schedule: float(schedule.arc_lengths[-1])):
        end, colour = float(schedule.arc_lengths[-1]), colours[schedule.name]
        level = max(end, level + gap)
        axes.plot([schedule.times[-1], latest, 1.02 * latest], [end, end, level], color=colour, linewidth=0.7,
                  alpha=0.7, clip_on=False, zorder=3)
        axes.annotate(f"{schedule.name}: {schedule.arrival_time:.0f} s", (1.025 * latest, level), ha="left",
                      va="center", fontsize=8.5, fontweight="bold", color=colour, annotation_clip=False)


def horizon(fleet: FleetSchedule, driven: Optional[Dict[str, Progress]]) -> float:
    """Where the time axis ends [s]: when all have arrived, by schedule and in fact."""
    return 1.01 * max([fleet.makespan, *(float(times[-1]) for times, _ in (driven or {}).values())])


def _dress(axes: Axes, fleet: FleetSchedule, end: float) -> None:
    axes.set_xlim(0.0, end)
    axes.set_ylim(0.0, 1.08 * max(schedule.robot.path.length for schedule in fleet.schedules))
    axes.set_ylabel("driven along its own path [m]", fontsize=9, color=INK)
    axes.set_xlabel("time [s]", fontsize=9, color=INK, x=1.0, ha="right")
    _plain_spines(axes)
    axes.grid(color="#E8E8E8", linewidth=0.8, zorder=0)


def encounter_height(fleet: FleetSchedule) -> float:
    """Height that `draw_encounters` wants [inch]; 0 when nobody meets."""
    rows = min(len(occupancies(fleet)), MOST_ROWS)
    return 0.28 * rows + 0.3 if rows else 0.0


def draw_encounters(axes: Axes, fleet: FleetSchedule, end: float) -> None:
    """One row per encounter: a bar while either robot is in it; where only one may be, bars never overlap."""
    rows = _tightest(occupancies(fleet))
    colours = robot_colours([schedule.name for schedule in fleet.schedules])
    for row, (kind, first, second) in enumerate(rows):
        axes.axhspan(row - 0.46, row + 0.46, color=KIND_COLOURS[kind], alpha=0.28, linewidth=0, zorder=0)
        shared = kind == "same_direction"
        for index, stay in enumerate((first, second)):
            height, offset = (0.36, 0.2 - 0.4 * index) if shared else (0.62, 0.0)
            axes.barh(row - offset, max(stay.end - stay.begin, 0.004 * fleet.makespan), left=stay.begin, height=height,
                      color=colours[stay.robot], edgecolor="white", linewidth=0.6, zorder=3)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_xlim(0.0, end)
    axes.set_xlabel("time [s]", fontsize=9, color=INK, x=1.0, ha="right")
    axes.set_title("When each robot is to be where it could meet another", fontsize=11, color=INK, loc="left", pad=6)
    _plain_spines(axes)
    axes.set_yticks(range(len(rows)))
    axes.set_yticklabels([f"{first.robot}, then {second.robot}" for _, first, second in rows], fontsize=8, color=INK)
    axes.grid(axis="x", color="#FFFFFF", linewidth=0.8, zorder=1)
    present = [kind for kind in KIND_COLOURS if any(row[0] == kind for row in rows)]
    patches = [Patch(color=KIND_COLOURS[kind], alpha=0.4, linewidth=0, label=KIND_LABELS[kind]) for kind in present]
    axes.legend(handles=patches, loc="upper left", bbox_to_anchor=(-0.01, -0.28 / inches(axes)[1]), ncol=3,
                fontsize=8, frameon=False, borderaxespad=0.0)


def _tightest(rows: Sequence) -> List:  # type: ignore[type-arg]
    """Those encounters in which the second robot follows soonest, when there are too many for one picture."""
    chosen = sorted(rows, key=lambda row: row[2].begin - row[1].end)[:MOST_ROWS]
    return [row for row in rows if row in chosen]


def _plain_spines(axes: Axes) -> None:
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        axes.spines[side].set_color("#C8C8C8")
    axes.tick_params(labelsize=8, color=FAINT, labelcolor=FAINT)
