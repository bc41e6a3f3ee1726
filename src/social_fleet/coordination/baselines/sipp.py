"""Safe-interval path planning: a robot's earliest arrival among moving discs, in continuous time.

A state is a node together with one of the intervals in which the robot may stand there; the earliest time in it is the
best, for the robot can wait. Moves take as long as they are long, and leave as early as nothing touches them.

References
----------
M. Phillips and M. Likhachev, "SIPP: Safe interval path planning for dynamic environments", ICRA 2011.
"""

import heapq
from typing import List, NamedTuple, Tuple

import numpy as np
from numba import njit

from social_fleet.coordination.baselines.contact import contact, unsafe_departures
from social_fleet.coordination.baselines.roadmap import Graph
from social_fleet.coordination.baselines.traffic import (
    BEGIN, END, HARD, MARGIN, OWNER, RADIUS, VX, VY, X, Y, Traffic, bin_of)

_GRAIN = 1e-6  # costs that differ by less are equal, and the way with fewer contacts is taken [s]
_NUDGE = 1e-7  # by which a departure is put off at least, lest rounding keep it where it is [s]
_SHORTEST_STAY = 1e-6  # safe intervals that are shorter do not count [s]


class Rules(NamedTuple):
    """What a search has to keep besides the traffic.

    Attributes
    ----------
    edges, nodes : (K, 3) arrays
        Edge that must not be entered, node that must not be occupied, from when [s], and before when [s]; ascending.
    window : (2,) array
        The arrival is not before and not after [s].
    """

    edges: np.ndarray
    nodes: np.ndarray
    window: np.ndarray


NO_RULES = Rules(np.empty((0, 3)), np.empty((0, 3)), np.array([-np.inf, np.inf]))


class States(NamedTuple):
    """A growing table of states; the lists are parallel."""

    node: List[int]
    low: List[float]  # begin of the safe interval
    high: List[float]  # its end
    latest: List[float]  # the latest arrival in it
    arrival: List[float]  # the earliest so far
    contacts: List[int]  # with soft traffic, up to then
    parent: List[int]  # the state before, -1 for none
    edge: List[int]  # by which it came
    left: List[float]  # when it set out on it
    settled: List[bool]


@njit(cache=True, nogil=True)
def earliest_arrival(graph: Graph, distances: np.ndarray, start: int, goal: int, speed: float, radius: float,
                     depart: float, robot: int, traffic: Traffic, rules: Rules,
                     stop: np.ndarray) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A* over (node, safe interval) from `start`, where the robot stands until `depart` [s], to `goal` for ever.

    Of arrivals that are equally early it takes one with few contacts with soft traffic. `distances` (N,) [m] are those
    to the goal; pieces that `robot` owns do not count.

    Returns
    -------
    nodes (M,), edges (M - 1,), departures (M - 1,)
        The way and when it leaves each node [s]; no nodes when there is no way, or `stop` was raised.
    """
    xs, ys, first, target, length = graph
    pieces, bins, items, frame = traffic
    edge_rules, node_rules, window = rules
    states = _no_states()
    node_of, low, high, latest, arrival, contacts, parent, entered, left, settled = states
    opened = np.full((len(xs), 2), -1, dtype=np.int64)  # first state of a node, and the one after its last
    queue = [(np.int64(0), 0, 0.0, 0) for _ in range(0)]
    final = -1
    for place in (start, goal):
        if opened[place, 0] < 0:
            opened[place, 0] = len(node_of)
            _open(states, place, xs[place], ys[place], radius, robot, bin_of(frame, xs[place], ys[place]), pieces,
                  bins, items, node_rules)
            if place == goal and len(node_of) > opened[place, 0] and high[-1] == np.inf:
                final = len(node_of)
                _add(states, goal, max(low[-1], window[0]), np.inf, window[1])
            opened[place, 1] = len(node_of)
    for state in range(opened[start, 0], opened[start, 1]):
        stays = state == final and low[final - 1] <= 0.0 and low[final] <= depart <= window[1]
        if stays or (state != final and low[state] <= 0.0 and high[state] >= depart):
            arrival[state] = depart
            heapq.heappush(queue, (np.int64((depart + distances[start] / speed) / _GRAIN + 0.5), 0, -depart, state))
    while queue and final >= 0 and not stop[0]:
        _, _, _, state = heapq.heappop(queue)
        if settled[state]:
            continue
        settled[state] = True
        if state == final:
            return _traced(states, final)
        node, ready = node_of[state], arrival[state]
        bin_ = bin_of(frame, xs[node], ys[node])
        for edge in range(first[node], first[node + 1]):
            other = target[edge]
            if opened[other, 0] < 0:
                opened[other, 0] = len(node_of)
                _open(states, other, xs[other], ys[other], radius, robot, bin_of(frame, xs[other], ys[other]), pieces,
                      bins, items, node_rules)
                opened[other, 1] = len(node_of)
            duration = length[edge] / speed
            vx, vy = (xs[other] - xs[node]) / duration, (ys[other] - ys[node]) / duration
            for after in range(opened[other, 0], opened[other, 1]):
                earliest = max(ready, low[after] - duration)
                until = min(high[state], latest[after] - duration)
                if settled[after] or earliest > until or earliest + duration > arrival[after] + _GRAIN:
                    continue
                leave = _departure(xs[node], ys[node], vx, vy, duration, earliest, until, radius, robot, edge, bin_,
                                   pieces, bins, items, edge_rules)
                reached = leave + duration
                if leave > until or reached > arrival[after] + _GRAIN:
                    continue
                met = contacts[state] + _soft_contacts(xs[node], ys[node], vx, vy, ready, leave, duration,
                                                       after == final, radius, robot, bin_, pieces, bins, items)
                if reached < arrival[after] - _GRAIN or met < contacts[after]:
                    arrival[after], contacts[after] = reached, met
                    parent[after], entered[after], left[after] = state, edge, leave
                    rank = np.int64((reached + distances[other] / speed) / _GRAIN + 0.5)
                    heapq.heappush(queue, (rank, met, -reached, after))
    return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0)


@njit(cache=True, nogil=True)
def _no_states() -> States:
    return States([0 for _ in range(0)], [0.0 for _ in range(0)], [0.0 for _ in range(0)], [0.0 for _ in range(0)],
                  [0.0 for _ in range(0)], [0 for _ in range(0)], [0 for _ in range(0)], [0 for _ in range(0)],
                  [0.0 for _ in range(0)], [False for _ in range(0)])


@njit(cache=True, nogil=True)
def _add(states: States, node: int, low: float, high: float, latest: float) -> None:
    states.node.append(node)
    states.low.append(low)
    states.high.append(high)
    states.latest.append(latest)
    states.arrival.append(np.inf)
    states.contacts.append(0)
    states.parent.append(-1)
    states.edge.append(-1)
    states.left.append(0.0)
    states.settled.append(False)


@njit(cache=True, nogil=True)
def _open(states: States, node: int, x: float, y: float, radius: float, robot: int, bin_: int, pieces: np.ndarray,
          bins: np.ndarray, items: np.ndarray, rules: np.ndarray) -> None:
    """Add a state for every interval in which the robot may stand at `node`."""
    unsafe = [(0.0, 0.0) for _ in range(0)]
    for place in range(bins[bin_], bins[bin_ + 1]):
        k = items[place]
        if pieces[k, HARD] == 1.0 and pieces[k, OWNER] != robot:
            start, end = contact(pieces[k, X] - x, pieces[k, Y] - y, pieces[k, VX], pieces[k, VY],
                                 pieces[k, END] - pieces[k, BEGIN], radius + pieces[k, RADIUS] + 2.0 * MARGIN)
            if start < end:
                begin = pieces[k, BEGIN]
                unsafe.append((begin + start, pieces[k, END] if begin == -np.inf else begin + end))
    rule = np.searchsorted(rules[:, 0], float(node))
    while rule < len(rules) and rules[rule, 0] == node:
        unsafe.append((rules[rule, 1], rules[rule, 2]))
        rule += 1
    unsafe.sort()
    free_from = -np.inf
    for low, high in unsafe:
        if low - free_from >= _SHORTEST_STAY:
            _add(states, node, free_from, low, low)
        free_from = max(free_from, high)
    if free_from < np.inf:
        _add(states, node, free_from, np.inf, np.inf)


@njit(cache=True, nogil=True)
def _departure(x: float, y: float, vx: float, vy: float, duration: float, earliest: float, until: float, radius: float,
               robot: int, edge: int, bin_: int, pieces: np.ndarray, bins: np.ndarray, items: np.ndarray,
               rules: np.ndarray) -> float:
    """The earliest departure from `earliest` on at which nothing is touched and no rule broken; late if there is none.

    Each obstacle rules out one interval of departures; whatever is found in the way puts the departure off to the end
    of its interval, and all is looked at again.
    """
    leave = earliest
    put_off = True
    while put_off and leave <= until:
        put_off = False
        rule = np.searchsorted(rules[:, 0], float(edge))
        while rule < len(rules) and rules[rule, 0] == edge:
            if rules[rule, 1] <= leave < rules[rule, 2]:
                leave, put_off = rules[rule, 2], True
            rule += 1
        for place in range(bins[bin_], bins[bin_ + 1]):
            k = items[place]
            begin, end = pieces[k, BEGIN], pieces[k, END]
            if pieces[k, HARD] == 0.0 or begin >= leave + duration or end <= leave or pieces[k, OWNER] == robot:
                continue
            reach = radius + pieces[k, RADIUS] + MARGIN
            if _touches(x, y, vx, vy, leave, duration, begin, end, pieces[k, X], pieces[k, Y], pieces[k, VX],
                        pieces[k, VY], reach):
                _, high = unsafe_departures(x, y, vx, vy, duration, begin, end, pieces[k, X], pieces[k, Y],
                                            pieces[k, VX], pieces[k, VY], reach + MARGIN)
                leave, put_off = max(high, leave + _NUDGE), True
    return leave


@njit(cache=True, nogil=True)
def _soft_contacts(x: float, y: float, vx: float, vy: float, ready: float, leave: float, duration: float, stays: bool,
                   radius: float, robot: int, bin_: int, pieces: np.ndarray, bins: np.ndarray,
                   items: np.ndarray) -> int:
    """How many soft pieces are touched while waiting from `ready` on, moving, and, if it `stays`, ever after."""
    met = 0
    goal_x, goal_y = x + vx * duration, y + vy * duration
    for place in range(bins[bin_], bins[bin_ + 1]):
        k = items[place]
        begin, end = pieces[k, BEGIN], pieces[k, END]
        if end <= ready or pieces[k, HARD] == 1.0 or pieces[k, OWNER] == robot:
            continue
        if begin >= leave + duration and not stays:
            continue
        px, py, ux, uy = pieces[k, X], pieces[k, Y], pieces[k, VX], pieces[k, VY]
        reach = radius + pieces[k, RADIUS] + MARGIN
        if _touches(x, y, vx, vy, leave, duration, begin, end, px, py, ux, uy, reach) or (leave > ready and _touches(
                x, y, 0.0, 0.0, ready, leave - ready, begin, end, px, py, ux, uy, reach)) or (stays and _touches(
                    goal_x, goal_y, 0.0, 0.0, leave + duration, np.inf, begin, end, px, py, ux, uy, reach)):
            met += 1
    return met


@njit(cache=True, nogil=True)
def _touches(x: float, y: float, vx: float, vy: float, leave: float, duration: float, begin: float, end: float,
             px: float, py: float, ux: float, uy: float, reach: float) -> bool:
    """Whether a motion that leaves (x, y) at `leave` and another come closer than `reach` while both last."""
    start, stop = max(leave, begin), min(leave + duration, end)
    if start >= stop:
        return False
    done, past = start - leave, 0.0 if begin == -np.inf else start - begin
    low, high = contact(x + vx * done - px - ux * past, y + vy * done - py - uy * past, vx - ux, vy - uy, stop - start,
                        reach)
    return low < high


@njit(cache=True, nogil=True)
def _traced(states: States, final: int) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes, edges and departures of the way to a state."""
    steps, state = 0, final
    while states.parent[state] >= 0:
        steps, state = steps + 1, states.parent[state]
    nodes, edges, departures = np.empty(steps + 1, np.int64), np.empty(steps, np.int64), np.empty(steps)
    state = final
    for k in range(steps, -1, -1):
        nodes[k] = states.node[state]
        if k > 0:
            edges[k - 1], departures[k - 1] = states.edge[state], states.left[state]
            state = states.parent[state]
    return nodes, edges, departures
