"""Charts of experiments: bars in groups, and what stands below a picture."""

import textwrap
from typing import Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from social_fleet.scenario.pictures.colours import FAINT, INK
from social_fleet.scenario.pictures.style import add_axes, inches, new_figure

PANEL = 3.6  # least width of a panel [inch]
BAR = 0.28  # width of a bar that has room for its value [inch]
LETTERS_PER_INCH = 16.0  # of a caption


class Bars(NamedTuple):
    """A panel of bars: one value per (group, series), and the paper's where it has one."""

    label: str
    groups: Sequence[str]
    series: Sequence[str]
    values: Sequence[Optional[float]]
    paper: Sequence[Optional[float]]
    logarithmic: bool = False


def bar_chart(panels: Sequence[Bars], names: Mapping[str, str], colours: Mapping[str, str], *, title: str,
              caption: str) -> Figure:
    """Panels side by side; a bar's value stands above it.

    Parameters
    ----------
    panels : sequence of Bars
        All with the same groups and series.
    names, colours : mapping
        Of the series: what the legend calls it, and its colour.
    """
    groups = list(dict.fromkeys(panels[0].groups))
    width = max(PANEL, BAR * len(groups) * len(names))
    figure = new_figure(len(panels) * (width + 0.85) + 0.2, 4.6)
    for index, panel in enumerate(panels):
        axes = add_axes(figure, 0.75 + index * (width + 0.85), 0.6, width, 3.4)
        _draw_bars(axes, panel, groups, list(names), colours)
    handles: List[object] = [Patch(color=colours[name], label=label) for name, label in names.items()]
    if any(value is not None for panel in panels for value in panel.paper):
        handles.append(Line2D([], [], marker="D", linestyle="", markerfacecolor="white", markeredgecolor=INK,
                              markersize=6, label="the paper"))
    figure.legend(handles=handles, loc="upper right", ncol=len(handles), frameon=False, fontsize=9)
    add_title(figure, title)
    add_caption(figure, caption)
    return figure


def _draw_bars(axes: Axes, panel: Bars, groups: Sequence[str], series: Sequence[str],
               colours: Mapping[str, str]) -> None:
    bar = 0.8 / len(series)
    known: Dict[float, float] = {}
    for group, name, value, printed in zip(panel.groups, panel.series, panel.values, panel.paper):
        place = groups.index(group) + (series.index(name) - 0.5 * (len(series) - 1)) * bar
        if value is not None:
            axes.bar(place, value, 0.92 * bar, color=colours[name], zorder=2)
            label = f"{value:.3g}" if value >= 0.1 else f"{value:.2g}"
            axes.annotate(label, (place, value), xytext=(0, 2), textcoords="offset points", ha="center", va="bottom",
                          fontsize=6.0, color=INK, zorder=4)
        if printed is not None:
            known[place] = printed
    if known:
        axes.plot(list(known), list(known.values()), marker="D", linestyle="", markerfacecolor="white",
                  markeredgecolor=INK, markersize=5, zorder=3)
    if panel.logarithmic:
        axes.set_yscale("log")
    axes.set_xticks(np.arange(len(groups)))
    axes.set_xticklabels([group.replace("_", " ").replace("-", " ") for group in groups])
    axes.set_ylabel(panel.label, fontsize=8.5, color=INK)
    plain_frame(axes)


def plain_frame(axes: Axes) -> None:
    """Grey ticks and lines across, no box."""
    axes.tick_params(axis="y", labelsize=8, color=FAINT, labelcolor=FAINT)
    axes.tick_params(axis="x", labelsize=8, color=FAINT)
    axes.grid(axis="y", color="#E6E6E6", linewidth=0.8, zorder=0)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        axes.spines[side].set_color("#C8C8C8")


def add_title(figure: Figure, text: str) -> None:
    """A title above all panels, to the left."""
    figure.text(0.25 / figure.get_size_inches()[0], 1.0, text, fontsize=12, color=INK, va="bottom")


def label_ends(axes: Axes, ends: Sequence[Tuple[str, str, float, float]]) -> None:
    """Write at the ends of lines what they are, one above the other where they meet.

    Parameters
    ----------
    ends : sequence of (text, colour, x, y)
        The end of each line, in data coordinates; y linear.
    """
    gap = 0.2 / inches(axes)[1] * (axes.get_ylim()[1] - axes.get_ylim()[0])
    level = -np.inf
    for text, colour, x, y in sorted(ends, key=lambda end: end[3]):
        level = max(y, level + gap)
        axes.annotate(text, (x, level), xytext=(5, 0), textcoords="offset points", fontsize=9, fontweight="bold",
                      color=colour, va="center", annotation_clip=False)


def add_caption(figure: Figure, text: str, *, below: float = 0.0) -> None:
    """Sentences below all panels, in lines as long as the figure is wide; `below` [inch] its lower edge."""
    width, height = figure.get_size_inches()
    lines = textwrap.fill(text, max(int(LETTERS_PER_INCH * (width - 0.5)), 40))
    figure.text(0.25 / width, (0.05 - below) / height, lines, fontsize=8, color=INK, va="top", linespacing=1.35)
