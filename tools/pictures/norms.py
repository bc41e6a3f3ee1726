"""What norms, zones, fading and standoff do to the same trips."""

from typing import Any, Callable, Dict, Mapping, Sequence

from social_fleet.files import PathLike
from social_fleet.mapping.drawing import draw
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.social_cost.zones import Zone
from social_fleet.scenario.pictures.norm_picture import Panel, norm_picture


def _world(*free: Mapping[str, Any], size: Sequence[float] = (24.0, 6.0)) -> OccupancyGrid:
    """Free shapes cut out of a solid block, at 0.1 m."""
    solid = {"fill": "wall", "x": [0.0, size[0]], "y": [0.0, size[1]]}
    return draw({"size": list(size), "resolution": 0.1, "shapes": [solid, *free]})


def _room(x: Sequence[float], y: Sequence[float]) -> Dict[str, Any]:
    return {"fill": "free", "x": list(x), "y": list(y)}


def _there_and_back(grid: OccupancyGrid, title: str, *, zones: Sequence[Zone] = (), height: float = 3.0,
                    **config: Any) -> Panel:
    """A trip along the map from and to places at y = `height` [m], and the one back."""
    planner = SocialPlanner(grid, PlannerConfig(**config), zones=zones)
    west, east = (1.5, height), (22.5, height)
    return Panel(title, grid, [planner.plan(west, east), planner.plan(east, west)], zones)


def norms(path: PathLike) -> None:
    """Keep right, keep left, none, and a norm of one's own, in a corridor of 4 m with a side corridor."""
    grid = _world(_room((0.5, 23.5), (1.0, 5.0)), _room((11.0, 13.0), (0.0, 1.0)))
    norm_picture([_there_and_back(grid, "side: right", height=1.7),
                  _there_and_back(grid, "side: left", side="left", height=1.7),
                  _there_and_back(grid, "side: none", side="none", height=1.7),
                  _there_and_back(grid, "norm: pictures.example_norm.KeepClear",
                                  norm="pictures.example_norm.KeepClear", height=1.7)], path, columns=2)


def zone(path: PathLike) -> None:
    """A hall in one part of which robots keep left."""
    grid = _world(_room((0.5, 23.5), (1.0, 5.0)))
    zones = [Zone("side: left", ((9.0, 0.8), (16.0, 0.8), (16.0, 5.2), (9.0, 5.2)), {"side": "left"})]
    norm_picture([_there_and_back(grid, "without zones"), _there_and_back(grid, "with a zone", zones=zones)], path)


def fading(path: PathLike) -> None:
    """A corridor of 3 m that narrows to 1 m, which is too little for two robots of 0.5 m."""
    grid = _world(_room((0.5, 9.0), (1.5, 4.5)), _room((9.0, 15.0), (2.5, 3.5)), _room((15.0, 23.5), (1.5, 4.5)))
    norm_picture([_there_and_back(grid, "single_lane_width and two_lane_width as they are"),
                  _there_and_back(grid, "no fading: both 0", single_lane_width=0.0, two_lane_width=0.0)], path)


def standoff(path: PathLike) -> None:
    """The lane's distance from its wall."""
    grid = _world(_room((0.5, 23.5), (1.0, 5.0)), _room((6.0, 6.9), (0.0, 1.0)), _room((15.0, 15.9), (5.0, 6.0)))
    norm_picture([_there_and_back(grid, "standoff: 0.35, the default for a radius of 0.25"),
                  _there_and_back(grid, "standoff: 1.0", standoff=1.0)], path)


PICTURES: Dict[str, Callable[[PathLike], None]] = {"norms": norms, "zone": zone, "fading": fading,
                                                   "standoff": standoff}
