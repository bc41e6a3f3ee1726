"""Files that list obstacles for a plan: the shapes of a scenario's obstacles, and more of them, without times."""

import os
from typing import Dict

from social_fleet.errors import InvalidOverlay, InvalidScenario
from social_fleet.files import PathLike, read_yaml
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.overlays.raster import rasterised
from social_fleet.planning.overlays.shapes import DiscObstacle, Polygon, Rectangle, Shape
from social_fleet.scenario.fields import Fields, describe

SHAPES = ("circle", "rectangle", "polygon")
_KEYS = {"x": "center[0]", "y": "center[1]", "width": "size[0]", "height": "size[1]"}  # in the file, by field


def load_obstacles(path: PathLike, grid: OccupancyGrid) -> Dict[str, Shape]:
    """The obstacles in a YAML file, by name: a list with an entry for each, in metres and radians of the map frame.

    ``{shape: circle, center: [x, y], radius: r}``, ``{shape: rectangle, center: [x, y], size: [along x, along y],
    yaw: 0.0}``, or ``{shape: polygon, points: [[x, y], …]}``, each with a ``name`` if one is wanted.

    Raises
    ------
    InvalidScenario
        When the file is missing or not YAML, or an entry is wrong or off the map; `field` is such as ``[2].radius``.
    """
    source = os.fspath(path)
    content = read_yaml(source, InvalidScenario)
    if not isinstance(content, list):
        raise InvalidScenario(f"must be a list of obstacles, not {describe(content)}", source=source)
    obstacles: Dict[str, Shape] = {}
    for number, value in enumerate(content):
        fields = Fields(value, source, f"[{number}]")
        name = fields.text("name", f"obstacle {number + 1}")
        if name in obstacles:
            raise fields.wrong("name", f"there is another obstacle called {name}; names must differ")
        try:
            obstacles[name] = _shape(fields)
            rasterised(grid, obstacles[name])
        except InvalidOverlay as error:
            raise fields.wrong(_key(error.field), error.message) from error
    return obstacles


def _shape(fields: Fields) -> Shape:
    kind = fields.choice("shape", SHAPES, "circle")
    shape: Shape
    if kind == "polygon":
        points = fields.take("points")
        fields.finish()
        return Polygon(points)
    x, y = fields.numbers("center", ("x", "y"))
    if kind == "rectangle":
        width, height = fields.numbers("size", ("along x", "along y"))
        shape = Rectangle(x, y, width, height, fields.number("yaw", 0.0))
    else:
        shape = DiscObstacle(x, y, fields.number("radius", above=0.0))
    fields.finish()
    return shape


def _key(field: str) -> str:
    return _KEYS.get(field, field.replace("vertices", "points"))
