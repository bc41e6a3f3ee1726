"""Corners of a driven path: short bends merged into one, and every corner rounded as far as there is room.

Coordinates and radii are in cells.
"""

import math
from typing import Tuple

import numpy as np
from numba import njit

from social_fleet.planning.driven_path.chords import Ground, is_free, is_free_for

MAX_TURN = math.radians(7.5)  # heading change from vertex to vertex on an arc
SMALL_TURN = math.radians(4.0)  # such a corner needs no rounding
SHRINK = 0.75


@njit(cache=True, nogil=True)
def _turn(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    """Signed heading change at b [rad]."""
    ux, uy, vx, vy = b[0] - a[0], b[1] - a[1], c[0] - b[0], c[1] - b[1]
    return math.atan2(ux * vy - uy * vx, ux * vx + uy * vy)


@njit(cache=True, nogil=True)
def _gap(a: np.ndarray, b: np.ndarray) -> float:
    return math.hypot(b[0] - a[0], b[1] - a[1])


@njit(cache=True, nogil=True)
def merge_bends(ground: Ground, vertices: np.ndarray, longest: float) -> np.ndarray:
    """Every side shorter than `longest` between two turns of one sense gives way to where its neighbours meet."""
    points = vertices.copy()
    count = len(points)
    v = 1
    while v + 2 < count:
        a, b, c, d = points[v - 1], points[v], points[v + 1], points[v + 2]
        first, second = _turn(a, b, c), _turn(b, c, d)
        side = _gap(b, c)
        if side < longest and first * second > 0.0 and abs(first + second) < 2.2:
            reach = side * math.sin(abs(second)) / math.sin(abs(first + second))
            scale = reach / _gap(a, b)
            meeting = b + (b - a) * scale
            if (_gap(b, meeting) < longest and is_free(ground, b[0], b[1], meeting[0], meeting[1])
                    and is_free(ground, meeting[0], meeting[1], c[0], c[1])):
                points[v] = meeting
                points[v + 1:count - 1] = points[v + 2:count].copy()
                count -= 1
                v = max(v - 1, 1)
                continue
        v += 1
    return points[:count].copy()


@njit(cache=True, nogil=True)
def _arc(a: np.ndarray, b: np.ndarray, c: np.ndarray, tangent: float, longest: float) -> np.ndarray:
    """Points of the arc that rounds corner b, touching its sides `tangent` from b."""
    turn = _turn(a, b, c)
    radius = tangent / math.tan(0.5 * abs(turn))
    ux, uy = (b[0] - a[0]) / _gap(a, b), (b[1] - a[1]) / _gap(a, b)
    sense = 1.0 if turn > 0.0 else -1.0
    x0, y0 = b[0] - tangent * ux, b[1] - tangent * uy
    centre_x, centre_y = x0 - sense * radius * uy, y0 + sense * radius * ux
    pieces = int(math.ceil(max(abs(turn) / MAX_TURN, radius * abs(turn) / longest)))
    arc = np.empty((pieces + 1, 2))
    for i in range(pieces + 1):
        angle = turn * i / pieces
        cos, sin = math.cos(angle), math.sin(angle)
        dx, dy = x0 - centre_x, y0 - centre_y
        arc[i, 0] = centre_x + cos * dx - sin * dy
        arc[i, 1] = centre_y + sin * dx + cos * dy
    return arc


@njit(cache=True, nogil=True)
def _fits(ground: Ground, radius: float, arc: np.ndarray) -> bool:
    for i in range(len(arc) - 1):
        if not is_free_for(ground, radius, arc[i, 0], arc[i, 1], arc[i + 1, 0], arc[i + 1, 1]):
            return False
    return True


@njit(cache=True, nogil=True)
def _tangents(points: np.ndarray, radius: float) -> Tuple[np.ndarray, np.ndarray]:
    """Turn and tangent length wanted at every vertex, sides shared in proportion where they are too short."""
    count = len(points)
    turns, tangents = np.zeros(count), np.zeros(count)
    for v in range(1, count - 1):
        turns[v] = _turn(points[v - 1], points[v], points[v + 1])
        if abs(turns[v]) > SMALL_TURN:
            tangents[v] = radius * math.tan(0.5 * min(abs(turns[v]), 3.0))
    shares = np.ones(count)
    for v in range(count - 1):
        wanted = tangents[v] + tangents[v + 1]
        side = 0.999 * _gap(points[v], points[v + 1])
        if wanted > side:
            shares[v] = min(shares[v], side / wanted)
            shares[v + 1] = min(shares[v + 1], side / wanted)
    return turns, tangents * shares


@njit(cache=True, nogil=True)
def round_corners(ground: Ground, narrow: float, points: np.ndarray, radius: float, smallest: float,
                  longest: float) -> np.ndarray:
    """The path with its corners replaced by arcs of up to `radius`, sampled at most `longest` apart.

    A corner stays sharp where an arc of `smallest` has no room, not even for a disc of the radius `narrow`.
    """
    _, _, _, wide, _ = ground
    count = len(points)
    turns, tangents = _tangents(points, radius)
    pieces = 2
    for v in range(1, count - 1):
        pieces += int(abs(turns[v]) / MAX_TURN + radius * abs(turns[v]) / longest) + 3
    rounded = np.empty((pieces, 2))
    rounded[0] = points[0]
    top = 1
    for v in range(1, count - 1):
        half = math.tan(0.5 * min(abs(turns[v]), 3.0))
        placed = False
        for fitting in (wide, narrow):
            tangent = tangents[v]
            while not placed and tangent > 0.0 and tangent >= smallest * half:
                arc = _arc(points[v - 1], points[v], points[v + 1], tangent, longest)
                if _fits(ground, fitting, arc):
                    rounded[top:top + len(arc)] = arc
                    top += len(arc)
                    placed = True
                tangent *= SHRINK
        if not placed:
            rounded[top] = points[v]
            top += 1
    rounded[top] = points[count - 1]
    return rounded[:top + 1].copy()
