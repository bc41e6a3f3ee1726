"""The social planner: validates poses, searches, smooths, and returns a plan."""

import threading
import time
from typing import Optional, Sequence, Tuple

import numpy as np

from social_fleet.errors import InvalidGoal, InvalidParameter, InvalidStart, NoPath
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.chords import Ground, Prices, is_free
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.costs import edge_costs
from social_fleet.planning.lattice import Lattice, fitting_radius
from social_fleet.planning.norms import Norm, norm_of
from social_fleet.planning.overlay import Disc, covered_nodes, local_discs
from social_fleet.planning.plan import Plan
from social_fleet.planning.search import Search, SearchResult
from social_fleet.planning.smoothing import smooth
from social_fleet.planning.social_graph import SocialGraph

PLANNERS = ("social", "shortest", "rrt_star")
JOIN_REACH = 3  # [cells] how far from a pose its path may join the lattice


class SocialPlanner:
    """Plans paths of one robot on one map.

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
        self.lattice = Lattice(self.space)
        social = edge_costs(self.lattice, grid.blocked, norm or norm_of(config), stretch=config.wall_stretch)
        self._search = Search(self.lattice, social, exemption_radius=config.exemption_radius,
                              epsilon=config.epsilon)
        self._social = social
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
        ends = (self._checked(start, "start", avoid), self._checked(goal, "goal", avoid))
        with self._lock:
            discs = local_discs(self.grid, avoid)
            closed = covered_nodes(self.lattice.node, discs)
            joins = self._joined(ends, discs, closed, (start, goal))
            result = self._searched(joins, planner, closed)
            if result is None:
                raise self._no_path(start, goal, avoid)
            points = self._smoothed(ends, result, planner, discs)
            graph = self._graph_edges if planner == "social" else None
            length, social = self._search.evaluate(result.nodes, result.headings, graph).sum(axis=1)
        points = self.grid.from_local(points * self.grid.resolution)
        points[0], points[-1] = start[:2], goal[:2]
        return Plan(points=points, length=float(np.hypot(*np.diff(points, axis=0).T).sum()), social_cost=float(social),
                    cost=float(length + social), expanded=result.expanded, search_time=time.perf_counter() - began,
                    planner=planner, robot_radius=self.config.robot_radius, cells=self.lattice.cells(result.nodes),
                    start_yaw=float(start[2]) if len(start) > 2 else None,
                    goal_yaw=float(goal[2]) if len(goal) > 2 else None)

    def _checked(self, pose: Sequence[float], what: str, avoid: Sequence[Disc]) -> np.ndarray:
        """The pose's position in cells along the grid's axes."""
        error = InvalidStart if what == "start" else InvalidGoal
        if len(pose) not in (2, 3):
            raise error(f"must be (x, y) or (x, y, yaw), not {len(pose)} numbers", field=what)
        if not np.isfinite(np.asarray(pose, dtype=float)).all():
            raise error(f"must be finite, not {tuple(pose)}", field=what)
        self.space.check_pose(float(pose[0]), float(pose[1]), what)
        for disc in avoid:
            if disc.holds(pose[0], pose[1]):
                raise error(f"({pose[0]:.2f}, {pose[1]:.2f}) lies within {disc.radius:.2f} m of "
                            f"({disc.x:.2f}, {disc.y:.2f}), which the path must avoid", field=what)
        return self.grid.to_local([pose[:2]])[0] / self.grid.resolution

    def _ground(self, discs: np.ndarray) -> Ground:
        return Ground(self.grid.blocked, self.space.clearance, self.grid.resolution, fitting_radius(self.space), discs)

    def _joined(self, ends: Tuple[np.ndarray, np.ndarray], discs: np.ndarray, closed: np.ndarray,
                poses: Sequence[Sequence[float]]) -> Tuple[int, int]:
        """Nodes where the path leaves the start and reaches the goal: the nearest pair in one component."""
        ground = self._ground(discs)
        near = [self._reachable(end, ground, closed) for end in ends]
        component = self.lattice.component
        for start in near[0]:
            for goal in near[1]:
                if component[start] == component[goal]:
                    return int(start), int(goal)
        raise self._no_path(poses[0], poses[1], ())

    def _reachable(self, point: np.ndarray, ground: Ground, closed: np.ndarray) -> np.ndarray:
        """Nodes that the robot reaches from `point` in a straight line, nearest first; the own cell's alone if it is."""
        node = self.lattice.node
        row, col = int(np.floor(point[1] + 1e-9)), int(np.floor(point[0] + 1e-9))
        offsets = np.arange(-JOIN_REACH, JOIN_REACH + 1)
        rows, cols = (axis.ravel() for axis in np.meshgrid(row + offsets, col + offsets, indexing="ij"))
        inside = (rows >= 0) & (rows < node.shape[0]) & (cols >= 0) & (cols < node.shape[1])
        rows, cols = rows[inside], cols[inside]
        distances = np.hypot(cols + 0.5 - point[0], rows + 0.5 - point[1])
        found = []
        for index in np.argsort(distances, kind="stable"):
            candidate = node[rows[index], cols[index]]
            if candidate < 0 or candidate in closed:
                continue
            if is_free(ground, point[0], point[1], cols[index] + 0.5, rows[index] + 0.5):
                found.append(candidate)
                if rows[index] == row and cols[index] == col:
                    break
        return np.array(found, dtype=np.int64)

    def _searched(self, joins: Tuple[int, int], planner: str, closed: np.ndarray) -> Optional[SearchResult]:
        if planner == "shortest":
            return self._search.shortest(*joins, closed=closed)
        return self._search.cheapest(*joins, graph=self._graph_edges, closed=closed)

    def _smoothed(self, ends: Tuple[np.ndarray, np.ndarray], result: SearchResult, planner: str,
                  discs: np.ndarray) -> np.ndarray:
        """The driven path in cells along the grid's axes."""
        lattice = self.lattice
        nodes = np.concatenate([result.nodes[:1], result.nodes, result.nodes[-1:]])
        centres = np.column_stack([lattice.col[result.nodes], lattice.row[result.nodes]]) + 0.5
        points = np.vstack([ends[0], centres, ends[1]])
        parts = self._search.evaluate(result.nodes, result.headings)
        paid = np.concatenate([[0.0], np.cumsum(parts.sum(axis=0) if planner == "social" else parts[0])])
        joints = np.hypot(*(points[[0, -1]] - points[[1, -2]]).T) * lattice.resolution
        paid = np.concatenate([[0.0], paid + joints[0], [paid[-1] + joints.sum()]])
        exempt = lattice.cells(result.nodes[[0, -1]])
        prices = Prices(lattice.links, self._social, exempt,
                        (self.config.exemption_radius / lattice.resolution) ** 2)
        return smooth(points, nodes, paid, self._ground(discs), prices,
                      bound=self.config.smoothing_bound if planner == "social" else -1.0,
                      corner_radius=self.config.corner_radius)

    def _no_path(self, start: Sequence[float], goal: Sequence[float], avoid: Sequence[Disc]) -> NoPath:
        around = f" round {len(avoid)} obstacles" if avoid else ""
        return NoPath(f"no path for a robot of radius {self.config.robot_radius:g} m from "
                      f"({start[0]:.2f}, {start[1]:.2f}) to ({goal[0]:.2f}, {goal[1]:.2f}){around}; "
                      "every way is blocked or too narrow")
