"""What all figures share: how they are made without a display, laid out in inches, and written."""

from typing import Sequence, Tuple

from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from social_fleet.files import PathLike, atomic_write


def halo(width: float = 2.5) -> Sequence[patheffects.AbstractPathEffect]:
    """A white rim that keeps text readable on lines."""
    return [patheffects.withStroke(linewidth=width, foreground="white")]


def new_figure(width: float, height: float) -> Figure:
    """A figure [inch] that needs no display and leaves pyplot's state alone."""
    figure = Figure(figsize=(width, height), facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def add_axes(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes at a place of `figure` given in inches from its lower left corner."""
    across, up = figure.get_size_inches()
    return figure.add_axes([left / across, bottom / up, width / across, height / up])


def inches(axes: Axes) -> Tuple[float, float]:
    """Width and height of `axes` [inch]."""
    across, up = axes.figure.get_size_inches()
    place = axes.get_position()
    return float(place.width * across), float(place.height * up)


def save_figure(figure: Figure, path: PathLike, dpi: int = 130) -> None:
    """Write `figure` as PNG, whole or not at all.

    Raises
    ------
    InvalidInput
        When the file cannot be created.
    """
    with atomic_write(path, "wb") as stream:
        figure.savefig(stream, format="png", dpi=dpi, bbox_inches="tight", pad_inches=0.15)
