"""The exact program: against every order tried, on either solver, with contradictory orders, and on the clock."""

import itertools
import math
import time
from dataclasses import replace
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np
import pytest
from fleets import random_path, robot

from social_fleet.coordination import delay_program
from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.encounters import Encounter, EncounterFinder, Order
from social_fleet.coordination.event_graph import Motion
from social_fleet.coordination.order_search import Contradiction, OrderSearch
from social_fleet.coordination.program import ExactProgram, Solution
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.timing import nominal_timing
from social_fleet.coordination.verification import verify
from social_fleet.errors import TimedOut

MARGIN = 1.0
REACHED, LEFT = 0, 1
Event = Tuple[int, float, int]
"""Robot, moment of its nominal motion [s], and whether it comes there or goes on."""


def prepared(fleet: Sequence[Robot]) -> Tuple[List[Motion], List[Encounter]]:
    return ([Motion(nominal_timing(body.path, body.limits), body.depart) for body in fleet],
            EncounterFinder(0.1).find(fleet))


def solved(motions: Sequence[Motion], encounters: Sequence[Encounter], solver: Optional[str] = None) -> Solution:
    return ExactProgram(motions, encounters, margin=MARGIN, solver=solver).solve(deadline=time.monotonic() + 20.0)


def completion(motions: Sequence[Motion], orders: Sequence[Order]) -> float:
    """Sum of the earliest arrivals under some orders; infinite on a cycle."""
    times = earliest_arrivals(motions, orders)
    return math.inf if times is None else float(times.sum())


def earliest_arrivals(motions: Sequence[Motion], orders: Sequence[Order]) -> Optional[np.ndarray]:
    """The earliest arrivals under some orders, by relaxing until nothing changes; None on a cycle."""
    times: Dict[Event, float] = {}
    rules: List[Tuple[Event, Event, float]] = []
    for order in orders:
        left = motions[order.follower].timing.last_time(order.at)
        reached = motions[order.leader].timing.first_time(order.clear)
        rules += [((order.leader, there, REACHED), (order.follower, here, LEFT), MARGIN)
                  for here, there in zip(left.tolist(), reached.tolist())]
    for index, own in enumerate(motions):
        events = {(index, 0.0, REACHED), (index, own.timing.duration, LEFT)}
        events |= {event for rule in rules for event in rule[:2] if event[0] == index}
        times.update({event: event[1] + own.depart for event in events})
        rules += [(before, after, after[1] - before[1]) for before, after in zip(sorted(events), sorted(events)[1:])]
    for _ in range(len(times) + 1):
        changed = False
        for before, after, span in rules:
            if times[before] + span > times[after] + 1e-12:
                times[after], changed = times[before] + span, True
        if not changed:
            return np.array([times[index, own.timing.duration, LEFT] for index, own in enumerate(motions)])
    return None


def cheapest(motions: Sequence[Motion], encounters: Sequence[Encounter]) -> float:
    """The best of all orders of all windows."""
    choices = [[order for order in encounter.orders if order.possible] for encounter in encounters]
    return min((completion(motions, orders) for orders in itertools.product(*choices)), default=math.inf)


def small_fleet(seed: int) -> List[Robot]:
    """2-4 robots in a room that they cross and re-cross, ends apart."""
    rng = np.random.RandomState(seed)
    while True:
        fleet = [robot(f"robot_{index}", *random_path(rng, rng.randint(2, 5), 6.0), max_speed=rng.uniform(0.2, 1.2),
                       radius=rng.uniform(0.2, 0.4), depart=rng.choice([0.0, 4.0]))
                 for index in range(rng.randint(2, 5))]
        ends = [[body.path.points[end] for body in fleet] for end in (0, -1)]
        apart = min(np.hypot(*(a - b)) for points in ends for a, b in itertools.combinations(points, 2))
        if apart > 1.0 and 1 <= len(EncounterFinder(0.1).find(fleet)) <= 6:
            return fleet


@pytest.mark.parametrize("seed", range(200))
def test_the_objective_is_the_best_of_all_orders(seed: int) -> None:
    motions, encounters = prepared(small_fleet(seed))
    best = cheapest(motions, encounters)
    if math.isinf(best):
        with pytest.raises(Contradiction):
            solved(motions, encounters)
        return
    solution = solved(motions, encounters)
    assert solution.objective == pytest.approx(best, abs=1e-6)
    assert solution.bound == pytest.approx(best, abs=1e-3)
    assert completion(motions, solution.orders) == pytest.approx(solution.objective, abs=1e-6)


def arrivals(motions: Sequence[Motion], solution: Solution) -> np.ndarray:
    return np.array([pace.leave[-1] for pace in solution.paces])


@pytest.mark.parametrize("seed", range(40))
def test_weights_and_the_makespan_are_minimised_as_well(seed: int) -> None:
    fleet = small_fleet(seed)
    weights = np.random.RandomState(seed).uniform(0.2, 5.0, len(fleet))
    plain, encounters = prepared(fleet)
    motions = [replace(motion, weight=weight) for motion, weight in zip(plain, weights)]
    choices = [[order for order in encounter.orders if order.possible] for encounter in encounters]
    all_times = [times for times in (earliest_arrivals(motions, orders) for orders in itertools.product(*choices))
                 if times is not None]
    if not all_times:
        return
    weighted = ExactProgram(motions, encounters, margin=MARGIN).solve(deadline=time.monotonic() + 20.0)
    assert weighted.objective == pytest.approx(min(weights @ times for times in all_times), abs=1e-5)
    shortest = ExactProgram(motions, encounters, margin=MARGIN, makespan=True).solve(deadline=time.monotonic() + 20.0)
    assert shortest.objective == pytest.approx(min(times.max() for times in all_times), abs=1e-5)
    assert shortest.bound == pytest.approx(shortest.objective, abs=1e-3)
    assert arrivals(motions, shortest).max() == pytest.approx(shortest.objective)


@pytest.mark.parametrize("scale", [1e-12, 1e12])
@pytest.mark.parametrize("seed", range(30))
def test_only_the_ratio_of_weights_counts(seed: int, scale: float) -> None:
    fleet = small_fleet(seed)
    weights = np.random.RandomState(seed).uniform(0.2, 5.0, len(fleet))
    plain, encounters = prepared(fleet)
    for makespan in (False, True):
        found = []
        for factor in (1.0, scale):
            motions = [replace(motion, weight=weight * factor) for motion, weight in zip(plain, weights)]
            program = ExactProgram(motions, encounters, margin=MARGIN, makespan=makespan)
            try:
                solution = program.solve(deadline=time.monotonic() + 20.0)
            except Contradiction:
                return
            unit = 1.0 if makespan else factor
            found.append((solution.objective / unit, solution.bound / unit))
        assert found[1] == pytest.approx(found[0], rel=1e-5)


def test_the_small_fleets_are_worth_trying() -> None:
    bests, freely = [], []
    for seed in range(60):
        motions, encounters = prepared(small_fleet(seed))
        bests.append(cheapest(motions, encounters))
        freely.append(completion(motions, []))
    waited = np.array(bests) > np.array(freely) + 0.1
    assert 20 < (waited & np.isfinite(bests)).sum() and 3 < np.isinf(bests).sum() < 40


@pytest.mark.parametrize("seed", range(0, 30, 3))
def test_cbc_agrees(seed: int) -> None:
    motions, encounters = prepared(small_fleet(seed))
    if not math.isinf(cheapest(motions, encounters)):
        assert solved(motions, encounters, "cbc").objective == pytest.approx(
            solved(motions, encounters).objective, abs=1e-6)


@pytest.mark.parametrize("fast, slow", [("robot_1", "robot_2"), ("robot_2", "robot_1")])
def test_the_fast_one_goes_first_whatever_its_number(fast: str, slow: str) -> None:
    fleet = coordinate([robot(slow, (-4, 0), (4, 0), max_speed=0.2), robot(fast, (0, -4), (0, 4), max_speed=1.0)])
    assert [window.first for window in fleet.windows] == [fast]
    late = coordinate([robot(slow, (-4, 0), (4, 0), max_speed=0.2),
                       robot(fast, (0, -4), (0, 4), max_speed=1.0, depart=40.0)])
    assert [window.first for window in late.windows] == [slow], "unless it comes late"


def test_a_contradiction_is_a_smallest_one() -> None:
    """Three that start on one another's way round a triangle too small to turn in; a fourth crosses without harm."""
    corners = np.array([(0.0, 0.0), (1.0, 0.0), (0.5, math.sqrt(0.75))])
    exits = np.array([(-3.0, -1.0), (4.0, -1.0), (0.5, 4.0)])
    fleet = [robot(name, corners[k], corners[(k + 1) % 3], exits[(k + 1) % 3]) for k, name in enumerate("abc")]
    fleet.append(robot("d", (-2, 2.5), (3, 2.5)))
    motions, encounters = prepared(fleet)
    with pytest.raises(Contradiction) as caught:
        solved(motions, encounters)
    pairs = sorted((encounters[window].r, encounters[window].s) for window in caught.value.windows)
    assert pairs == [(0, 1), (0, 2), (1, 2)]


def test_windows_that_do_not_bind_need_no_solver(monkeypatch: pytest.MonkeyPatch) -> None:
    def forbidden(*_: object, **__: object) -> None:
        raise AssertionError("the solver was called")
    monkeypatch.setattr(delay_program, "solve", forbidden)
    motions, encounters = prepared([robot("a", (-4, 0), (4, 0)), robot("b", (0, -9), (0, 9))])
    solution = solved(motions, encounters)
    assert len(encounters) == 1
    assert solution.objective == solution.bound == pytest.approx(sum(own.timing.duration for own in motions))


def test_stopped_early_the_best_so_far_is_given_with_its_gap(monkeypatch: pytest.MonkeyPatch) -> None:
    def too_slow(*_: object, **__: object) -> float:
        raise TimedOut("not in time")
    motions, encounters = prepared([robot("a", (-4, 0), (4, 0)), robot("b", (0, -4), (0, 4))])
    proven = solved(motions, encounters)
    monkeypatch.setattr(delay_program, "solve", too_slow)
    stopped = solved(motions, encounters)
    assert stopped.objective == pytest.approx(proven.objective)
    assert stopped.bound == pytest.approx(sum(own.timing.duration for own in motions)), "all that is known"
    assert stopped.bound < stopped.objective - 1.0


def test_a_schedule_that_is_known_is_not_lost_when_time_runs_out() -> None:
    """Two columns that cross: quickly ordered, hardly ever proven."""
    fleet = [robot(f"east_{k:02d}", (-5 - 2 * k, 0), (60 - 2 * k, 0), max_speed=0.4 + 0.05 * (k % 7))
             for k in range(15)]
    fleet += [robot(f"north_{k:02d}", (10, -5 - 2 * k), (10, 60 - 2 * k), max_speed=0.4 + 0.05 * (k % 5))
              for k in range(15)]
    begun = time.monotonic()
    found = coordinate(fleet, time_limit=2.0)
    assert time.monotonic() - begun < 60.0
    assert found.gap > 1e-3 and all(window.first for window in found.windows)
    assert verify(found).min_clearance >= 0.2 - 1e-6


def test_however_great_the_effort_it_ends_with_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = []

    def until_the_deadline(search: OrderSearch, rounds: int, *, gap: float, deadline: float) -> None:
        tried.append(rounds)
        improve(search, 1, gap=gap, deadline=math.inf)
        while rounds > 1 and time.monotonic() <= deadline:
            pass
    improve = OrderSearch.improve
    monkeypatch.setattr(OrderSearch, "improve", until_the_deadline)
    monkeypatch.setattr(OrderSearch, "prove", lambda *_, **__: None)
    motions, encounters = prepared([robot("a", (-4, 0), (4, 0)), robot("b", (0, -4), (0, 4))])
    ExactProgram(motions, encounters, margin=MARGIN, effort=100).solve(deadline=time.monotonic() + 0.5)
    assert len(tried) <= 2


def test_past_its_deadline_it_says_so() -> None:
    motions, encounters = prepared([robot("a", (-4, 0), (4, 0)), robot("b", (0, -4), (0, 4))])
    with pytest.raises(TimedOut):
        ExactProgram(motions, encounters, margin=MARGIN).solve(deadline=time.monotonic() - 1.0)
