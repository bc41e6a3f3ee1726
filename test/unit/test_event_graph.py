"""Earliest times for given orders: against an independent Bellman-Ford; contradictions; how waits are spread."""

import math
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np
import pytest

from social_fleet.coordination.event_graph import EventGraph, Motion, Pace, Wait
from social_fleet.coordination.timing import Timing

MARGIN = 0.7


def motion(duration: float, depart: float = 0.0, fixed: bool = False) -> Motion:
    """A robot at 1 m/s."""
    return Motion(Timing(np.array([0.0, duration]), np.array([0.0, duration])), depart, fixed)


def wait(leader: int, clear: Sequence[float], follower: int, at: Sequence[float]) -> Wait:
    return Wait(leader, follower, np.array(at, dtype=float), np.array(clear, dtype=float))


def earliest(motions: Sequence[Motion], waits: Sequence[Wait], margin: float) -> Optional[List[Pace]]:
    """Every robot's pace at the least times that keep the waits; None when there are none."""
    graph = EventGraph(motions, [(each, None) for each in waits], margin)
    times, delay = graph.least_times(np.zeros(len(waits), dtype=np.int64))
    return graph.paces(times) if math.isfinite(delay) else None


def bellman_ford(motions: Sequence[Motion], waits: Sequence[Wait]) -> Optional[Dict[Tuple[int, float], float]]:
    """The least times by relaxing every difference until none changes; None when they never settle."""
    nodes = {(robot, moment) for robot, own in enumerate(motions) for moment in own.timing.times[[0, -1]].tolist()}
    rules = [((w.leader, clear), (w.follower, at), MARGIN) for w in waits for at, clear in zip(w.at, w.clear)]
    nodes |= {node for before, after, _ in rules for node in (before, after)}
    for robot in range(len(motions)):
        own = sorted(moment for index, moment in nodes if index == robot)
        rules += [((robot, low), (robot, high), high - low) for low, high in zip(own, own[1:])]
    floors = {(robot, moment): moment + motions[robot].depart for robot, moment in nodes}
    times = dict(floors)
    for _ in range(len(nodes) + 1):
        late = [(after, times[before] + span) for before, after, span in rules if times[before] + span > times[after]]
        if not late:
            held = [node for node in nodes if motions[node[0]].fixed and times[node] > floors[node] + 1e-6]
            return None if held else times
        for after, value in late:
            times[after] = max(times[after], value)
    return None


def random_case(rng: np.random.RandomState) -> Tuple[List[Motion], List[Wait]]:
    count = rng.randint(2, 6)
    motions = [motion(rng.uniform(5.0, 20.0), rng.uniform(0.0, 5.0)) for _ in range(count)]
    if rng.rand() < 0.3:
        motions[-1] = motion(rng.uniform(5.0, 20.0), fixed=True)
    waits = []
    for _ in range(rng.randint(1, 8)):
        leader, follower = rng.choice(count, 2, replace=False)
        rows = rng.randint(1, 5)
        ends = motions[leader].timing.duration, motions[follower].timing.duration
        clear, at = (np.sort(np.round(rng.uniform(0.0, end, rows), 1)) for end in ends)
        waits.append(Wait(int(leader), int(follower), at, clear))
    return motions, waits


@pytest.mark.parametrize("seed", range(60))
def test_random_waits_against_bellman_ford(seed: int) -> None:
    motions, waits = random_case(np.random.RandomState(seed))
    wanted, found = bellman_ford(motions, waits), earliest(motions, waits, MARGIN)
    assert (found is None) == (wanted is None)
    if found is None or wanted is None:
        return
    assert {(robot, moment) for robot, pace in enumerate(found) for moment in pace.moments} == set(wanted)
    for (robot, moment), time in wanted.items():
        assert found[robot].departure(np.array([moment]))[0] == pytest.approx(time, abs=1e-9)


def test_the_random_cases_hold_both_answers() -> None:
    answers = [bellman_ford(*random_case(np.random.RandomState(seed))) is None for seed in range(60)]
    assert 10 < sum(answers) < 50


def test_nobody_waits_without_need() -> None:
    alone, = earliest([motion(10.0, depart=3.0)], [], MARGIN) or []
    assert (alone.leave[0], alone.leave[-1]) == (3.0, 13.0)


def test_two_that_wait_for_each_other() -> None:
    pair = [motion(10.0), motion(10.0)]
    assert earliest(pair, [wait(0, [6.0], 1, [4.0]), wait(1, [6.0], 0, [4.0])], MARGIN) is None
    assert earliest(pair, [wait(0, [4.0], 1, [4.0]), wait(1, [6.0], 0, [6.0])], MARGIN) is not None


def test_a_fixed_robot_is_waited_for_and_never_waits() -> None:
    fleet = [motion(10.0), motion(10.0, fixed=True)]
    found = earliest(fleet, [wait(1, [8.0], 0, [2.0])], MARGIN)
    assert found is not None and found[0].leave.tolist() == pytest.approx([0.0, 8.7, 16.7])
    assert earliest(fleet, [wait(0, [2.0], 1, [2.7])], MARGIN) is not None, "in time"
    assert earliest(fleet, [wait(0, [2.0], 1, [2.6])], MARGIN) is None


def test_a_short_delay_is_driven_slower_a_long_one_is_waited_standing() -> None:
    pace = Pace(np.array([0.0, 10.0, 20.0, 30.0]), np.array([5.0, 20.0, 50.0, 60.0]))
    asked = np.array([0.0, 4.0, 10.0, 15.0, 20.0, 25.0, 30.0])
    assert pace.arrival(asked).tolist() == [5.0, 11.0, 20.0, 25.0, 30.0, 55.0, 60.0]
    assert pace.departure(asked).tolist() == [5.0, 11.0, 20.0, 25.0, 50.0, 55.0, 60.0]


@pytest.mark.parametrize("seed", range(20))
def test_knots_show_every_event_and_never_hurry(seed: int) -> None:
    rng = np.random.RandomState(seed)
    times = np.cumsum(np.append(0.0, rng.uniform(0.01, 1.0, 20)))
    arcs = np.cumsum(np.append(0.0, rng.choice([0.0, 0.1, 0.1], 20)))
    moments = np.unique(np.append(rng.choice(times, 4), rng.uniform(0.0, times[-1], 4)))
    moments = np.unique(np.concatenate((times[[0, -1]], moments)))
    leave = 3.0 + np.cumsum(np.append(0.0, np.diff(moments) + rng.choice([0.0, 0.1, 9.0], len(moments) - 1)))
    pace = Pace(moments, leave)
    knots, clock = pace.knots(Timing(arcs, times))
    assert (np.diff(clock) > 0.0).all() and (np.diff(knots) >= 0.0).all()
    assert knots[0] == 0.0 and knots[-1] == arcs[-1]
    assert (clock[0], clock[-1]) == pytest.approx((leave[0], leave[-1])), "a wait at the end is kept"
    at = np.interp(moments, times, arcs)
    assert np.interp(pace.departure(moments), clock, knots) == pytest.approx(at)
    assert np.interp(pace.arrival(moments), clock, knots) == pytest.approx(at)
    fastest = (np.diff(arcs) / np.diff(times)).max()
    assert (np.diff(knots) / np.diff(clock)).max() <= fastest + 1e-6
