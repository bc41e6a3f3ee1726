"""Conflicts of two motions, and the two sets of rules that each leaves the choice between; see doc/baselines.md."""

from dataclasses import dataclass
from typing import Tuple, Union

import numpy as np
from numba import njit

from social_fleet.coordination.baselines.contact import contact, unsafe_departures
from social_fleet.coordination.baselines.traffic import (
    BEGIN, EDGE, END, MARGIN, NODE, VX, VY, WAIT, X, Y, Trajectory)

_SHARE = 0.5  # of a contact, from which on the one that stands has to be away if the other goes on as it does
_NEARLY_PAST = 0.999  # of a contact with a parked robot, at which it is asked whether that has parked


@dataclass(frozen=True)
class Conflict:
    """The first contact of two motions.

    Attributes
    ----------
    r, s : int
        The robots.
    r_piece, s_piece : int
        Indices of the pieces in contact; at least one is a move.
    time : float
        When it begins [s].
    """

    r: int
    s: int
    r_piece: int
    s_piece: int
    time: float


@dataclass(frozen=True)
class EdgeRule:
    """`robot` must not enter `edge` at any time from `begin` on, before `end` [s]."""

    robot: int
    edge: int
    begin: float
    end: float


@dataclass(frozen=True)
class NodeRule:
    """`robot` must not be at `node` at any time after `begin`, before `end` [s]."""

    robot: int
    node: int
    begin: float
    end: float


@dataclass(frozen=True)
class ParkedRule:
    """`robot` has arrived by `time` [s], so that nobody else touches it where it is parked from then on."""

    robot: int
    time: float


@dataclass(frozen=True)
class LateRule:
    """`robot` arrives after `time` [s]."""

    robot: int
    time: float


Rule = Union[EdgeRule, NodeRule, ParkedRule, LateRule]


def first_conflict(r: int, s: int, motions: Tuple[Trajectory, ...]) -> Tuple[Conflict, ...]:
    """The first contact of two robots' motions; empty where they never touch."""
    reach = motions[r].radius + motions[s].radius + MARGIN
    time, r_piece, s_piece = _first_contact(motions[r].pieces, motions[s].pieces, reach)
    return (Conflict(r, s, r_piece, s_piece, time),) if time < np.inf else ()


def split(conflict: Conflict, motions: Tuple[Trajectory, ...]) -> Tuple[Rule, Rule]:
    """Two rules, of which every solution keeps at least one, and the present motions neither."""
    r, s = motions[conflict.r].pieces, motions[conflict.s].pieces
    reach = motions[conflict.r].radius + motions[conflict.s].radius + MARGIN
    if r[conflict.r_piece, EDGE] == WAIT:
        return _split_standing(conflict.r, r, conflict.r_piece, conflict.s, s, conflict.s_piece, reach)
    if s[conflict.s_piece, EDGE] == WAIT:
        return _split_standing(conflict.s, s, conflict.s_piece, conflict.r, r, conflict.r_piece, reach)
    return _split_moves(conflict.r, r[conflict.r_piece], conflict.s, s[conflict.s_piece], reach)


def _split_standing(standing: int, pieces: np.ndarray, stay: int, moving: int, others: np.ndarray, move: int,
                    reach: float) -> Tuple[Rule, Rule]:
    """One stands where the other passes.

    Where it stands all the while of the contact, the two are kept apart by times; where it comes or goes in between, by
    its move to or from there, which then is in contact, too.
    """
    place, way = pieces[stay], others[move]
    start, end = contact(way[X] - place[X], way[Y] - place[Y], way[VX], way[VY], way[END] - way[BEGIN], reach)
    start, end = way[BEGIN] + start, way[BEGIN] + end
    if place[BEGIN] > start and stay > 0:
        return _split_moves(standing, pieces[stay - 1], moving, way, reach)
    if place[END] == np.inf:
        time = start + _NEARLY_PAST * (end - start)
        return ParkedRule(standing, time), LateRule(standing, time)
    if place[END] < end:
        return _split_moves(standing, pieces[stay + 1], moving, way, reach)
    middle = start + _SHARE * (end - start)
    return (NodeRule(standing, int(place[NODE]), middle, end),
            EdgeRule(moving, int(way[EDGE]), way[BEGIN], way[BEGIN] + middle - start))


def _split_moves(r: int, r_move: np.ndarray, s: int, s_move: np.ndarray, reach: float) -> Tuple[Rule, Rule]:
    """Both move: in contact at any departures between the present ones and those at which they are clear."""
    return _later(r, r_move, s_move, reach), _later(s, s_move, r_move, reach)


def _later(robot: int, move: np.ndarray, other: np.ndarray, reach: float) -> EdgeRule:
    _, clear = unsafe_departures(move[X], move[Y], move[VX], move[VY], move[END] - move[BEGIN], other[BEGIN],
                                 other[END], other[X], other[Y], other[VX], other[VY], reach + MARGIN)
    return EdgeRule(robot, int(move[EDGE]), move[BEGIN], clear)


@njit(cache=True, nogil=True)
def _first_contact(r: np.ndarray, s: np.ndarray, reach: float) -> Tuple[float, int, int]:
    """When two motions first come closer than `reach`, infinite if never, and in which of their pieces."""
    i, j = 0, 0
    while i < len(r) and j < len(s):
        begin, end = max(r[i, BEGIN], s[j, BEGIN]), min(r[i, END], s[j, END])
        if begin < end and begin > -np.inf:
            x = r[i, X] - s[j, X]
            y = r[i, Y] - s[j, Y]
            if r[i, BEGIN] > -np.inf:
                x, y = x + r[i, VX] * (begin - r[i, BEGIN]), y + r[i, VY] * (begin - r[i, BEGIN])
            if s[j, BEGIN] > -np.inf:
                x, y = x - s[j, VX] * (begin - s[j, BEGIN]), y - s[j, VY] * (begin - s[j, BEGIN])
            low, high = contact(x, y, r[i, VX] - s[j, VX], r[i, VY] - s[j, VY], end - begin, reach)
            if low < high:
                return begin + low, i, j
        if r[i, END] <= s[j, END]:
            i += 1
        else:
            j += 1
    return np.inf, -1, -1
