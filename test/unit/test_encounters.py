"""Encounter windows: kinds and extents by hand; what either order asks for, against random motions."""

from typing import Callable, List, Optional, Tuple

import numpy as np
import pytest
from fleets import random_path, robot

from social_fleet.coordination.conflict_regions import LINK
from social_fleet.coordination.encounters import (Encounter, EncounterFinder, Order, contradiction, forced_reasons)
from social_fleet.coordination.robot import Robot

STAIR = 0.5  # how much more than is needed an order may ask for, besides a link [m]


def windows(*robots: Robot, fixed: int = 0) -> List[Encounter]:
    return EncounterFinder(0.1).find(robots, fixed=fixed)


def test_a_crossing() -> None:
    found, = windows(robot("r", (-5, 0), (5, 0)), robot("s", (0, -5), (0, 5)))
    assert found.kind == "intersection"
    assert found.r_extent == pytest.approx((4.3, 5.7)) and found.s_extent == pytest.approx((4.3, 5.7))
    assert found.r_ends == found.s_ends == (False, False)
    assert found.r_first.at[0] == pytest.approx(found.s_extent[0])
    assert found.r_first.clear[-1] == pytest.approx(found.r_extent[1])
    assert (found.r_first.leader, found.r_first.follower, found.s_first.leader) == (0, 1, 1)
    assert contradiction(found, [robot("r", (0, 0)), robot("s", (0, 0))]) is None


def test_a_shared_lane_is_followed_at_a_distance() -> None:
    found, = windows(robot("r", (0, 0), (20, 0)), robot("s", (-5, 0), (18, 0)))
    assert found.kind == "same_direction"
    order = found.r_first
    apart = (order.clear - (order.at - 5.0))[:-1]
    assert apart.min() >= 0.7 - 1e-9 and apart.max() <= 0.7 + STAIR + 2.0 * LINK + 1e-9
    assert (np.diff(order.at) > 0.0).all() and (np.diff(order.clear) > 0.0).all()
    assert not found.s_first.possible, "s would have to pass r at r's start"
    assert order.possible and found.r_ends == (True, False) and found.s_ends == (False, True)


def test_a_corridor_head_on_is_cleared_before_it_is_entered() -> None:
    found, = windows(robot("r", (0, 3), (0, 0), (9, 0), (9, -3)), robot("s", (9, 3), (9, 0), (0, 0), (0, -3)))
    assert found.kind == "opposite_direction"
    for order in found.orders:
        assert order.possible and len(order.at) <= 2, "next to all of it at once"
    assert found.r_first.clear[0] > 11.5


@pytest.mark.parametrize("name, r, s, kinds", [
    ("lanes side by side", [(0, 0), (20, 0)], [(20, 0.7), (0, 0.7)], []),
    ("lanes that are too close", [(0, 0), (20, 0)], [(20, 0.69), (0, 0.69)], ["opposite_direction"]),
    ("a place crossed twice", [(-5, 0), (5, 0)], [(0, -3), (0, 3), (0.1, -3)], ["intersection"] * 2),
    ("neither short nor monotone", [(-5, 0), (5, 0)], [(-3, 3), (-3, 0), (3, 0), (-2, 0.1), (-2, 3)],
     ["intersection"]),
    ("there and most of the way back", [(0, 0), (12, 0)], [(1, 3), (1, 0), (10, 0), (3, 0.1), (3, 3)],
     ["intersection"]),
    ("along a corner", [(0, 0), (9, 0), (9, 9)], [(3, -3), (3, 0), (9, 0), (9, 5), (15, 5)], ["same_direction"]),
    ("into the lane and out again", [(0, 0), (20, 0)], [(5, 3), (5, 0), (15, 0), (15, 3)], ["same_direction"]),
    ("far away", [(0, 0), (20, 0)], [(0, 9), (20, 9)], [])])
def test_kinds_by_hand(name: str, r: list, s: list, kinds: List[str]) -> None:
    assert [found.kind for found in windows(robot("r", *r), robot("s", *s))] == kinds, name


@pytest.mark.parametrize("r, s, possible, reasons", [
    ([(0, 0), (9, 0)], [(4, 0), (4, 5)], (False, True), ["s starts in the way of r"]),
    ([(0, 0), (9, 0)], [(4, 5), (4, 0)], (True, False), ["s ends in the way of r"]),
    ([(4, 0), (4, 5)], [(0, 0), (9, 0)], (True, False), ["r starts in the way of s"]),
    ([(4, 5), (4, 0)], [(0, 0), (9, 0)], (False, True), ["r ends in the way of s"]),
    ([(0, 0), (9, 0)], [(4, 0)], (False, False), ["s starts in the way of r", "s ends in the way of r"])])
def test_ends_decide_the_order(r: list, s: list, possible: Tuple[bool, bool], reasons: List[str]) -> None:
    fleet = [robot("r", *r), robot("s", *s)]
    found, = windows(*fleet)
    assert (found.r_first.possible, found.s_first.possible) == possible
    assert forced_reasons(found, fleet) == reasons
    assert contradiction(found, fleet) == (None if any(possible) else " and ".join(reasons))


def test_fixed_pairs_are_left_out_and_changed_robots_are_looked_at_again() -> None:
    finder = EncounterFinder(0.1)
    r, s, t = (robot(name, *path) for name, path in zip(
        "rst", ([(-5, 0), (5, 0)], [(0, -5), (0, 5)], [(1, -5), (1, 5)])))
    assert [(found.r, found.s) for found in finder.find([r, s, t])] == [(0, 1), (0, 2)]
    assert finder.find([t, r, s], fixed=2)[0].s == 1 and len(finder.find([t, r, s], fixed=2)) == 1
    assert finder.find([robot("r", (-5, 9), (5, 9)), s, t]) == []


def drive(found: List[Encounter], lengths: Tuple[float, float], sides: List[int], rng: np.random.RandomState,
          watch: Callable[[float, float], None]) -> bool:
    """A random joint motion that obeys the chosen orders; whether both arrived."""
    arcs = np.zeros(2)
    orders = [encounter.orders[side] for encounter, side in zip(found, sides)]
    stuck = 0
    while (arcs < lengths).any() and stuck < 40:
        mover = rng.randint(2)
        goal = min(arcs[mover] + rng.exponential(0.3), lengths[mover])
        goal = min([goal] + [bound(order, arcs) for order in orders if order.follower == mover])
        stuck = stuck + 1 if goal <= arcs[mover] else 0
        for step in np.arange(arcs[mover], goal, 0.02).tolist() + [max(goal, arcs[mover])]:
            arcs[mover] = step
            watch(arcs[0], arcs[1])
    return bool((arcs >= lengths).all())


def bound(order: Order, arcs: np.ndarray) -> float:
    """How far the follower may go now."""
    waits = order.at[order.clear > arcs[order.leader]]
    return float(waits[0]) if len(waits) else np.inf


@pytest.mark.parametrize("seed", range(40))
def test_whoever_obeys_the_orders_stays_apart_at_any_speed(seed: int) -> None:
    rng = np.random.RandomState(seed)
    for _ in range(3):
        r, s = (robot(name, *random_path(rng, rng.randint(2, 7), 5.0)) for name in "rs")
        found = windows(r, s)
        choices = [[side for side in (0, 1) if encounter.orders[side].possible] for encounter in found]
        if not all(choices):
            continue
        sides = [int(rng.choice(options)) for options in choices]

        def watch(r_arc: float, s_arc: float) -> None:
            gap = np.hypot(*(r.path.position(r_arc) - s.path.position(s_arc)))
            assert gap >= 0.7 - 1e-9, (r.path.points.tolist(), s.path.points.tolist(), sides, r_arc, s_arc)
        drive(found, (r.path.length, s.path.length), sides, rng, watch)


def clean_motion(r: Robot, s: Robot, distance: float, rng: np.random.RandomState) -> Optional[np.ndarray]:
    """A random monotone joint motion (M, 2) [m] that keeps the distance; None when there is none."""
    arcs = [np.linspace(0.0, body.path.length, int(body.path.length / 0.05) + 2) for body in (r, s)]
    gaps = r.path.position(arcs[0])[:, None] - s.path.position(arcs[1])[None]
    free = np.hypot(gaps[..., 0], gaps[..., 1]) >= distance
    leads_on = np.zeros_like(free)
    for i, j in np.ndindex(free.shape):
        i, j = free.shape[0] - 1 - i, free.shape[1] - 1 - j
        last = (i, j) == (free.shape[0] - 1, free.shape[1] - 1)
        leads_on[i, j] = free[i, j] and (last or leads_on[i + 1:i + 2, j].any() or leads_on[i, j + 1:j + 2].any())
    i = j = 0
    motion = [(0, 0)]
    while leads_on[0, 0] and (i, j) != (free.shape[0] - 1, free.shape[1] - 1):
        onward = [(a, b) for a, b in ((i + 1, j), (i, j + 1))
                  if a < free.shape[0] and b < free.shape[1] and leads_on[a, b]]
        i, j = onward[rng.randint(len(onward))]
        motion.append((i, j))
    return np.array([(arcs[0][a], arcs[1][b]) for a, b in motion]) if leads_on[0, 0] else None


@pytest.mark.parametrize("seed", range(30))
def test_a_motion_that_keeps_apart_is_hardly_ever_asked_to_wait(seed: int) -> None:
    rng = np.random.RandomState(100 + seed)
    r, s = (robot(name, *random_path(rng, rng.randint(2, 5), 4.0)) for name in "rs")
    motion = clean_motion(r, s, 0.75, rng)
    if motion is None:
        return
    for encounter in windows(r, s):
        kept = []
        for order in encounter.orders:
            follower, leader = motion[:, order.follower], motion[:, order.leader]
            led = [leader[follower >= min(at + LINK, follower[-1])].min() for at in order.at]
            kept.append(order.possible and (np.array(led) >= order.clear - STAIR - LINK - 1e-9).all())
        assert any(kept), (r.path.points.tolist(), s.path.points.tolist())
