"""The social planner: from two poses to the path that is driven between them."""

import threading
import time
import zlib
from typing import Optional, Sequence, Tuple

import numpy as np

from social_fleet.errors import InvalidParameter, NoPath
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.baselines.rrt_star import PATIENCE, rrt_star
from social_fleet.planning.chords import Ground, Prices
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.costs import edge_costs
from social_fleet.planning.ends import checked_position, joined, reachable
from social_fleet.planning.lattice import Lattice, fitting_radius
from social_fleet.planning.norms import Norm, norm_of
from social_fleet.planning.overlay import Disc, covered_nodes, local_discs
from social_fleet.planning.plan import Plan
from social_fleet.planning.search import Search, SearchResult
from social_fleet.planning.smoothing import rounded, smooth
from social_fleet.planning.social_graph import SocialGraph

PLANNERS = ("social", "shortest", "rrt_star")
RRT_SAMPLES = 8000
RRT_STEP = 3.0  # [m]


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
        What to charge; by default what `config.side` says.

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
                 graph: Optional[SocialGraph] = None, norm: Optional[Norm] = None) -> None:
        self.grid = grid
        self.config = config
        self.space = ConfigurationSpace(grid, config.robot_radius)
        self._way = ConfigurationSpace(grid, config.robot_radius + config.wall_margin)
        self.lattice = Lattice(self._way)
        self._social = edge_costs(self.lattice, grid.blocked, norm or norm_of(config), stretch=config.wall_stretch)
        self._search = Search(self.lattice, self._social, exemption_radius=config.exemption_radius,
                              epsilon=config.epsilon)
        self._lock = threading.Lock()
        self._graph: Optional[SocialGraph] = None
        self._graph_edges: Optional[np.ndarray] = None
        self.graph = graph

    @property
    def graph(self) -> Optional[SocialGraph]:
        """The social graph in use."""
        return self._graph

    @graph.setter
    def graph(self, graph: Optional[SocialGraph]) -> None:
        edges = None
        if graph is not None:
            graph.check_map(self.grid)
            edges = graph.edges[self.lattice.row, self.lattice.col] & self.lattice.edges
        with self._lock:
            self._graph, self._graph_edges = graph, edges

    def plan(self, start: Sequence[float], goal: Sequence[float], *, planner: str = "social",
             avoid: Sequence[Disc] = ()) -> Plan:
        """One path.

        Parameters
        ----------
        start, goal : (x, y) or (x, y, yaw)
            Poses [m, rad, map frame].
        planner : str
            ``social``, ``shortest`` (length only) or ``rrt_star``.
        avoid : sequence of Disc
            Where the path's centre line must not go.

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
        InvalidParameter
            When there is no such planner.
        """
        if planner not in PLANNERS:
            raise InvalidParameter(f"must be one of {', '.join(PLANNERS)}, not {planner!r}", field="planner")
        began = time.perf_counter()
        ends = (checked_position(self.space, start, "start", avoid), checked_position(self.space, goal, "goal", avoid))
        discs = local_discs(self.grid, avoid)
        with self._lock:
            found = self._route(planner, ends, discs)
            if found is None:
                raise self._no_path(start, goal, avoid, planner)
            vertices, result, graph = found
            costs = self._search.evaluate(result.nodes, result.headings, graph)
        points = self.grid.from_local(vertices * self.grid.resolution)
        points[0], points[-1] = start[:2], goal[:2]
        return Plan(points=points, length=float(np.hypot(*np.diff(points, axis=0).T).sum()),
                    social_cost=float(costs[1].sum()), cost=float(costs.sum()), expanded=result.expanded,
                    search_time=time.perf_counter() - began, planner=planner, robot_radius=self.config.robot_radius,
                    cells=self.lattice.cells(result.nodes), start_yaw=_yaw(start), goal_yaw=_yaw(goal))

    def _route(self, planner: str, ends: Tuple[np.ndarray, np.ndarray],
               discs: np.ndarray) -> Optional[Tuple[np.ndarray, SearchResult, Optional[np.ndarray]]]:
        """The driven vertices in cells, the searched path, and the graph that it was searched with; None: no path."""
        ground = Ground(self.grid.blocked, self.space.clearance, self.grid.resolution, fitting_radius(self._way),
                        discs)
        closed = covered_nodes(self.lattice.node, discs)
        joins = joined(self.lattice, ground._replace(radius=fitting_radius(self.space)), ends, closed)
        if not joins:
            return None
        if planner == "rrt_star":
            return self._sampled(ground, ends, joins[0], closed)
        graph = self._graph_edges if planner == "social" else None
        if planner == "social":
            result = self._search.cheapest(*joins[0], graph=graph, closed=closed)
        else:
            result = self._search.shortest(*joins[0], closed=closed)
        if result is None:
            return None
        return self._smoothed(ground, ends, result, social=planner == "social"), result, graph

    def _smoothed(self, ground: Ground, ends: Tuple[np.ndarray, np.ndarray], result: SearchResult, *,
                  social: bool) -> np.ndarray:
        """The driven path in cells along the grid's axes."""
        nodes = np.concatenate([result.nodes[:1], result.nodes, result.nodes[-1:]])
        points = np.vstack([ends[0], self.lattice.centres(result.nodes), ends[1]])
        parts = self._search.evaluate(result.nodes, result.headings)
        steps = parts.sum(axis=0) if social else parts[0]
        joints = np.hypot(*(points[[0, -1]] - points[[1, -2]]).T) * self.grid.resolution
        paid = np.cumsum(np.concatenate([[0.0], joints[:1], steps, joints[1:]]))
        exempt = self.lattice.cells(result.nodes[[0, -1]])
        prices = Prices(self.lattice.links, self._social, exempt, self._search.exempt)
        return smooth(points, nodes, paid, ground, prices, bound=self.config.smoothing_bound if social else -1.0,
                      corner_radius=self.config.corner_radius, least=self._least_radius())

    def _sampled(self, ground: Ground, ends: Tuple[np.ndarray, np.ndarray], joins: Tuple[int, int],
                 closed: np.ndarray) -> Optional[Tuple[np.ndarray, SearchResult, None]]:
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
        return points, result, None

    def _least_radius(self) -> float:
        """What a smoothed path keeps from walls in tight spots [cells]: the radius and half of the margin."""
        return 0.5 * (fitting_radius(self.space) + fitting_radius(self._way))

    def _no_path(self, start: Sequence[float], goal: Sequence[float], avoid: Sequence[Disc], planner: str) -> NoPath:
        around = f" round {len(avoid)} obstacle{'s' * (len(avoid) > 1)}" if avoid else ""
        reason = "every way is blocked or too narrow"
        if planner == "rrt_star":
            reason += f", or RRT* found none within {PATIENCE * RRT_SAMPLES} samples"
        return NoPath(f"no path for a robot of radius {self.config.robot_radius:g} m with a margin of "
                      f"{self.config.wall_margin:g} m to walls from "
                      f"({start[0]:.2f}, {start[1]:.2f}) to ({goal[0]:.2f}, {goal[1]:.2f}){around}: {reason}")


def _seed(ends: Sequence[np.ndarray]) -> int:
    """A seed of RRT* of its own for every pair of ends, so that the trees of several pairs have nothing in common."""
    return zlib.crc32(np.concatenate(ends).tobytes())


def _yaw(pose: Sequence[float]) -> Optional[float]:
    return float(pose[2]) if len(pose) > 2 else None
