"""Maps drawn from a readable description: rectangles, polygons and discs in metres, laid down in order.

A description is a YAML mapping:

``size``        [x, y] [m]
``resolution``  edge length of a cell [m]
``border``      thickness of the wall round the map [cells]; 0 if left out
``image``       ``pgm`` (if left out) or ``png``: the format in which the map is kept
``shapes``      list of shapes, each ``wall``, ``free`` or ``unknown`` and how it lies:
                ``{fill: free, x: [5, 45], y: [5, 45]}``, ``{fill: wall, polygon: [[0, 0], [1, 0], [0, 1]]}``,
                ``{fill: wall, centre: [3, 4], radius: 0.5}``, or ``{turn: 12, about: [10, 20], shapes: [...]}``,
                which turns several by so many degrees counter-clockwise
``slam``        the marks that a SLAM run leaves, see `slam_marks`

A shape fills the cells whose centres it holds. Ranges are half-open, so that shapes that meet neither overlap nor
leave a gap, also where an edge goes through the middle of cells.
"""

import math
import os
from typing import Any, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from social_fleet.errors import InvalidInput, InvalidMap
from social_fleet.files import PathLike, read_yaml
from social_fleet.mapping.files import save_map
from social_fleet.mapping.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from social_fleet.mapping.polygons import inside_polygon
from social_fleet.mapping.slam_marks import bent, leave_marks

FILLS = {"wall": OCCUPIED, "free": FREE, "unknown": UNKNOWN}
_KEYS = ("size", "resolution", "border", "image", "shapes", "slam")
_ROUNDING = 1e-9  # [m]; an edge through a cell's centre, as 5.5 m at 0.2 m, must not depend on rounding


def read_drawing(path: PathLike) -> Mapping[str, Any]:
    """The description in a YAML file.

    Raises
    ------
    InvalidMap
        `source` is the file and `field` the key that is missing, unknown or wrong.
    """
    description = read_yaml(path, InvalidMap)
    if not isinstance(description, dict):
        raise InvalidMap(f"must hold the keys {', '.join(_KEYS)}", source=os.fspath(path))
    for key in description:
        if key not in _KEYS:
            raise InvalidMap(f"there is no such key; known are {', '.join(_KEYS)}", source=os.fspath(path),
                             field=str(key))
    for key in ("size", "resolution", "shapes"):
        if key not in description:
            raise InvalidMap("is missing", source=os.fspath(path), field=key)
    return description


def draw(description: Mapping[str, Any]) -> OccupancyGrid:
    """The map that a description shows, with its lower left corner at (0, 0).

    Raises
    ------
    InvalidMap
        `field` is the part that makes no sense, such as ``shapes[3].x``.
    """
    resolution = _positive([description["resolution"]], 1, "resolution")[0]
    width, height = _positive(description["size"], 2, "size")
    border = description.get("border", 0)
    if not isinstance(border, int) or border < 0:
        raise InvalidMap(f"must be a number of cells, not {border!r}", field="border")
    values = np.full((round(height / resolution), round(width / resolution)), OCCUPIED, dtype=np.int8)
    values[border:values.shape[0] - border, border:values.shape[1] - border] = FREE
    places = (np.indices(values.shape)[::-1] + 0.5) * resolution
    slam = description.get("slam")
    _fill(values, places if slam is None else bent(places, slam), description["shapes"], "shapes")
    if slam is not None:
        values = leave_marks(values, resolution, slam)
    return OccupancyGrid(values, resolution)


def draw_file(path: PathLike, folder: PathLike) -> OccupancyGrid:
    """Draw the description at `path` and save the map under the same name in `folder`.

    Raises
    ------
    InvalidInput
        When the description makes no sense, or a file cannot be written.
    """
    description = read_drawing(path)
    try:
        grid = draw(description)
    except InvalidInput as error:
        raise InvalidMap(error.message, source=os.fspath(path), field=error.field) from error
    save_map(grid, os.path.join(folder, os.path.basename(path)), image=description.get("image", "pgm"))
    return grid


def _fill(values: np.ndarray, places: np.ndarray, shapes: Any, field: str) -> None:
    """Lay `shapes` down in order; `places` (2, rows, columns) are the cells' centres [m] in the shapes' frame."""
    if not isinstance(shapes, list):
        raise InvalidMap(f"must be a list of shapes, not {shapes!r}", field=field)
    for index, shape in enumerate(shapes):
        name = f"{field}[{index}]"
        if not isinstance(shape, dict):
            raise InvalidMap(f"must be a shape, not {shape!r}", field=name)
        if "shapes" in shape:
            _check_keys(shape, ("turn", "about", "shapes"), name)
            _fill(values, _turned_back(places, shape, name), shape["shapes"], f"{name}.shapes")
            continue
        if shape.get("fill") not in FILLS:
            raise InvalidMap(f"must be one of {', '.join(FILLS)}, not {shape.get('fill')!r}", field=f"{name}.fill")
        values[_inside(places, shape, name)] = FILLS[shape["fill"]]


def _inside(places: np.ndarray, shape: Mapping[str, Any], name: str) -> np.ndarray:
    """Which places a single shape holds."""
    x, y = places
    if "polygon" in shape:
        _check_keys(shape, ("fill", "polygon"), name)
        return inside_polygon(_corners(shape["polygon"], f"{name}.polygon"), x, y)
    if "radius" in shape:
        _check_keys(shape, ("fill", "centre", "radius"), name)
        centre = _numbers(shape["centre"], 2, f"{name}.centre")
        return np.hypot(x - centre[0], y - centre[1]) < _positive([shape["radius"]], 1, f"{name}.radius")[0]
    _check_keys(shape, ("fill", "x", "y"), name)
    return _within(x, _numbers(shape["x"], 2, f"{name}.x")) & _within(y, _numbers(shape["y"], 2, f"{name}.y"))


def _corners(value: Any, field: str) -> List[List[float]]:
    if not isinstance(value, list) or len(value) < 3:
        raise InvalidMap(f"must be a list of three corners or more, not {value!r}", field=field)
    return [_numbers(corner, 2, field) for corner in value]


def _within(values: np.ndarray, limits: Sequence[float]) -> np.ndarray:
    return (values >= limits[0] - _ROUNDING) & (values < limits[1] - _ROUNDING)


def _turned_back(places: np.ndarray, group: Mapping[str, Any], name: str) -> np.ndarray:
    """`places` seen from a frame that was turned."""
    angle = math.radians(_numbers([group.get("turn")], 1, f"{name}.turn")[0])
    x, y = _numbers(group.get("about"), 2, f"{name}.about")
    cos, sin = math.cos(angle), math.sin(angle)
    from_x, from_y = places[0] - x, places[1] - y
    return np.stack([x + cos * from_x + sin * from_y, y - sin * from_x + cos * from_y])


def _check_keys(shape: Mapping[str, Any], keys: Tuple[str, ...], name: str) -> None:
    for key in keys:
        if key not in shape:
            raise InvalidMap("is missing", field=f"{name}.{key}")
    for key in shape:
        if key not in keys:
            raise InvalidMap(f"does not belong there; wanted are {', '.join(keys)}", field=f"{name}.{key}")


def _positive(value: Any, count: int, field: str) -> List[float]:
    numbers = _numbers(value, count, field)
    if min(numbers) <= 0.0:
        raise InvalidMap(f"must be positive, not {min(numbers):g}", field=field)
    return numbers


def _numbers(value: Any, count: int, field: str) -> List[float]:
    """A list of `count` finite numbers."""
    numbers: Optional[List[float]] = None
    if isinstance(value, list) and len(value) == count:
        if all(isinstance(number, (int, float)) and math.isfinite(number) for number in value):
            numbers = [float(number) for number in value]
    if numbers is None:
        raise InvalidMap(f"must be {count} finite numbers, not {value!r}", field=field)
    return numbers
