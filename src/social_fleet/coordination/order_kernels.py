"""The loops of `order_state`: earliest times kept up to date while orders are given and taken back.

Events of one robot follow each other in the arrays; `offsets` says where each robot's begin. A row asks that its head
comes `margin` after its tail, while its order (2 * window + side) is chosen. `trail_*` records what was raised, and
from what, so that it can be taken back; `causes` holds the row that an event's time comes from, or -1 where it is the
event before.
"""

import numpy as np
from numba import njit

_RAISE = 1e-9  # smaller changes are rounding [s]
MISSED = 1e-6
"""By less than this a row is not missed [s]."""


@njit(cache=True, nogil=True)
def give(window, side, times, causes, floors, offsets, robots, fixed, latest,  # type: ignore[no-untyped-def]
         tails, heads, starts, outgoing, out_starts, owners, sides, margin,
         first, last, queue, trail_events, trail_times, trail_causes, top):
    """Choose a side of a window and raise what follows; the trail's new top, and the event that cannot be, or -1.

    An event cannot be when its robot is fixed, or when it is a goal reached after its `latest` time: on a cycle, each
    turn raises times.
    """
    sides[window] = side
    waiting = 0
    for row in range(starts[2 * window + side], starts[2 * window + side + 1]):
        time = times[tails[row]] + margin
        event = heads[row]
        if time > times[event] + _RAISE:
            trail_events[top], trail_times[top], trail_causes[top] = event, times[event], causes[event]
            top += 1
            if fixed[robots[event]] and time > floors[event] + MISSED or top > len(trail_events) - 2 * len(offsets):
                causes[event] = row
                _forget(first, queue, 0, waiting)
                return top, event
            times[event], causes[event] = time, row
            waiting = _mark(robots[event], event, first, last, queue, 0, waiting)
    begin = 0
    while waiting > 0:
        robot = queue[begin]
        begin = (begin + 1) % len(queue)
        waiting -= 1
        event, stop, end = first[robot], last[robot], offsets[robot + 1]
        first[robot] = -1
        while event < end:
            time = times[event]
            if event > offsets[robot]:
                after = times[event - 1] + floors[event] - floors[event - 1]
                if after > time + _RAISE:
                    trail_events[top], trail_times[top], trail_causes[top] = event, time, causes[event]
                    top += 1
                    times[event], causes[event] = after, -1
                    time = after
                elif event > stop:
                    break
            if top > len(trail_events) - 2 * len(offsets) or (event == end - 1 and time > latest[robot]):
                _forget(first, queue, begin, waiting)
                return top, event
            for place in range(out_starts[event], out_starts[event + 1]):
                row = outgoing[place]
                owner = owners[row]
                if sides[owner >> 1] != owner & 1:
                    continue
                head = heads[row]
                if time + margin > times[head] + _RAISE:
                    trail_events[top], trail_times[top], trail_causes[top] = head, times[head], causes[head]
                    top += 1
                    causes[head] = row
                    if fixed[robots[head]] and time + margin > floors[head] + MISSED or \
                            top > len(trail_events) - 2 * len(offsets):
                        _forget(first, queue, begin, waiting)
                        return top, head
                    times[head] = time + margin
                    waiting = _mark(robots[head], head, first, last, queue, begin, waiting)
            event += 1
    return top, -1


@njit(cache=True)
def _mark(robot, event, first, last, queue, begin, waiting):  # type: ignore[no-untyped-def]
    """Queue a robot one of whose events was raised."""
    if first[robot] < 0:
        first[robot] = last[robot] = event
        queue[(begin + waiting) % len(queue)] = robot
        return waiting + 1
    first[robot] = min(first[robot], event)
    last[robot] = max(last[robot], event)
    return waiting


@njit(cache=True)
def _forget(first, queue, begin, waiting):  # type: ignore[no-untyped-def]
    for place in range(waiting):
        first[queue[(begin + place) % len(queue)]] = -1


@njit(cache=True, nogil=True)
def take_back(times, causes, trail_events, trail_times, trail_causes, top, to):  # type: ignore[no-untyped-def]
    """Undo the trail down to `to`."""
    while top > to:
        top -= 1
        times[trail_events[top]] = trail_times[top]
        causes[trail_events[top]] = trail_causes[top]
    return top


@njit(cache=True)
def walk(event, causes, tails, offsets, robots):  # type: ignore[no-untyped-def]
    """The rows on an event's chain of causes, and whether the chain closes; then those of the cycle alone."""
    seen = np.full(len(causes), -1, np.int64)
    path = np.empty(len(causes), np.int64)
    length = 0
    while seen[event] < 0:
        seen[event] = length
        cause = causes[event]
        path[length] = cause
        length += 1
        if cause >= 0:
            event = tails[cause]
        elif event == offsets[robots[event]]:
            return path[:length][path[:length] >= 0], False
        else:
            event -= 1
    cycle = path[seen[event]:length]
    return cycle[cycle >= 0], True


@njit(cache=True)
def _misses(order, times, tails, heads, starts, margin):  # type: ignore[no-untyped-def]
    """Whether the times miss a row of an order."""
    for row in range(starts[order], starts[order + 1]):
        if times[tails[row]] + margin > times[heads[row]] + MISSED:
            return True
    return False


@njit(cache=True)
def _is_contested(window, times, tails, heads, starts, possible, sides, margin):  # type: ignore[no-untyped-def]
    """Whether a window is open and the times keep neither order."""
    return sides[window] < 0 and (
        not possible[window, 0] or _misses(2 * window, times, tails, heads, starts, margin)) and (
        not possible[window, 1] or _misses(2 * window + 1, times, tails, heads, starts, margin))


@njit(cache=True, nogil=True)
def kept(times, tails, heads, starts, possible, margin):  # type: ignore[no-untyped-def]
    """For each window and side whether the times keep all rows of that order."""
    found = np.zeros(possible.shape, np.bool_)
    for window in range(len(possible)):
        for side in range(2):
            found[window, side] = possible[window, side] and not _misses(2 * window + side, times, tails, heads, starts,
                                                                         margin)
    return found


@njit(cache=True, nogil=True)
def contested(times, tails, heads, starts, possible, sides, margin):  # type: ignore[no-untyped-def]
    """For each window whether it is open and the times keep neither order."""
    broken = np.zeros(len(sides), np.bool_)
    for window in range(len(sides)):
        broken[window] = _is_contested(window, times, tails, heads, starts, possible, sides, margin)
    return broken


@njit(cache=True)
def cost(times, goals, weights, longest):  # type: ignore[no-untyped-def]
    """The objective: weighted arrivals, or the last of them and, to break ties, a trace of the others."""
    total = 0.0
    latest = 0.0
    for robot in range(len(goals)):
        total += weights[robot] * times[goals[robot]]
        if weights[robot] > 0.0:
            latest = max(latest, times[goals[robot]])
    return latest + 1e-6 * total if longest else total


@njit(cache=True, nogil=True)
def dive(wanted, by_time, cap, longest, weights, goals, windows_of, window_starts,  # type: ignore[no-untyped-def]
         times, causes, floors, offsets, robots, fixed, latest,
         tails, heads, starts, outgoing, out_starts, owners, possible, sides, margin,
         first, last, queue, trail_events, trail_times, trail_causes, top):
    """Give the orders `wanted` (-1: none), those that can be; then, where the times keep none, the cheaper one.

    Returns the trail's top and the cost; infinite when a window has no order left or the cost reaches `cap`.
    """
    for window in by_time:
        if sides[window] < 0 <= wanted[window]:
            before = top
            top, bad = give(window, wanted[window], times, causes, floors, offsets, robots, fixed, latest, tails, heads,
                            starts, outgoing, out_starts, owners, sides, margin, first, last, queue,
                            trail_events, trail_times, trail_causes, top)
            if bad >= 0:
                sides[window] = -1
                top = take_back(times, causes, trail_events, trail_times, trail_causes, top, before)
    broken = contested(times, tails, heads, starts, possible, sides, margin)
    touched = np.zeros(len(goals), np.bool_)
    while True:
        chosen, soonest = -1, np.inf
        for window in range(len(sides)):
            if broken[window]:
                entry = _entry(window, times, heads, starts, possible)
                if entry < soonest:
                    chosen, soonest = window, entry
        if chosen < 0:
            return top, cost(times, goals, weights, longest)
        costs = np.full(2, np.inf)
        before = top
        for side in range(2):
            if possible[chosen, side]:
                top, bad = give(chosen, side, times, causes, floors, offsets, robots, fixed, latest, tails, heads,
                                starts, outgoing, out_starts, owners, sides, margin, first, last, queue,
                                trail_events, trail_times, trail_causes, top)
                if bad < 0:
                    costs[side] = cost(times, goals, weights, longest)
                sides[chosen] = -1
                top = take_back(times, causes, trail_events, trail_times, trail_causes, top, before)
        if costs.min() >= cap:
            return top, np.inf
        top, bad = give(chosen, 0 if costs[0] <= costs[1] else 1, times, causes, floors, offsets, robots, fixed, latest,
                        tails, heads, starts, outgoing, out_starts, owners, sides, margin, first, last, queue,
                        trail_events, trail_times, trail_causes, top)
        broken[chosen] = False
        touched[:] = False
        for place in range(before, top):
            touched[robots[trail_events[place]]] = True
        for robot in range(len(touched)):
            if touched[robot]:
                for place in range(window_starts[robot], window_starts[robot + 1]):
                    window = windows_of[place]
                    broken[window] = _is_contested(window, times, tails, heads, starts, possible, sides, margin)


@njit(cache=True)
def _entry(window, times, heads, starts, possible):  # type: ignore[no-untyped-def]
    """When the first of its robots is at a window."""
    entry = np.inf
    for side in range(2):
        if possible[window, side]:
            entry = min(entry, times[heads[starts[2 * window + side]]])
    return entry


@njit(cache=True)
def entries(times, heads, starts, possible):  # type: ignore[no-untyped-def]
    """When the first of its robots is at each window, as the times are."""
    found = np.empty(len(possible))
    for window in range(len(possible)):
        found[window] = _entry(window, times, heads, starts, possible)
    return found
