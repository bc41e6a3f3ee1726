"""What all pictures share: colours that colour-blind readers tell apart, fonts, and writing a figure."""

from typing import Dict, Sequence, Tuple

from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from social_fleet.files import PathLike, atomic_write

# Okabe and Ito's palette, then Tol's muted one.
PALETTE = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#D55E00", "#56B4E9", "#332288", "#999933",
           "#882255", "#44AA99", "#AA4499", "#117733", "#661100", "#88CCEE", "#6699CC", "#DDCC77")
NAMED = {"gold": "#E6A400", "yellow": "#E6C700", "orange": "#E69F00", "blue": "#0072B2", "sky": "#56B4E9",
         "green": "#009E73", "purple": "#8B3FA8", "violet": "#8B3FA8", "pink": "#CC79A7", "red": "#D0432B",
         "teal": "#44AA99", "brown": "#8C5A2B", "black": "#202020", "grey": "#7A7A7A"}
KIND_COLOURS = {"intersection": "#F2C230", "opposite_direction": "#E0503C", "same_direction": "#93A8BF"}
KIND_LABELS = {"intersection": "intersection: one at a time", "opposite_direction": "opposite: one at a time",
               "same_direction": "same direction: one behind the other"}

INK, FAINT = "#222222", "#8A8A8A"
WALL, UNKNOWN, FREE = (70, 72, 78), (222, 222, 226), (255, 255, 255)


def robot_colours(names: Sequence[str]) -> Dict[str, str]:
    """A colour for each robot: its own where it is named after one, else the palette's next free one."""
    colours = {name: NAMED[name.lower()] for name in names if name.lower() in NAMED}
    spare = [colour for colour in PALETTE if colour not in colours.values()] or list(PALETTE)
    others = [name for name in names if name not in colours]
    colours.update({name: spare[index % len(spare)] for index, name in enumerate(others)})
    return colours


def rgb(colour: str) -> Tuple[int, int, int]:
    """``#rrggbb`` as three bytes."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


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
