"""The social planner: from two poses to the path that is driven between them."""

import math
import threading
import time
import zlib
from dataclasses import replace
from typing import NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from social_fleet.errors import InvalidGoal, InvalidParameter, NoPath
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.baselines.rrt_star import PATIENCE, rrt_star
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.driven_path.chords import Ground, Prices
from social_fleet.planning.driven_path.smoothing import rounded, smooth
from social_fleet.planning.ends import checked_position, joined, parsed_pose, reachable
from social_fleet.planning.lattice import Lattice, fitting_radius
from social_fleet.planning.overlays.discs import Disc, covered_nodes, local_discs
from social_fleet.planning.overlays.overlaid import Overlaid, OverlaidMaps, near_overlays
from social_fleet.planning.overlays.overlay_set import Overlays
from social_fleet.planning.plan import Plan
from social_fleet.planning.reach import check_tolerance, joined_clear, nearest_departure, nearest_reachable
from social_fleet.planning.routes.social_graph import SocialGraph
from social_fleet.planning.search import Search, SearchResult
from social_fleet.planning.social_cost.norms import Norm
from social_fleet.planning.social_cost.precomputation import social_costs
from social_fleet.planning.social_cost.zones import Zone

PLANNERS = ("social", "shortest", "rrt_star")
RRT_SAMPLES = 8000
RRT_STEP = 3.0  # [m]
PREPARED_FROM = 100  # plans from which on it pays to prepare a planner for them


class Surroundings(NamedTuple):
    """What one request meets: where the robot fits on the way, and the nodes that it must not enter."""

    ground: Ground
    closed: np.ndarray
    overlaid: Overlaid


class SocialPlanner:
    """Plans paths of one robot on one map. Safe to use from several threads.

    Parameters
    ----------
    grid : OccupancyGrid
        The map.
    config : PlannerConfig
        Parameters.
    graph : SocialGraph, optional
        Routes learnt on this map: edges of it cost their length only (Eq. 4). May be replaced at any time.
    norm : Norm, optional
        What to charge; by default what `config.norm` or `config.side` says.
    zones : sequence of Zone
        Parts of the map where the norm differs; the last of those that overlap holds.

    Attributes
    ----------
    space : ConfigurationSpace
        Where the robot fits.
    lattice : Lattice
        The graph that is searched.

    Raises
    ------
    InvalidGraph
        When the graph was learnt on another map.
    """

    def __init__(self, grid: OccupancyGrid, config: PlannerConfig = PlannerConfig(), *,
                 graph: Optional[SocialGraph] = None, norm: Optional[Norm] = None,
                 zones: Sequence[Zone] = ()) -> None:
        self.grid = grid
        self.config = config
        self.space = ConfigurationSpace(grid, config.robot_radius)
        self._way = ConfigurationSpace(grid, config.robot_radius + config.wall_margin)
        self.lattice = Lattice(self._way)
        social = social_costs(self.lattice, grid, config, norm, zones)
        self._search = Search(self.lattice, social, exemption_radius=config.exemption_radius,
                              epsilon=config.epsilon)
        self._overlaid = OverlaidMaps(self.space, self._way, self.lattice)
        self._lock = threading.Lock()
        self._change_lock = threading.Lock()
        self._prepared = False
        self._graph: Optional[SocialGraph] = None
        self._metric = self._search.metric()
        self.graph = graph

    @property
    def way(self) -> ConfigurationSpace:
        """Where the robot fits with its margin to walls."""
        return self._way

    @property
    def graph(self) -> Optional[SocialGraph]:
        """The social graph in use."""
        return self._graph

    @graph.setter
    def graph(self, graph: Optional[SocialGraph]) -> None:
        if graph is not None:
            graph.check_map(self.grid)
        with self._change_lock:
            self._use(graph)

    def prepare(self) -> None:
        """Spend a second or so to make all social plans from now on several times as fast.

        Setting a graph then takes such time, too. Other threads go on planning meanwhile, as before.
        """
        with self._change_lock:
            if not self._prepared:
                self._prepared = True
                self._use(self._graph)

    def _use(self, graph: Optional[SocialGraph]) -> None:
        """Work out what edges cost with a graph, then plan with that."""
        edges = None
        if graph is not None:
            edges = graph.edges[self.lattice.row, self.lattice.col] & self.lattice.edges
        metric = self._search.metric(edges, prepared=self._prepared)
        with self._lock:
            self._graph, self._metric = graph, metric

    def plan(self, start: Sequence[float], goal: Sequence[float], *, planner: str = "social",
             avoid: Sequence[Disc] = (), overlays: Overlays = (), tolerance: float = 0.0) -> Plan:
        """One path.

        Parameters
        ----------
        start, goal : (x, y) or (x, y, yaw)
            Poses [m, rad, map frame].
        planner : str
            ``social``, ``shortest`` (length only) or ``rrt_star``.
        avoid : sequence of Disc
            Where the path's centre line must not go.
        overlays : OverlaySet, mapping of names to shapes, or sequence of shapes
            Obstacles that the map does not hold; the robot's disc keeps clear of them.
        tolerance : float
            Where the goal is blocked or cut off, the path may end this far from it [m].

        Returns
        -------
        Plan
            Its costs are Eq. 2 along its cells, or Eq. 4 for ``social`` with a graph.

        Raises
        ------
        InvalidStart, InvalidGoal
            When the robot cannot stand there; the message says why and what would do.
        NoPath
            When nothing joins the two.
        InvalidOverlay
            When an obstacle lies off the map.
        InvalidParameter
            When there is no such planner, or the tolerance is no length.
        """
        if planner not in PLANNERS:
            raise InvalidParameter(f"must be one of {', '.join(PLANNERS)}, not {planner!r}", field="planner")
        check_tolerance(tolerance)
        around = self._surroundings(avoid, overlays)
        try:
            return self._plan(start, goal, planner, avoid, around)
        except (InvalidGoal, NoPath) as error:
            if tolerance == 0.0:
                raise
            place = self._beside(start, goal, around, tolerance)
            if place is None:
                raise _nowhere(error, tolerance) from error
            reason = f"blocked: {error.message.partition(';')[0]}" if isinstance(error, InvalidGoal) else "cut off"
        plan = self._plan(start, place, planner, avoid, around)
        shift = math.hypot(place[0] - goal[0], place[1] - goal[1])
        return replace(plan, goal_shift=shift, message=f"the goal is {reason}; the path ends {shift:.2f} m from it at "
                                                       f"({place[0]:.2f}, {place[1]:.2f})")

    def check_pose(self, pose: Sequence[float], what: str, *, overlays: Overlays = ()) -> None:
        """Refuse a ``start`` or ``goal`` (as `what` says) where the robot cannot stand, as `plan` does.

        Raises
        ------
        InvalidStart, InvalidGoal
            The message says why and what would do.
        """
        checked_position(self.space, pose, what, (), self._overlaid.of(overlays))

    def departure(self, start: Sequence[float], tolerance: float, *, avoid: Sequence[Disc] = (),
                  overlays: Overlays = ()) -> Optional[Tuple[float, float]]:
        """Where a path may begin for a robot that was pushed to where it does not fit.

        Parameters
        ----------
        start : (x, y) or (x, y, yaw)
            Where it stands [m, rad, map frame].
        tolerance : float
            How far from there the path may begin [m].
        avoid, overlays
            As for `plan`.

        Returns
        -------
        (x, y), optional
            The nearest such place that it gets to straight and through no wall; None: there is none, or the start lies
            in a wall or off the map.
        """
        check_tolerance(tolerance)
        place = np.array(parsed_pose(start, "start")[:2])
        if not self.grid.contains(*place):
            return None
        around = self._surroundings(avoid, overlays)
        cells = 1.0 / self.grid.resolution
        found = nearest_departure(self.lattice, around.overlaid.blocked, self.grid.to_local(place[None])[0] * cells,
                                  around.closed, tolerance * cells)
        if found is None:
            return None
        x, y = self.grid.from_local(found[None] * self.grid.resolution)[0]
        return float(x), float(y)

    def closed_cells(self, overlays: Overlays) -> np.ndarray:
        """Cells (M, 2) (row, column) that a path of this robot cannot use because of obstacles."""
        return self._overlaid.of(overlays).closed_cells

    def _plan(self, start: Sequence[float], goal: Sequence[float], planner: str, avoid: Sequence[Disc],
              around: Surroundings) -> Plan:
        """The path that ends exactly at the goal."""
        began = time.perf_counter()
        ends = (checked_position(self.space, start, "start", avoid, around.overlaid),
                checked_position(self.space, goal, "goal", avoid, around.overlaid))
        with self._lock:
            found = self._route(planner, ends, around)
            if found is None:
                raise self._no_path(start, goal, len(avoid) + len(around.overlaid.overlays), planner)
            vertices, result = found
            costs = self._search.evaluate(result, self._metric if planner == "social" else None)
        points = self.grid.from_local(vertices * self.grid.resolution)
        points[0], points[-1] = start[:2], goal[:2]
        near = near_overlays(around.overlaid.overlays, points, self.config.temporary_distance)
        return Plan(points=points, length=float(np.hypot(*np.diff(points, axis=0).T).sum()),
                    social_cost=float(costs[1].sum()), cost=float(costs.sum()), expanded=result.expanded,
                    search_time=time.perf_counter() - began, planner=planner, robot_radius=self.config.robot_radius,
                    cells=self.lattice.cells(result.nodes), start_yaw=_yaw(start), goal_yaw=_yaw(goal),
                    temporary=bool(near), obstacles=near)

    def _surroundings(self, avoid: Sequence[Disc], overlays: Overlays) -> Surroundings:
        overlaid = self._overlaid.of(overlays)
        discs = local_discs(self.grid, avoid)
        ground = Ground(overlaid.blocked, overlaid.clearance, self.grid.resolution, fitting_radius(self._way), discs)
        closed = covered_nodes(self.lattice.node, discs)
        if len(overlaid.closed):
            closed = np.union1d(closed, overlaid.closed)
        return Surroundings(ground, closed, overlaid)

    def _beside(self, start: Sequence[float], goal: Sequence[float], around: Surroundings,
                tolerance: float) -> Optional[Tuple[float, ...]]:
        """The pose [m, rad] within the tolerance [m] that is nearest to a goal which cannot be reached; None: none."""
        numbers = parsed_pose(goal, "goal")
        cells = 1.0 / self.grid.resolution
        ends = self.grid.to_local(np.array([start[:2], numbers[:2]], dtype=float)) * cells
        place = nearest_reachable(self.lattice, around.ground._replace(radius=fitting_radius(self.space)), ends[0],
                                  ends[1], around.closed, tolerance * cells)
        if place is None:
            return None
        x, y = self.grid.from_local(place[None] * self.grid.resolution)[0]
        return (float(x), float(y), *numbers[2:])

    def _route(self, planner: str, ends: Tuple[np.ndarray, np.ndarray],
               around: Surroundings) -> Optional[Tuple[np.ndarray, SearchResult]]:
        """The driven vertices in cells and the searched path; None: no path."""
        ground, closed = around.ground, around.closed
        at_ends = ground._replace(radius=fitting_radius(self.space))
        joins = joined(self.lattice, at_ends, ends, closed)
        if not joins:
            return None
        if planner == "rrt_star":
            return self._sampled(ground, ends, joins[0], closed)
        result = self._searched(planner, joins[0], closed)
        if result is None and len(closed):
            join = joined_clear(self.lattice, at_ends, ends, closed)
            result = None if join is None else self._searched(planner, join, closed)
        if result is None:
            return None
        return self._smoothed(ground, ends, result, social=planner == "social"), result

    def _searched(self, planner: str, join: Tuple[int, int], closed: np.ndarray) -> Optional[SearchResult]:
        if planner == "social":
            return self._search.cheapest(*join, self._metric, closed=closed)
        return self._search.shortest(*join, closed=closed)

    def _smoothed(self, ground: Ground, ends: Tuple[np.ndarray, np.ndarray], result: SearchResult, *,
                  social: bool) -> np.ndarray:
        """The driven path in cells along the grid's axes."""
        nodes = np.concatenate([result.nodes[:1], result.nodes, result.nodes[-1:]])
        points = np.vstack([ends[0], self.lattice.centres(result.nodes), ends[1]])
        parts = self._search.evaluate(result)
        steps = parts.sum(axis=0) if social else parts[0]
        joints = np.hypot(*(points[[0, -1]] - points[[1, -2]]).T) * self.grid.resolution
        paid = np.cumsum(np.concatenate([[0.0], joints[:1], steps, joints[1:]]))
        exempt = np.zeros(len(self.lattice), dtype=np.uint8)
        exempt[result.exempt] = 1
        prices = Prices(self.lattice.links, self._search.social, exempt)
        return smooth(points, nodes, paid, ground, prices, bound=self.config.smoothing_bound if social else -1.0,
                      corner_radius=self.config.corner_radius, least=self._least_radius())

    def _sampled(self, ground: Ground, ends: Tuple[np.ndarray, np.ndarray], joins: Tuple[int, int],
                 closed: np.ndarray) -> Optional[Tuple[np.ndarray, SearchResult]]:
        """The path of RRT*, and a path over the lattice beside it."""
        everywhere = self.lattice.centres(np.arange(len(self.lattice)))
        vertices = rrt_star(ground, everywhere, (ends[0][0], ends[0][1]), (ends[1][0], ends[1][1]),
                            samples=RRT_SAMPLES, step=RRT_STEP / self.grid.resolution, seed=_seed(ends))
        if vertices is None:
            return None
        between = [reachable(self.lattice, ground, vertex, closed)[:1] for vertex in vertices[1:-1]]
        stations = [joins[0]] + [node for nodes in between for node in nodes] + [joins[1]]
        pieces = [self._search.shortest(a, b, closed=closed) for a, b in zip(stations, stations[1:])]
        nodes = [joins[:1]] + [piece.nodes[1:] for piece in pieces if piece is not None]
        headings = np.concatenate([piece.headings for piece in pieces if piece is not None])
        result = SearchResult(np.concatenate(nodes), headings, float(self.lattice.lengths[headings].sum()), RRT_SAMPLES)
        points = rounded(ground, vertices, self.config.corner_radius, self._least_radius())
        return points, result

    def _least_radius(self) -> float:
        """What a smoothed path keeps from walls in tight spots [cells]: the radius and half of the margin."""
        return 0.5 * (fitting_radius(self.space) + fitting_radius(self._way))

    def _no_path(self, start: Sequence[float], goal: Sequence[float], obstacles: int, planner: str) -> NoPath:
        around = f" round {obstacles} obstacle{'s' * (obstacles > 1)}" if obstacles else ""
        reason = "every way is blocked or too narrow"
        if planner == "rrt_star":
            reason += f", or RRT* found none within {PATIENCE * RRT_SAMPLES} samples"
        return NoPath(f"no path for a robot of radius {self.config.robot_radius:g} m with a margin of "
                      f"{self.config.wall_margin:g} m to walls from "
                      f"({start[0]:.2f}, {start[1]:.2f}) to ({goal[0]:.2f}, {goal[1]:.2f}){around}: {reason}")


def _seed(ends: Sequence[np.ndarray]) -> int:
    """A seed of RRT* of its own for every pair of ends, so that the trees of several pairs have nothing in common."""
    return zlib.crc32(np.concatenate(ends).tobytes())


def _nowhere(error: Union[InvalidGoal, NoPath], tolerance: float) -> Union[InvalidGoal, NoPath]:
    """The error that a tolerance did not help with."""
    note = f"; nor can any place within {tolerance:g} m of the goal be reached"
    if isinstance(error, InvalidGoal):
        return InvalidGoal(error.message + note, field=error.field)
    return NoPath(str(error) + note)


def _yaw(pose: Sequence[float]) -> Optional[float]:
    return float(pose[2]) if len(pose) > 2 else None
