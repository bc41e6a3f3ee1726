"""A map as pixels, and where a place of the map is on them: what animations are drawn on."""

from functools import lru_cache
from typing import Any, List, Sequence, Tuple

import numpy as np
from matplotlib import font_manager
from PIL import Image, ImageDraw, ImageFont

from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.pictures.colours import UNKNOWN
from social_fleet.scenario.pictures.map_layer import Box, cell_colours

COLOURS = 128  # of an animation


class Canvas:
    """The part of a map within a box, drawn with `longest` pixels along its longer side.

    Parameters
    ----------
    grid
        The map; its origin's yaw is undone, x points right and y up.
    box
        What to show [m].
    longest
        Pixels along the longer side of the box.
    """

    def __init__(self, grid: OccupancyGrid, box: Box, longest: int) -> None:
        self.box = box
        self.scale = longest / max(box[2] - box[0], box[3] - box[1])  # [pixel/m]
        self.width = max(int(round((box[2] - box[0]) * self.scale)), 1)
        self.height = max(int(round((box[3] - box[1]) * self.scale)), 1)
        self.image = self._render(grid)

    def pixel(self, x: float, y: float) -> Tuple[float, float]:
        """Pixel (right, down) of a place [m, map frame]."""
        return (x - self.box[0]) * self.scale, (self.box[3] - y) * self.scale

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """Pixels (N, 2) of places (N, 2) [m]."""
        return np.stack([(points[:, 0] - self.box[0]) * self.scale, (self.box[3] - points[:, 1]) * self.scale], axis=1)

    def _render(self, grid: OccupancyGrid) -> Image.Image:
        """Walls stay visible however small the picture: a pixel shows the darkest cell under it."""
        rows, columns = grid.shape
        detail = max(1, int(np.ceil(1.0 / (grid.resolution * self.scale))))
        across = (np.arange(self.width * detail) + 0.5) / (detail * self.scale) + self.box[0]
        down = self.box[3] - (np.arange(self.height * detail) + 0.5) / (detail * self.scale)
        xs, ys = np.meshgrid(across, down)
        local = grid.to_local(np.stack([xs.ravel(), ys.ravel()], axis=1)) / grid.resolution
        column, row = np.floor(local).astype(int).T
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        pixels = np.empty((len(row), 3), dtype=np.uint8)
        pixels[:] = UNKNOWN
        pixels[inside] = cell_colours(grid)[row[inside], column[inside]]
        blocks = pixels.reshape(self.height, detail, self.width, detail, 3)
        return Image.fromarray(np.ascontiguousarray(blocks.min(axis=(1, 3))), "RGB")


@lru_cache(maxsize=None)
def font(size: int, bold: bool = False) -> Any:
    """The typeface that matplotlib brings along, so that pictures look the same on every machine."""
    weight = "bold" if bold else "normal"
    name = font_manager.findfont(font_manager.FontProperties(family="DejaVu Sans", weight=weight))
    return ImageFont.truetype(name, size)


def write(draw: ImageDraw.ImageDraw, place: Tuple[float, float], text: str, typeface: Any, colour: Any, *,
          to_left: bool = False, rim: int = 0) -> None:
    """Write `text` to the right (or left) of `place`, centred on its height; a white `rim` [pixel] sets it off."""
    ascent, descent = typeface.getmetrics()
    left = place[0] - (text_width(text, typeface) if to_left else 0)
    draw.text((left, place[1] - 0.5 * (ascent + descent)), text, font=typeface, fill=colour, stroke_width=rim,
              stroke_fill="white")


def text_width(text: str, typeface: Any) -> int:
    """Width of `text` [pixel]."""
    return int(typeface.getmask(text).size[0])


def flatten(frames: Sequence[Image.Image]) -> List[Image.Image]:
    """`frames` with one palette for all, made from the first, a middle and the last.

    Colours are looked up at five bits a channel, which is much faster than a search for each pixel.
    """
    width, height = frames[0].size
    strip = Image.new("RGB", (3 * width, height))
    for place, frame in enumerate((frames[0], frames[len(frames) // 2], frames[-1])):
        strip.paste(frame, (place * width, 0))
    palette = strip.quantize(colors=COLOURS, method=Image.MEDIANCUT).getpalette()[:3 * COLOURS]
    palette += [0] * (3 * COLOURS - len(palette))
    nearest = _nearest(np.array(palette, dtype=np.int32).reshape(-1, 3))
    flat = []
    for frame in frames:
        levels = np.asarray(frame, dtype=np.uint16) >> 3
        image = Image.fromarray(nearest[(levels[..., 0] << 10) | (levels[..., 1] << 5) | levels[..., 2]], "P")
        image.putpalette(palette)
        flat.append(image)
    return flat


def _nearest(colours: np.ndarray) -> np.ndarray:
    """Index of the nearest of `colours` (C, 3) to each colour of five bits a channel, shape (32768,)."""
    steps = np.arange(32, dtype=np.int32) * 255 // 31
    red, green, blue = (axis.ravel() for axis in np.meshgrid(steps, steps, steps, indexing="ij"))
    distances = sum((channel[:, None] - colours[None, :, index]) ** 2
                    for index, channel in enumerate((red, green, blue)))
    return np.asarray(np.argmin(distances, axis=1), dtype=np.uint8)
