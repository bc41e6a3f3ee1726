"""What the planner node plans with: a planner per size of robot on one map, and one social graph for all of them."""

import logging
from dataclasses import dataclass, replace
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from social_fleet.errors import InvalidGoal, InvalidGraph, InvalidInput, InvalidParameter
from social_fleet.geometry import Polyline, Pose
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.parameters import from_mapping, parameter
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.heatmaps import Heatmaps
from social_fleet.planning.overlay import Disc
from social_fleet.planning.plan import Plan
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.social_graph import SocialGraph, learn
from social_fleet.planning.zones import NO_ZONES, Zone, zones_of_map
from social_fleet.ros.paths import resolve_path

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class RobotEntry:
    """What a planner knows of one robot beforehand."""

    radius: float = parameter(0.25, above=0.0)  # [m]
    max_speed: float = parameter(0.7, above=0.0)  # [m/s]


def read_config(given: Mapping[str, Any], scenario: str, prefix: str) -> Tuple[PlannerConfig, Dict[str, RobotEntry]]:
    """The planner's configuration and its robots from a node's parameters; those of a scenario file go before.

    Parameters
    ----------
    given
        Parameters of `PlannerConfig`, and `robots`.
    scenario
        A scenario file, or empty.
    prefix
        What stands before a parameter's name in messages.

    Raises
    ------
    InvalidInput
        By the full name of the parameter, or the scenario's file and field.
    """
    overrides = {name: value for name, value in given.items() if name != "robots"}
    listed = given.get("robots", {})
    if not isinstance(listed, Mapping):
        raise InvalidParameter(f"must be a mapping of robots' names to their values, not {listed!r}",
                               field=f"{prefix}robots")
    robots = {name: from_mapping(RobotEntry, values, prefix=f"{prefix}robots/{name}/")
              for name, values in listed.items()}
    if scenario:
        from social_fleet.scenario.files import load_scenario
        content = load_scenario(resolve_path(scenario))
        overrides.update(content.planner)
        robots.update((spec.name, RobotEntry(spec.radius, spec.max_speed)) for spec in content.robots)
    try:
        return PlannerConfig.from_mapping(overrides), robots
    except InvalidParameter as error:
        raise InvalidParameter(error.message, field=prefix + error.field) from error


def read_zones(zones_file: str, scenario: str) -> List[Zone]:
    """The zones that a node's parameters name: a file, ``none``, or by default those beside the scenario's map.

    Raises
    ------
    InvalidInput
        By the file and its field.
    """
    if zones_file:
        return zones_of_map("", zones_file if zones_file == NO_ZONES else resolve_path(zones_file))
    if scenario:
        from social_fleet.scenario.files import load_scenario
        return zones_of_map(load_scenario(resolve_path(scenario)).map_path)
    return []


class PlanningFleet:
    """Plans on one map for robots of any radius; counts the paths that the fleet plans.

    Parameters
    ----------
    grid
        The map.
    config
        Of robots with `config.robot_radius`; for others all but the radius holds.
    graph_file
        A social graph to begin with; empty for none. One of another map is left aside with an error in the log.
    zones
        Parts of the map with norms of their own.
    """

    def __init__(self, grid: OccupancyGrid, config: PlannerConfig, graph_file: str = "", *,
                 zones: Sequence[Zone] = ()) -> None:
        self.grid = grid
        self.graph: Optional[SocialGraph] = None
        self.counted = 0
        self._config = config
        self._zones = zones
        self._heatmaps = Heatmaps(grid.shape)
        self._planners: Dict[float, SocialPlanner] = {}
        if graph_file:
            try:
                self.graph = SocialGraph.load(resolve_path(graph_file), grid=grid)
            except InvalidGraph as error:
                log.error("the social graph is left aside: %s", error)
        self.planner(config.robot_radius)

    def plan(self, radius: float, start: Pose, goal: Pose, *, avoid: Sequence[Disc] = (),
             tolerance: float = 0.0) -> Plan:
        """A plan whose end may be up to `tolerance` [m] from a `goal` that is blocked; raises as the planner does."""
        if not (np.isfinite(tolerance) and tolerance >= 0.0):
            raise InvalidInput(f"must be zero or more metres, not {tolerance}", field="tolerance")
        planner = self.planner(radius)
        try:
            return planner.plan(start, goal, avoid=avoid)
        except InvalidGoal:
            if tolerance == 0.0:
                raise
            near = self._nearest_free(planner, goal, tolerance)
            if near is None:
                raise
        return planner.plan(start, near, avoid=avoid)

    def count(self, cells: np.ndarray) -> None:
        """Add a path's cells (M, 2) to the heatmaps."""
        self._heatmaps.add(cells)
        self.counted += 1

    def cells_of(self, points: np.ndarray) -> np.ndarray:
        """The chain of neighbouring cells (M, 2) under a path (N, 2) [m]; raises InvalidPose off the map."""
        path = Polyline(points)
        steps = max(1, int(np.ceil(2.0 * path.length / self.grid.resolution)))
        cells = self.grid.cells(path.position(np.linspace(0.0, path.length, steps + 1)))
        return cells[np.append(True, np.diff(cells, axis=0).any(axis=1))]

    def learn(self) -> None:
        """Extract the social graph from all paths counted so far; planners use it from now on."""
        self._use(SocialGraph.extract(self._heatmaps, self._config.heatmap_threshold, self._config.min_component,
                                      grid=self.grid), self.counted)

    def learn_at_random(self, paths: int) -> None:
        """Learn the social graph from `paths` plans between random poses, always the same ones."""
        self._use(learn(self.planner(self._config.robot_radius), paths=paths, seed=0), paths)

    def _use(self, graph: SocialGraph, paths: int) -> None:
        self.graph = graph
        for planner in self._planners.values():
            planner.graph = graph
        log.info("the social graph of %d paths has %d edges", paths, graph.edge_count)

    def planner(self, radius: float) -> SocialPlanner:
        if radius not in self._planners:
            config = replace(self._config, robot_radius=radius)
            self._planners[radius] = SocialPlanner(self.grid, config, graph=self.graph, zones=self._zones)
        return self._planners[radius]

    def _nearest_free(self, planner: SocialPlanner, goal: Pose, tolerance: float) -> Optional[Pose]:
        """The free cell's centre nearest to `goal` and within `tolerance` of it, with the goal's heading."""
        cells = np.argwhere(planner.space.free)
        centres = self.grid.centres(cells)
        distances = np.hypot(centres[:, 0] - goal.x, centres[:, 1] - goal.y)
        nearest = int(np.argmin(distances)) if len(cells) else 0
        if not len(cells) or not distances[nearest] <= tolerance:
            return None
        return Pose(float(centres[nearest, 0]), float(centres[nearest, 1]), goal.yaw)
