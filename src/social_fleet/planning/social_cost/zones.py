"""Zones: parts of a map where the social norm has other weights, another side, or is another one.

They stand in a YAML file beside the map (``hall.zones.yaml`` for ``hall.yaml``)::

    zones:
      - name: canteen
        polygon: [[12.0, 3.0], [20.0, 3.0], [20.0, 9.5], [12.0, 9.5]]   # corners in order [m, map frame]
        side: none

Whatever a zone does not name stays as the planner has it. A cell belongs to the zone that holds its centre; where zones
overlap, to the last of these in the file. `config/planner.yaml` explains the parameters.
"""

import os
from dataclasses import dataclass, field, replace
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from social_fleet.errors import InvalidParameter
from social_fleet.files import PathLike, read_yaml
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.mapping.polygons import Corner, checked_polygon, inside_polygon
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.social_cost.norms import Norm, norm_of

OVERRIDES = ("norm", "side", "w_right", "w_const", "w_buf", "standoff")
NO_ZONES = "none"


@dataclass(frozen=True)
class Zone:
    """A part of a map with parameters of its own.

    Parameters
    ----------
    name : str
        What messages call it.
    polygon : sequence of (x, y)
        Corners [m, map frame] in order along the outline, which must not cross itself.
    overrides : mapping
        Values of some of the parameters `OVERRIDES`.

    Raises
    ------
    InvalidParameter
        `field` names the part that is wrong.
    """

    name: str
    polygon: Tuple[Corner, ...]
    overrides: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise InvalidParameter(f"must be a text that is not empty, not {self.name!r}", field="name")
        object.__setattr__(self, "polygon", checked_polygon(self.polygon, InvalidParameter))
        for key in self.overrides:
            if key not in OVERRIDES:
                raise InvalidParameter(f"is nothing that a zone may change; that are {', '.join(OVERRIDES)}",
                                       field=str(key))
        values = PlannerConfig.from_mapping(self.overrides)
        object.__setattr__(self, "overrides", {key: getattr(values, key) for key in self.overrides})

    def config(self, config: PlannerConfig) -> PlannerConfig:
        """`config` as it is within the zone; a side goes before a norm of one's own that holds elsewhere."""
        changes = {"norm": None, **self.overrides} if "side" in self.overrides else self.overrides
        return replace(config, **changes)

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Which of the points (N, 2) [m, map frame] lie within."""
        return inside_polygon(self.polygon, points[:, 0], points[:, 1])


def load_zones(path: PathLike) -> List[Zone]:
    """The zones in a file.

    Raises
    ------
    InvalidParameter
        `source` is the file and `field` the place in it, such as ``zones[1].polygon``.
    """
    source = os.fspath(path)
    content = read_yaml(path, InvalidParameter)
    if not isinstance(content, dict) or not isinstance(content.get("zones"), list):
        raise InvalidParameter("must hold a list of zones", source=source, field="zones")
    for key in content:
        if key != "zones":
            raise InvalidParameter("there is no such key; the file holds zones alone", source=source, field=str(key))
    return [_read(entry, f"zones[{index}]", source) for index, entry in enumerate(content["zones"])]


def _read(entry: Any, where: str, source: str) -> Zone:
    if not isinstance(entry, dict):
        raise InvalidParameter(f"must be a zone with name and polygon, not {entry!r}", source=source, field=where)
    for key in ("name", "polygon"):
        if key not in entry:
            raise InvalidParameter("is missing", source=source, field=f"{where}.{key}")
    overrides = {str(key): value for key, value in entry.items() if key not in ("name", "polygon")}
    try:
        zone = Zone(entry["name"], entry["polygon"], overrides)
        norm_of(zone.config(PlannerConfig()))  # a class that cannot be had is better named with its file
        return zone
    except InvalidParameter as error:
        raise InvalidParameter(error.message, source=source, field=f"{where}.{error.field}") from error


def zones_of_map(map_path: PathLike, named: Optional[str] = None) -> List[Zone]:
    """The zones for a map: those in the file `named`, ``none`` for none, by default those in the file beside the map.

    Raises
    ------
    InvalidParameter
        As `load_zones`; a file that is named must exist.
    """
    if named == NO_ZONES:
        return []
    if named:
        return load_zones(named)
    beside = os.path.splitext(os.fspath(map_path))[0] + ".zones.yaml"
    return load_zones(beside) if os.path.exists(beside) else []


def zoned_norms(grid: OccupancyGrid, cells: np.ndarray, config: PlannerConfig,
                zones: Sequence[Zone]) -> List[Tuple[np.ndarray, Norm]]:
    """For every zone that holds some of the cells (N, 2) (row, column): which, as indices, and its norm.

    No cell is in two of them.

    Raises
    ------
    InvalidParameter
        When a zone's norm cannot be had; the message names the zone.
    """
    owner = np.full(len(cells), -1)
    centres = grid.centres(cells)
    for index, zone in enumerate(zones):
        owner[zone.holds(centres)] = index
    norms: Dict[int, Norm] = {}
    for index in np.unique(owner[owner >= 0]).tolist():
        try:
            norms[index] = norm_of(zones[index].config(config))
        except InvalidParameter as error:
            raise InvalidParameter(f"zone {zones[index].name}: {error.message}", field=error.field) from error
    return [(np.flatnonzero(owner == index), norm) for index, norm in norms.items()]
