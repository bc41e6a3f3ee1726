"""Map files as ROS's map_server has them: a YAML file that describes an image.

The meaning of every key and pixel is map_server's, see http://wiki.ros.org/map_server#YAML_format.
"""

import math
import os
from typing import Any, Dict, List

import numpy as np

from social_fleet.errors import InvalidMap
from social_fleet.files import PathLike, atomic_write, check_writable, read_yaml
from social_fleet.geometry import Pose
from social_fleet.mapping.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from social_fleet.mapping.images import read_image, write_image

MODES = ("trinary", "scale", "raw")
_KEYS = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")


def load_map(path: PathLike) -> OccupancyGrid:
    """Read a map_server map: YAML, and the PGM, PNG or other image that it names.

    Parameters
    ----------
    path
        The YAML file. Its `image` is relative to it, or absolute.

    Returns
    -------
    OccupancyGrid
        In modes trinary and scale as map_server publishes it. In mode raw, pixels 101 to 254, which mean nothing in
        an occupancy grid, are occupied, as costmap_2d takes them.

    Raises
    ------
    InvalidMap
        `source` is the YAML file and `field` the key that is missing, wrong, or names a file that is no image.
    """
    source = os.fspath(path)
    document = read_yaml(path, InvalidMap)
    if not isinstance(document, dict):
        raise InvalidMap(f"is not a map file; it must hold the keys {', '.join(_KEYS)}", source=source)
    for key in _KEYS:
        if document.get(key) is None:
            raise InvalidMap(f"is missing; a map file needs {', '.join(_KEYS)}", source=source, field=key)
    try:
        mode = _mode(document)
        negate = _negate(document)
        occupied, free = _thresholds(document)
        origin = Pose(*_origin(document))
        resolution = _number(document["resolution"], "resolution")
        pixels = _pixels(document["image"], os.path.dirname(source))
        values = _raw(pixels, negate) if mode == "raw" else _interpreted(pixels, negate, occupied, free, mode)
        return OccupancyGrid(values[::-1], resolution, origin)
    except InvalidMap as error:
        raise InvalidMap(error.message, source=source, field=error.field) from error


def save_map(grid: OccupancyGrid, path: PathLike, *, image: str = "pgm") -> None:
    """Write `grid` as map_server's YAML file and, beside it, an image of the same name.

    Reading it back gives an equal grid: cells that are free, occupied or unknown are written as map_saver does, and
    a grid with other occupancies in mode raw. Each file appears whole or not at all, the image first.

    Parameters
    ----------
    grid
        The map.
    path
        The YAML file to write.
    image
        Format of the image: "pgm" or "png".

    Raises
    ------
    InvalidInput
        When a file cannot be created.
    """
    if image not in ("pgm", "png"):
        raise InvalidMap(f"must be 'pgm' or 'png', not {image!r}", source=os.fspath(path), field="image")
    check_writable(path)
    trinary = np.isin(grid.values, (UNKNOWN, FREE, OCCUPIED)).all()
    if trinary:
        pixels = np.select([grid.values == FREE, grid.values == OCCUPIED], [254, 0], 205)
    else:
        pixels = np.where(grid.values == UNKNOWN, 255, grid.values)
    stem = os.path.splitext(os.fspath(path))[0]
    write_image(f"{stem}.{image}", pixels.astype(np.uint8)[::-1])
    lines = [f"image: {os.path.basename(stem)}.{image}",
             f"resolution: {grid.resolution!r}",
             f"origin: [{', '.join(repr(part) for part in grid.origin)}]",
             "negate: 0", "occupied_thresh: 0.65", "free_thresh: 0.196"]
    with atomic_write(path) as stream:
        stream.write("\n".join(lines if trinary else lines + ["mode: raw"]) + "\n")


def _interpreted(pixels: np.ndarray, negate: bool, occupied: float, free: float, mode: str) -> np.ndarray:
    """Occupancies of modes trinary and scale, with map_server's arithmetic."""
    transparent = np.zeros(pixels.shape[:2], dtype=bool)
    if mode == "scale" and pixels.shape[2] == 4:
        transparent = pixels[..., 3] == 0
        pixels = pixels[..., :3]
    # in mode trinary alpha is averaged in with the colours, which map_server keeps for old maps' sake
    occupancy = (255.0 - _average(pixels, negate)) / 255.0
    values = np.full(occupancy.shape, UNKNOWN, dtype=np.int8)
    if mode == "scale":
        between = (occupancy >= free) & (occupancy <= occupied) & ~transparent
        values[between] = (1.0 + 98.0 * ((occupancy[between] - free) / max(occupied - free, 1e-9))).astype(np.int8)
    values[occupancy < free] = FREE
    values[occupancy > occupied] = OCCUPIED
    return values


def _raw(pixels: np.ndarray, negate: bool) -> np.ndarray:
    """Occupancies of mode raw: the pixel's value itself, of which 255 is -1 as a signed byte."""
    values = _average(pixels[..., :3], negate).astype(np.uint8)
    return np.where(values == 255, UNKNOWN, np.minimum(values, OCCUPIED)).astype(np.int8)


def _average(pixels: np.ndarray, negate: bool) -> np.ndarray:
    average = pixels.sum(axis=2, dtype=np.int64) / pixels.shape[2]
    return 255.0 - average if negate else average


def _pixels(name: Any, folder: str) -> np.ndarray:
    if not isinstance(name, str):
        raise InvalidMap(f"must be the name of an image file, not {name!r}", field="image")
    try:
        return read_image(os.path.join(folder, name))
    except InvalidMap as error:
        raise InvalidMap(f"{error.source} {error.message}", field="image") from error


def _number(value: Any, field: str) -> float:
    """A YAML number; PyYAML takes 5e-2 for text, which yaml-cpp does not."""
    try:
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise InvalidMap(f"must be a finite number, not {value!r}", field=field)
    return number


def _mode(document: Dict[str, Any]) -> str:
    mode = document.get("mode", MODES[0])
    if mode not in MODES:
        raise InvalidMap(f"must be one of {', '.join(MODES)}, not {mode!r}", field="mode")
    return mode


def _negate(document: Dict[str, Any]) -> bool:
    if document["negate"] not in (0, 1):
        raise InvalidMap(f"must be 0 or 1, not {document['negate']!r}", field="negate")
    return bool(document["negate"])


def _thresholds(document: Dict[str, Any]) -> List[float]:
    """Thresholds of occupied and free."""
    thresholds = []
    for key in ("occupied_thresh", "free_thresh"):
        thresholds.append(_number(document[key], key))
        if not 0.0 <= thresholds[-1] <= 1.0:
            raise InvalidMap(f"must be within 0 to 1, not {document[key]}", field=key)
    if thresholds[1] > thresholds[0]:
        raise InvalidMap(f"must not exceed occupied_thresh, {thresholds[0]:g}, but is {thresholds[1]:g}",
                         field="free_thresh")
    return thresholds


def _origin(document: Dict[str, Any]) -> List[float]:
    origin = document["origin"]
    if not isinstance(origin, list) or len(origin) != 3:
        raise InvalidMap(f"must be a list of x, y and yaw, not {origin!r}", field="origin")
    return [_number(part, "origin") for part in origin]
