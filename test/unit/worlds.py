"""Tiny worlds drawn as text, which a reader checks by hand."""

from typing import Sequence

import numpy as np

from social_fleet.geometry import Pose
from social_fleet.mapping.grid import OccupancyGrid

_VALUES = {"#": 100, ".": 0, "?": -1}


def grid_from_text(text: str, resolution: float = 1.0, origin: Sequence[float] = (0.0, 0.0, 0.0)) -> OccupancyGrid:
    """The map that `text` shows: ``#`` blocked, ``.`` free, ``?`` unknown, the top line the highest row.

    Blank lines and indentation are ignored; `resolution` [m] is a character's edge.
    """
    lines = [line.strip() for line in text.strip().splitlines() if line.strip()]
    rows = [[_VALUES[character] for character in line] for line in reversed(lines)]
    return OccupancyGrid(np.array(rows, dtype=np.int8), resolution, Pose(*origin))
