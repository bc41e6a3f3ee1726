"""Fleet files: the robots of a fleet with all that starting them takes; config/fleet.yaml is their manual."""

import os
from dataclasses import dataclass
from typing import Any, Dict, Mapping, Tuple

from social_fleet.errors import InvalidParameter
from social_fleet.files import PathLike, read_yaml
from social_fleet.parameters import Parameters, from_mapping, parameter
from social_fleet.scenario.locations import resolve

LOCALIZATIONS = ("amcl", "external", "fake")
NAVIGATIONS = ("move_base", "navigator", "tracker", "none")


@dataclass(frozen=True)
class FleetRobot(Parameters):
    """One robot of a fleet file.

    Raises
    ------
    InvalidParameter
        When a value is of a wrong type or out of range; `field` names it.
    """

    start: Tuple[float, ...]  # x, y and yaw [m, m, rad, map frame]
    radius: float = parameter(0.25, above=0.0)  # [m]
    max_speed: float = parameter(0.7, above=0.0)  # [m/s]
    localization: str = parameter("amcl", choices=LOCALIZATIONS)
    navigation: str = parameter("navigator", choices=NAVIGATIONS)

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.start) not in (2, 3):
            raise InvalidParameter(f"must be x, y and yaw, not {list(self.start)}", field="start")
        object.__setattr__(self, "start", (*self.start, 0.0)[:3])


@dataclass(frozen=True)
class Fleet:
    """A fleet file's content: absolute paths, robots by name."""

    map: str
    graph: str
    robots: Mapping[str, FleetRobot]


@dataclass(frozen=True)
class _Head:
    map: str
    graph: str = ""


def load_fleet(path: PathLike) -> Fleet:
    """Read a fleet file.

    Raises
    ------
    InvalidParameter
        When the file is missing or no YAML, or a value is unknown, missing or wrong; by file and field.
    """
    source = os.fspath(path)
    content = read_yaml(source, InvalidParameter)
    if not isinstance(content, Mapping):
        raise InvalidParameter("must be a mapping with map and robots", source=source)
    others = {name: value for name, value in content.items() if name not in ("defaults", "robots")}
    if "map" not in others:
        raise InvalidParameter("is missing; name the map's YAML file", source=source, field="map")
    head = from_mapping(_Head, others, source=source)
    defaults = _mapping(content.get("defaults", {}), source, "defaults")
    robots: Dict[str, FleetRobot] = {}
    for name, values in _mapping(content.get("robots"), source, "robots").items():
        given = {**defaults, **_mapping(values, source, f"robots.{name}")}
        if "start" not in given:
            raise InvalidParameter("is missing; give x, y and yaw", source=source, field=f"robots.{name}.start")
        robots[str(name)] = from_mapping(FleetRobot, given, source=source, prefix=f"robots.{name}.")
    if not robots:
        raise InvalidParameter("must name at least one robot", source=source, field="robots")
    folder = os.path.dirname(os.path.abspath(source))
    return Fleet(resolve(head.map, folder), resolve(head.graph, folder) if head.graph else "", robots)


def _mapping(value: Any, source: str, field: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise InvalidParameter(f"must be a mapping, not {value!r}", source=source, field=field)
    return value
