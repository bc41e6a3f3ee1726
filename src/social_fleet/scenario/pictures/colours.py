"""The colours of robots, encounters and maps in every picture and in RViz, told apart by colour-blind readers too."""

from typing import Dict, Sequence, Tuple

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
