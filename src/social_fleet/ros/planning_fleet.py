"""What the planner node plans with: a planner per size of robot on one map, and one social graph for all of them."""

import logging
import threading
from dataclasses import dataclass, replace
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from social_fleet.errors import InvalidGraph, InvalidParameter, InvalidStart
from social_fleet.geometry import Polyline, Pose
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.parameters import from_mapping, parameter
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.overlays.discs import Disc
from social_fleet.planning.overlays.overlaid import near_overlays
from social_fleet.planning.overlays.overlay_set import OverlaySet
from social_fleet.planning.plan import Plan
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.routes.fleet_routes import FleetRoutes
from social_fleet.planning.routes.graph_changes import adapted
from social_fleet.planning.routes.social_graph import SocialGraph, learn
from social_fleet.planning.social_cost.zones import NO_ZONES, Zone, zones_of_map
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
    """Plans on one map for robots of any radius; learns from the paths that the fleet plans.

    `learn` and `prepare` may run in another thread than the rest; nothing that plans or counts waits for it.

    Parameters
    ----------
    grid
        The map.
    config
        Of robots with `config.robot_radius`; for others all but the radius holds.
    graph_file
        A social graph to begin with; empty for none. Of one of another map, what still holds is used, with a warning
        in the log; one that cannot be used is left aside with an error in the log.
    previous
        What planned on the map before: its graph goes before the file, and its obstacles stay, as far as they still
        hold.
    zones
        Parts of the map with norms of their own.
    """

    def __init__(self, grid: OccupancyGrid, config: PlannerConfig, graph_file: str = "",
                 previous: "Optional[PlanningFleet]" = None, *, zones: Sequence[Zone] = ()) -> None:
        self.grid = grid
        self.overlays = OverlaySet(grid)
        self._config = config
        self._zones = zones
        graph = None
        if previous is not None:
            self.overlays, lost = previous.overlays.moved_to(grid)
            if lost:
                log.warning("obstacles off the new map are forgotten: %s", ", ".join(lost))
        if previous is not None and previous.graph is not None:
            graph = self._brought_over(previous.graph, "the social graph of the map before")
        elif graph_file:
            graph = self._load(graph_file)
        planner = SocialPlanner(grid, config, graph=graph, zones=zones)
        self._routes = FleetRoutes(planner, self.overlays, graph=graph)
        self._learnt_from = 0
        self._lock = threading.Lock()  # of the planners by radius
        self._planners: Dict[float, SocialPlanner] = {config.robot_radius: planner}

    @property
    def graph(self) -> Optional[SocialGraph]:
        """The social graph in use."""
        return self._routes.graph

    @property
    def counted(self) -> int:
        """How many paths were counted, detours not among them."""
        return self._routes.counted

    def reconfigure(self, config: PlannerConfig) -> None:
        """Plan with other parameters from now on; the obstacles, the graph and what was counted for it stay."""
        planner = SocialPlanner(self.grid, config, graph=self.graph, zones=self._zones)
        with self._lock:
            self._config = config
            self._planners = {config.robot_radius: planner}
        self._routes.use(planner)
        if planner.graph is not self.graph:  # learnt meanwhile
            planner.graph = self.graph

    def prepare(self) -> None:
        """Make plans for robots of the configured radius fast; planning goes on meanwhile, as before."""
        self.planner(self._config.robot_radius).prepare()

    def plan(self, radius: float, start: Pose, goal: Pose, *, robot: str = "", avoid: Sequence[Disc] = (),
             tolerance: float = 0.0, start_tolerance: float = 0.0) -> Plan:
        """A plan round the obstacles that concern `robot`, whose radius is `radius` [m]; see `SocialPlanner.plan`.

        From a start where the robot does not fit, it leads straight to a place within `start_tolerance` [m] where it
        does; where there is none, InvalidStart.
        """
        planner, overlays = self.planner(radius), self.overlays.of(robot)
        try:
            return planner.plan(start, goal, avoid=avoid, overlays=overlays, tolerance=tolerance)
        except InvalidStart:
            place = planner.departure(start, start_tolerance, avoid=avoid, overlays=overlays)
            if place is None:
                raise
        return _led_from(start, planner.plan(place, goal, avoid=avoid, overlays=overlays, tolerance=tolerance))

    def count(self, plan: Plan) -> None:
        """Learn from a plan made here."""
        self._routes.add(plan)

    def count_path(self, points: np.ndarray, *, temporary: bool) -> None:
        """Learn from a path (N, 2) [m] that was planned elsewhere; raises InvalidPose off the map."""
        near = near_overlays(self.overlays.all, points, self._config.temporary_distance) if temporary else ()
        self._routes.add_path(self.cells_of(points), temporary=temporary, obstacles=near)

    def cells_of(self, points: np.ndarray) -> np.ndarray:
        """The chain of neighbouring cells (M, 2) under a path (N, 2) [m]; raises InvalidPose off the map."""
        self.grid.cells(points)  # a path that leaves the map may be too long to be gone along
        path = Polyline(points)
        steps = max(1, int(np.ceil(2.0 * path.length / self.grid.resolution)))
        cells = self.grid.cells(path.position(np.linspace(0.0, path.length, steps + 1)))
        return cells[np.append(True, np.diff(cells, axis=0).any(axis=1))]

    def has_to_learn(self, every: int) -> bool:
        """Whether `every` paths were counted since the last time, or an obstacle has proven to be permanent."""
        return self.counted - self._learnt_from >= every or bool(self._routes.due())

    def learn(self) -> None:
        """Extract the social graph from all paths counted so far; planners use it from now on."""
        self._learnt_from = self.counted
        for name in self._routes.learn():
            log.warning("the obstacle '%s' counts as permanent: the routes go round it now", name)
        self._use(self.counted)

    def learn_at_random(self, paths: int) -> None:
        """Learn the social graph from `paths` plans between random poses, always the same ones."""
        self._routes.take_over(learn(self.planner(self._config.robot_radius), paths=paths, seed=0))
        self._use(paths)

    def planner(self, radius: float) -> SocialPlanner:
        """The planner for robots of `radius` [m]."""
        with self._lock:
            if radius not in self._planners:
                config = replace(self._config, robot_radius=radius)
                self._planners[radius] = SocialPlanner(self.grid, config, graph=self.graph, zones=self._zones)
            return self._planners[radius]

    def _use(self, paths: int) -> None:
        """Hand the graph to all planners."""
        graph = self.graph
        assert graph is not None
        with self._lock:
            # Whoever is made after this begins with the new graph.
            planners = list(self._planners.values())
        for planner in planners:
            planner.graph = graph
        log.info("the social graph of %d paths has %d edges", paths, graph.edge_count)

    def _load(self, graph_file: str) -> Optional[SocialGraph]:
        try:
            graph = SocialGraph.load(resolve_path(graph_file))
        except InvalidGraph as error:
            log.error("the social graph is left aside: %s", error)
            return None
        if graph.digest == self.grid.digest:
            return graph
        return self._brought_over(graph, f"the social graph {graph_file}")

    def _brought_over(self, graph: SocialGraph, what: str) -> Optional[SocialGraph]:
        """What still holds of a graph of another map; None when nothing does."""
        try:
            result = adapted(graph, self.grid)
        except InvalidGraph as error:
            log.error("%s is left aside: it %s", what, error.message)
            return None
        log.warning("%s was learnt on another map: %d of its edges still hold on this one, %d are dropped", what,
                    result.kept, result.dropped)
        return result.graph if result.kept else None


def _led_from(start: Pose, plan: Plan) -> Plan:
    """The plan with the straight way from `start` to its beginning before it."""
    points = np.vstack([[start[:2]], plan.points])
    gap = float(np.hypot(*(points[1] - points[0])))
    note = f"the robot does not fit at its start; the path leads {gap:.2f} m straight to where it does"
    return replace(plan, points=points, length=plan.length + gap, cost=plan.cost + gap, start_yaw=start.yaw,
                   message="; ".join(text for text in (note, plan.message) if text))
