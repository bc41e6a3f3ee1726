"""The judge: closed forms, near-misses planted on purpose, standing robots, and dense sampling both ways."""

import math

import numpy as np
import pytest
from fleets import random_path, robot, smallest_distance

from social_fleet.coordination.schedule import FleetSchedule, Schedule
from social_fleet.coordination.verification import verify


def schedule(name: str, points: list, times: list, radius: float = 0.25) -> Schedule:
    """A motion that is at each vertex of its path at the given time [s]."""
    body = robot(name, *points, radius=radius)
    return Schedule(body, body.path.arc_lengths, np.array(times, dtype=float))


def test_a_right_angle_in_closed_form() -> None:
    """Both at 1 m/s; s passes the crossing 1 s after r: nearest at sqrt(1/2) m, half way between."""
    r = schedule("r", [(-5, 0), (5, 0)], [0, 10])
    s = schedule("s", [(0, -6), (0, 4)], [0, 10])
    (first, second, clearance, when), = verify([r, s]).pairs
    assert (first, second) == ("r", "s")
    assert clearance == pytest.approx(math.sqrt(0.5) - 0.5, abs=1e-12)
    assert when == pytest.approx(5.5)


@pytest.mark.parametrize("gap, safe", [(0.51, True), (0.4999, False)])
def test_passing_side_by_side(gap: float, safe: bool) -> None:
    r = schedule("r", [(0, 0), (10, 0)], [0, 10])
    s = schedule("s", [(10, gap), (0, gap)], [0, 10])
    report = verify([r, s])
    assert report.safe is safe
    assert report.min_clearance == pytest.approx(gap - 0.5, abs=1e-12)


def test_a_touch_between_two_samples_is_found() -> None:
    """Head-on at 100 m/s each: a millisecond of contact in the middle of one long interval."""
    r = schedule("r", [(0, 0), (1000, 0)], [0, 10])
    s = schedule("s", [(1000, 0.1), (0, 0.1)], [0, 10])
    assert verify([r, s]).min_clearance == pytest.approx(-0.4)


def test_standing_before_the_first_knot_and_after_the_last() -> None:
    parked = schedule("parked", [(5, 0), (5, 9)], [100, 110])
    passing = schedule("passing", [(0, 0), (10, 0)], [0, 10])
    assert verify([parked, passing]).pairs[0][2:] == pytest.approx((-0.5, 5.0)), "not gone yet"
    arrived = schedule("arrived", [(5, 9), (5, 0)], [-20, -10])
    assert verify([arrived, passing]).min_clearance == pytest.approx(-0.5), "there for ever"
    gone = schedule("gone", [(5, 0), (5, 9)], [-20, -10])
    assert verify([gone, passing]).min_clearance > 3.0, "gone in time"


def test_one_start_for_two_is_never_safe() -> None:
    r = schedule("r", [(0, 0), (5, 0)], [0, 5])
    s = schedule("s", [(0, 0), (0, 5)], [50, 55])
    assert verify([r, s]).min_clearance == pytest.approx(-0.5)


def test_a_wait_is_standing() -> None:
    body = robot("r", (0, 0), (10, 0))
    waiting = Schedule(body, np.array([0.0, 4.0, 4.0, 10.0]), np.array([0.0, 4.0, 20.0, 26.0]))
    assert verify([waiting, schedule("s", [(5, -5), (5, 5)], [5, 15])]).min_clearance == pytest.approx(0.5)
    assert verify([waiting, schedule("s", [(5, -5), (5, 5)], [16, 26])]).min_clearance < 0.0


def test_vertices_within_one_interval_are_followed() -> None:
    """One knot at each end of a path with two corners: it is not a straight line."""
    body = robot("r", (0, 0), (0, 4), (4, 4), (4, 0))
    round_it = Schedule(body, np.array([0.0, 12.0]), np.array([0.0, 12.0]))
    assert verify([round_it, schedule("s", [(2, 0)], [0])]).min_clearance == pytest.approx(1.5)
    assert verify([round_it, schedule("s", [(2, 4)], [0])]).min_clearance == pytest.approx(-0.5)


def test_worst_pairs_come_first_and_radii_count() -> None:
    fleet = FleetSchedule((schedule("a", [(0, 0)], [0], 0.2), schedule("b", [(1, 0)], [0], 0.3),
                           schedule("c", [(1, 2)], [0], 0.4)))
    report = verify(fleet)
    assert [pair[:2] for pair in report.pairs] == [("a", "b"), ("b", "c"), ("a", "c")]
    assert [pair[2] for pair in report.pairs] == pytest.approx([0.5, 1.3, math.sqrt(5.0) - 0.6])
    assert report.safe and report.min_clearance == pytest.approx(0.5)
    assert verify([]).min_clearance == verify(fleet.schedules[:1]).min_clearance == math.inf


@pytest.mark.parametrize("seed", range(25))
def test_random_motions_against_dense_sampling(seed: int) -> None:
    rng = np.random.RandomState(seed)
    pair = []
    for name in "rs":
        body = robot(name, *random_path(rng, 6, 5.0), radius=rng.uniform(0.2, 0.4))
        arcs = np.append(0.0, np.sort(rng.choice([0.0, 0.3, 0.3, 0.7, 1.0], 6))) * body.path.length
        arcs[-1] = body.path.length
        pair.append(Schedule(body, arcs, np.cumsum(rng.uniform(0.1, 4.0, len(arcs))) - 3.0))
    sampled = smallest_distance(pair[0], pair[1], step=0.002)
    fastest = max((np.diff(one.arc_lengths) / np.diff(one.times)).max() for one in pair)
    exact = verify(pair).min_clearance + sum(one.robot.body_radius for one in pair)
    assert exact <= sampled + 1e-9, "nothing is closer than what the judge found"
    assert exact >= sampled - 2.0 * fastest * 0.002, "and it is really there"
    when = verify(pair).pairs[0][3]
    assert np.hypot(*(pair[0].position(when) - pair[1].position(when))) == pytest.approx(exact, abs=1e-9)
