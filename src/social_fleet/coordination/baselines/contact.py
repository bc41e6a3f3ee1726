"""When two discs in straight motion overlap, in closed form; see doc/baselines.md for why the answers are intervals."""

import math
from typing import Tuple

from numba import njit

_PARALLEL = 1e-12


@njit(cache=True, nogil=True)
def contact(x: float, y: float, vx: float, vy: float, duration: float, reach: float) -> Tuple[float, float]:
    """The part (first, last) of [0, duration] in which an offset (x, y) + s (vx, vy) is shorter than `reach`.

    Returns first >= last where there is none. `duration` may be infinite for an offset that does not change.
    """
    excess = x * x + y * y - reach * reach
    square = vx * vx + vy * vy
    if square <= 0.0:
        return (0.0, duration) if excess < 0.0 else (1.0, 0.0)
    half = x * vx + y * vy
    discriminant = half * half - square * excess
    if discriminant <= 0.0:
        return 1.0, 0.0
    root = math.sqrt(discriminant)
    return max((-half - root) / square, 0.0), min((-half + root) / square, duration)


@njit(cache=True, nogil=True)
def unsafe_departures(x: float, y: float, wx: float, wy: float, duration: float, begin: float, end: float,
                      px: float, py: float, ux: float, uy: float, reach: float) -> Tuple[float, float]:
    """The departure times (low, high) at which a move comes closer than `reach` to another robot's motion.

    Parameters
    ----------
    x, y, wx, wy, duration
        The move: from where [m], with what velocity [m/s], for how long [s].
    begin, end, px, py, ux, uy
        The other's motion: from when to when [s], from where [m], with what velocity [m/s]. One that stands may do so
        from or until infinity.
    reach
        Distance of the centres [m] below which the discs overlap.

    Returns
    -------
    low, high : float
        An open interval [s]; low >= high where no departure is unsafe.
    """
    cx, cy = x - px, y - py
    if ux == 0.0 and uy == 0.0:
        first, last = contact(cx, cy, wx, wy, duration, reach)
        if first >= last:
            return 1.0, 0.0
        return begin - last, end - first
    # Over the box of s in [0, duration] into the move and q in [0, span] into the other's motion, those of less than
    # `reach` apart are a convex set; the extremes of q - s over it are the answer.
    span = end - begin
    low, high = math.inf, -math.inf
    for fixed in (0.0, duration):
        first, last = contact(-cx - fixed * wx, -cy - fixed * wy, ux, uy, span, reach)
        if first < last:
            low, high = min(low, first - fixed), max(high, last - fixed)
    for fixed in (0.0, span):
        first, last = contact(cx - fixed * ux, cy - fixed * uy, wx, wy, duration, reach)
        if first < last:
            low, high = min(low, fixed - last), max(high, fixed - first)
    vx, vy = wx - ux, wy - uy
    square = vx * vx + vy * vy
    turn = ux * vy - uy * vx
    if abs(turn) > _PARALLEL:
        for sign in (-1.0, 1.0):
            delay = (cx * vy - cy * vx + sign * reach * math.sqrt(square)) / turn
            s = -((cx - ux * delay) * vx + (cy - uy * delay) * vy) / square
            if 0.0 <= s <= duration and 0.0 <= s + delay <= span:
                low, high = min(low, delay), max(high, delay)
    if low >= high:
        return 1.0, 0.0
    return begin + low, begin + high
