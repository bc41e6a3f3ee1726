"""Brute force over all robots at once, in ticks: what planners of fleets are measured against on tiny worlds."""

import heapq
import itertools
import math
from typing import Dict, Iterator, List, Sequence, Tuple

import numpy as np

from social_fleet.coordination.robot import Robot
from social_fleet.mapping.grid import OccupancyGrid

Cell = Tuple[int, int]
State = Tuple[Cell, Cell, int, bool]  # from and to; ticks that it is under way; whether it has parked for good


def least_sum_of_arrivals(grid: OccupancyGrid, robots: Sequence[Robot], tick: float) -> float:
    """Least sum of arrival times [s] where robots set out at whole ticks only; infinite where there is no schedule.

    Starts and goals are cell centres, and the map has no room for diagonal moves: every move is one cell long. All
    combinations of the robots' doings are tried, tick by tick, cheapest first.
    """
    goals = [grid.cell(robot.goal.x, robot.goal.y) for robot in robots]
    ticks = [round(grid.resolution / robot.max_speed / tick) for robot in robots]
    start = tuple((grid.cell(robot.start.x, robot.start.y),) * 2 + (0, False) for robot in robots)
    best: Dict[Tuple[State, ...], int] = {start: 0}
    queue: List[Tuple[int, Tuple[State, ...]]] = [(0, start)]
    while queue:
        cost, states = heapq.heappop(queue)
        if cost > best[states]:
            continue
        if all(state[3] for state in states):
            return cost * tick
        options = [list(_options(grid, state, goal)) for state, goal in zip(states, goals)]
        for begun in itertools.product(*options):
            after = tuple(_advanced(state, needed) for state, needed in zip(begun, ticks))
            if all(state[3] for state in begun):
                after = begun
            if not _apart(grid, robots, begun, after, ticks):
                continue
            total = cost + sum(not state[3] for state in begun)
            if total < best.get(after, 10 ** 9):
                best[after] = total
                heapq.heappush(queue, (total, after))
    return math.inf


def _options(grid: OccupancyGrid, state: State, goal: Cell) -> Iterator[State]:
    """What a robot may be about in the next tick."""
    cell, _, under_way, parked = state
    if under_way or parked:
        yield state
        return
    yield state
    if cell == goal:
        yield (cell, cell, 0, True)
    for row, column in ((0, 1), (1, 0), (0, -1), (-1, 0)):
        other = cell[0] + row, cell[1] + column
        if 0 <= other[0] < grid.shape[0] and 0 <= other[1] < grid.shape[1] and not grid.blocked[other]:
            yield (cell, other, 0, False)


def _advanced(state: State, needed: int) -> State:
    cell, other, under_way, parked = state
    if cell == other:
        return state
    return (other, other, 0, False) if under_way + 1 == needed else (cell, other, under_way + 1, parked)


def _apart(grid: OccupancyGrid, robots: Sequence[Robot], begun: Sequence[State], after: Sequence[State],
           ticks: Sequence[int]) -> bool:
    """Whether no two discs overlap during the tick."""
    first = [_place(grid, state, needed) for state, needed in zip(begun, ticks)]
    last = [_place(grid, state, needed) for state, needed in zip(after, ticks)]
    for r, s in itertools.combinations(range(len(robots)), 2):
        steps = np.linspace(0.0, 1.0, 6)[:, None]
        gaps = (first[r] - first[s]) * (1.0 - steps) + (last[r] - last[s]) * steps
        if np.hypot(gaps[:, 0], gaps[:, 1]).min() < robots[r].body_radius + robots[s].body_radius - 1e-9:
            return False
    return True


def _place(grid: OccupancyGrid, state: State, needed: int) -> np.ndarray:
    cell, other, under_way, _ = state
    here, there = np.array(grid.centre(*cell)), np.array(grid.centre(*other))
    return here + (there - here) * under_way / needed
