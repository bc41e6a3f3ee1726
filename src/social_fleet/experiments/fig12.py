"""Figure 12: time to find all encounter windows, by one robot and by the fleet in shares, against the fleet's size."""

from typing import Dict, List, Optional, Sequence

import numpy as np
from matplotlib.figure import Figure

from social_fleet.experiments.cells import Work
from social_fleet.experiments.charts import add_caption, add_title, plain_frame
from social_fleet.experiments.frame import Experiment, Result, Row, World
from social_fleet.experiments.sharing import REPEATS, fleet_cells, rows_of
from social_fleet.scenario.pictures.colours import INK, PALETTE
from social_fleet.scenario.pictures.style import add_axes, new_figure

SIZES = (2, 4, 8, 16, 32)
GROWN_FROM = 4  # smallest fleet that the growth is judged by: two robots have nothing to share
STYLES = {"central_time_median": ("one robot", "-", "o"), "shared_time_median": ("shared", "--", "s")}


class Figure12(Experiment):
    """Fleets of two to thirty-two robots."""

    name = "fig12"
    trials = 100
    maps = ("environment_2",)

    def _run(self, worlds: Sequence[World], trials: int, seed: int, work: Work) -> Result:
        values = work.values(fleet_cells([world.grid for world in worlds], SIZES, trials, seed))
        names = [world.name for world in worlds]
        rows = rows_of(names, SIZES, trials, values)
        growth = {name: {which: growth_of([row for row in rows if row["map"] == name], which) for which in STYLES}
                  for name in names}
        caption = (
            f"Medians of {trials} random fleets of each size; processor time, each the median of {REPEATS}. Shared: "
            "until the last robot has searched its pairs. They grow with the number of robots to the power of, from "
            f"{GROWN_FROM} robots on: "
            + "; ".join(f"{name.replace('_', ' ')} " + ", ".join(
                f"{STYLES[which][0]} {power:.1f}" for which, power in powers.items() if power is not None)
                for name, powers in growth.items())
            + ". The paper reports growth to the second power for one robot, and to the first when shared. Thin lines: "
              "the one robot's mean time per pair, times all pairs and times those of the busiest robot.")
        settings = {"maps": names, "trials": trials, "seed": seed, "repeats": REPEATS}
        return Result(self.name, caption, rows, settings, _draw(names, rows, caption), {"growth": growth})


def growth_of(rows: Sequence[Row], which: str) -> Optional[float]:
    """The power of the fleet's size that a time grows with, least squares over the logarithms."""
    grown = [row for row in rows if row["robots"] >= GROWN_FROM]
    if len(grown) < 2:
        return None
    sizes, times = np.log([[row["robots"], row[which]] for row in grown]).T
    return float(np.polyfit(sizes, times, 1)[0])


def _draw(names: Sequence[str], rows: Sequence[Row], caption: str) -> Figure:
    figure = new_figure(8.0, 4.8)
    axes = add_axes(figure, 0.75, 0.6, 6.9, 3.8)
    for name, colour in zip(names, PALETTE):
        own = [row for row in rows if row["map"] == name]
        sizes = [row["robots"] for row in own]
        for which, (label, style, marker) in STYLES.items():
            axes.plot(sizes, [1e3 * row[which] for row in own], color=colour, linestyle=style, marker=marker,
                      linewidth=1.8, label=label if len(names) == 1 else f"{name.replace('_', ' ')}, {label}")
        for line in _expected(own).values():
            axes.plot(sizes, line, color=INK, linewidth=0.7, alpha=0.5, zorder=1)
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    axes.set_xticks(SIZES)
    axes.set_xticklabels([str(size) for size in SIZES])
    axes.set_xlabel("robots", fontsize=9, color=INK)
    axes.set_ylabel("time until all windows are found [ms]", fontsize=9, color=INK)
    plain_frame(axes)
    axes.legend(frameon=False, fontsize=9)
    add_title(figure, "Figure 12: searching encounter windows alone and in shares")
    add_caption(figure, caption)
    return figure


def _expected(rows: Sequence[Row]) -> Dict[str, List[float]]:
    """Times [ms] if all pairs took equally long."""
    each = 1e3 * sum(row["central_time_median"] for row in rows) / sum(row["pairs"] for row in rows)
    return {key: [each * row[key] for row in rows] for key in ("pairs", "largest_share")}
