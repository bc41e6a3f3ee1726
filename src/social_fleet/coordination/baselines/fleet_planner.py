"""What planners of whole fleets share: robots in, a schedule out, and the ground that they search on."""

import time
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Dict, Iterator, List, Optional, Sequence, Tuple

import numpy as np

from social_fleet.coordination.baselines.deadline import Deadline
from social_fleet.coordination.baselines.roadmap import Roadmap
from social_fleet.coordination.baselines.sipp import NO_RULES, Rules, earliest_arrival
from social_fleet.coordination.baselines.traffic import (
    BEGIN, EDGE, END, MARGIN, NODE, VX, WAIT, X, Traffic, Trajectory, traffic_of)
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import FleetSchedule, Schedule
from social_fleet.errors import InvalidParameter, InvalidPose, InvalidScenario, NoPath
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.mapping.grid import OccupancyGrid


@dataclass(frozen=True)
class Traveller:
    """A robot as the searches see it: start and goal are nodes of its roadmap."""

    index: int
    roadmap: Roadmap
    start: int
    goal: int
    speed: float  # [m/s]
    depart: float  # [s]

    @property
    def shortest(self) -> float:
        """Length of the shortest way [m]; infinite where there is none."""
        return float(self.roadmap.distances(self.goal)[self.start])

    def search(self, traffic: Traffic, stop: np.ndarray, rules: Rules = NO_RULES) -> Optional[Trajectory]:
        """The motion with the earliest arrival, None where there is none or `stop` was raised; see `sipp`."""
        roadmap = self.roadmap
        nodes, edges, departures = earliest_arrival(
            roadmap.graph, roadmap.distances(self.goal), self.start, self.goal, self.speed, roadmap.radius, self.depart,
            self.index, traffic, rules, stop)
        if not len(nodes):
            return None
        return Trajectory(self._pieces(nodes, edges, departures), roadmap.radius)

    def _pieces(self, nodes: np.ndarray, edges: np.ndarray, departures: np.ndarray) -> np.ndarray:
        """A move per edge, and the waits between them."""
        graph = self.roadmap.graph
        places = np.stack([graph.x[nodes], graph.y[nodes]], axis=1)
        spans = graph.length[edges] / self.speed
        arrivals = departures + spans
        waits = np.zeros((len(nodes), 8))
        waits[:, BEGIN] = np.concatenate([[-np.inf], arrivals])
        waits[:, END] = np.concatenate([departures, [np.inf]])
        waits[:, X:VX], waits[:, NODE], waits[:, EDGE] = places, nodes, WAIT
        moves = waits[:-1].copy()
        moves[:, BEGIN], moves[:, END] = departures, arrivals
        moves[:, VX:NODE], moves[:, EDGE] = np.diff(places, axis=0) / spans[:, None], edges
        pieces = np.empty((2 * len(nodes) - 1, 8))
        pieces[::2], pieces[1::2] = waits, moves
        if len(nodes) == 1:
            return np.stack([np.where(np.arange(8) == END, self.depart, pieces[0]),
                             np.where(np.arange(8) == BEGIN, self.depart, pieces[0])])
        return pieces[pieces[:, END] > pieces[:, BEGIN]]


class Ground:
    """The roadmaps and travellers of one fleet on one map.

    Parameters
    ----------
    grid : OccupancyGrid
        The map.
    robots : sequence of Robot
        Of whose paths only the ends count.
    coarsening : int
        Cells along the edge of a roadmap's block.
    deadline : Deadline

    Raises
    ------
    InvalidStart, InvalidGoal
        Where a robot does not fit at an end.
    InvalidScenario
        When there is no robot, two have one name, or their starts or goals touch.
    NoPath
        When no way joins a start to its goal.
    TimedOut
    """

    def __init__(self, grid: OccupancyGrid, robots: Sequence[Robot], coarsening: int, deadline: Deadline) -> None:
        _check(robots)
        self.robots = list(robots)
        self.extent = grid.size
        placed: Dict[int, Traveller] = {}
        for radius in sorted({robot.body_radius for robot in robots}):
            placed.update(self._placed(grid, radius, coarsening))
        self.travellers = [placed[index] for index in range(len(robots))]
        self.reach = max(float(traveller.roadmap.graph.length.max(initial=0.1)) for traveller in self.travellers)
        self.radius = max(robot.body_radius for robot in robots)
        for robot, traveller in zip(robots, self.travellers):
            deadline.check(f"a fleet of {len(robots)} robots")
            if not np.isfinite(traveller.shortest):
                raise NoPath(f"robot {robot.name}: no way for a disc of radius {robot.body_radius:g} m leads from "
                             f"({robot.start.x:.2f}, {robot.start.y:.2f}) to ({robot.goal.x:.2f}, {robot.goal.y:.2f}) "
                             f"on blocks of {coarsening * grid.resolution:g} m")

    def traffic(self, pieces: Sequence[np.ndarray]) -> Traffic:
        """Pieces sorted for these travellers' searches."""
        return traffic_of(pieces, extent=self.extent, reach=self.reach, radius=self.radius)

    def schedules(self, trajectories: Sequence[Trajectory]) -> Tuple[Schedule, ...]:
        """The travellers' motions as the robots' schedules, each robot on its new path."""
        return tuple(_schedule(robot, traveller.roadmap, trajectory)
                     for robot, traveller, trajectory in zip(self.robots, self.travellers, trajectories))

    def _placed(self, grid: OccupancyGrid, radius: float, coarsening: int) -> Iterator[Tuple[int, Traveller]]:
        """The travellers of one radius by index, on a roadmap of theirs."""
        space = ConfigurationSpace(grid, radius, limit=radius)
        chosen = [index for index, robot in enumerate(self.robots) if robot.body_radius == radius]
        points = []
        for index in chosen:
            robot = self.robots[index]
            for pose, what in ((robot.start, "start"), (robot.goal, "goal")):
                try:
                    space.check_pose(pose.x, pose.y, what)
                except InvalidPose as error:
                    raise type(error)(f"robot {robot.name}: {error.message}", field=what) from None
                points.append((pose.x, pose.y))
        roadmap = Roadmap(grid, radius, coarsening, np.array(points))
        for index, (start, goal) in zip(chosen, roadmap.terminals.reshape(-1, 2)):
            robot = self.robots[index]
            yield index, Traveller(index, roadmap, int(start), int(goal), robot.max_speed, robot.depart)


class FleetPlanner(ABC):
    """Plans paths and times of a whole fleet at once.

    Robots move in straight lines between the nodes of a `Roadmap` at their own maximum speed, wait at nodes for as long
    as they like, and are at full speed and turned at once: less than `coordinate` demands. They stand on their starts
    before, and on their goals for ever after.

    Parameters
    ----------
    coarsening : int
        Cells along the edge of a roadmap's block; the paper has 4.

    Raises
    ------
    InvalidParameter
        When it is not a whole number from 1 on.
    """

    name: str

    def __init__(self, *, coarsening: int = 4) -> None:
        if not isinstance(coarsening, int) or isinstance(coarsening, bool) or coarsening < 1:
            raise InvalidParameter(f"must be a whole number from 1 on, not {coarsening!r}", field="coarsening")
        self.coarsening = coarsening

    def plan(self, grid: OccupancyGrid, robots: Sequence[Robot], *, time_limit: float = 30.0) -> FleetSchedule:
        """Schedules from every robot's start to its goal such that no two discs ever touch, nor a disc a wall.

        Parameters
        ----------
        grid : OccupancyGrid
            The map.
        robots : sequence of Robot
            Of their paths only the ends count.
        time_limit : float
            Wall time for everything [s].

        Returns
        -------
        FleetSchedule
            In the order of `robots`, on new paths; its formulation is the planner's name.

        Raises
        ------
        InvalidScenario, InvalidStart, InvalidGoal, InvalidParameter
            For robots or a limit that cannot be.
        NoPath
            When no way joins a start to its goal even without the others.
        Infeasible
            When the planner has tried all that it tries.
        TimedOut
        """
        begun = time.perf_counter()
        with Deadline(time_limit) as deadline:
            ground = Ground(grid, robots, self.coarsening, deadline)
            ready = time.perf_counter()
            trajectories, gap = self._solve(ground, deadline)
        schedules = ground.schedules(trajectories)
        return FleetSchedule(schedules, (), self.name, objective=sum(schedule.arrival_time for schedule in schedules),
                             gap=gap, planning_time=ready - begun, solve_time=time.perf_counter() - ready)

    @abstractmethod
    def _solve(self, ground: Ground, deadline: Deadline) -> Tuple[List[Trajectory], float]:
        """A motion per traveller, none of which touch, and the relative distance to the proven bound."""


def _schedule(robot: Robot, roadmap: Roadmap, trajectory: Trajectory) -> Schedule:
    """A motion as a robot's path, with a knot wherever it begins to move or to stand."""
    pieces = trajectory.pieces
    moves = pieces[pieces[:, EDGE] != WAIT]
    if not len(moves):
        path = roadmap.positions(pieces[:1, NODE].astype(np.int64))
        return Schedule(replace(robot, plan=path, radius=robot.body_radius), np.zeros(1), pieces[-1:, BEGIN])
    nodes = np.append(moves[:, NODE], pieces[-1, NODE]).astype(np.int64)
    moved = replace(robot, plan=roadmap.positions(nodes), radius=robot.body_radius)
    arcs = moved.path.arc_lengths
    knots: Dict[float, float] = {}
    for move, before, after in zip(moves, arcs[:-1], arcs[1:]):
        knots[float(move[BEGIN])] = before
        knots[float(move[END])] = after
    return Schedule(moved, np.array(list(knots.values())), np.array(list(knots)))


def _check(robots: Sequence[Robot]) -> None:
    if not robots:
        raise InvalidScenario("there is no robot to plan for", field="robots")
    names = [robot.name for robot in robots]
    for name in names:
        if names.count(name) > 1:
            raise InvalidScenario(f"two robots are named {name}; names must differ", field="robots")
    for end, what in ((0, "start"), (-1, "goal")):
        points = np.array([robot.path.points[end] for robot in robots])
        for r, s in zip(*np.triu_indices(len(robots), 1)):
            apart, needed = np.hypot(*(points[r] - points[s])), robots[r].body_radius + robots[s].body_radius
            if apart < needed + 4.0 * MARGIN:
                raise InvalidScenario(f"{names[r]} and {names[s]} have {what}s {apart:.2f} m apart; their discs need "
                                      f"more than {needed:.2f} m", field="robots")
