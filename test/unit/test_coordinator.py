"""Whole fleets: who goes first and why, what is refused, and that nobody ever touches."""

import itertools
from dataclasses import replace
from typing import Dict, List, Sequence, Tuple

import networkx
import numpy as np
import pytest
from fleets import robot, smallest_distance, street_fleet

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import FleetSchedule, Schedule
from social_fleet.coordination.timing import nominal_timing
from social_fleet.coordination.verification import verify
from social_fleet.errors import Infeasible, InvalidScenario, TimedOut
from social_fleet.scenario.closed_loop import simulate
from social_fleet.simulation.faults import Fault

CROSSING = [robot("a", (-4, 0), (4, 0)), robot("b", (0, -4), (0, 4))]
KEPT = 0.2 - 1e-6  # clearance that the default tracking tolerance leaves [m]


def alone(body: Robot) -> float:
    """Arrival of a robot that nobody hinders [s]."""
    return body.depart + nominal_timing(body.path, body.limits, start_yaw=body.start_yaw,
                                        goal_yaw=body.goal_yaw).duration


def firsts(fleet: FleetSchedule) -> List[Tuple[str, str]]:
    return [(window.kind, window.first) for window in fleet.windows]


def check_orders(schedules: Sequence[Schedule], margin: float) -> None:
    """Every wait is kept by the times, and the waits have an order without a cycle."""
    by_name = {schedule.name: schedule for schedule in schedules}
    graph = networkx.DiGraph()
    for schedule in schedules:
        assert list(schedule.precedences) == sorted(schedule.precedences, key=lambda rule: rule.at)
        events = {(rule.at, 1) for rule in schedule.precedences}
        events |= {(rule.other_at, 0) for other in schedules for rule in other.precedences
                   if rule.other == schedule.name}
        own = sorted(events)
        graph.add_edges_from(((schedule.name, a), (schedule.name, b)) for a, b in zip(own, own[1:]))
        for rule in schedule.precedences:
            graph.add_edge((rule.other, (rule.other_at, 0)), (schedule.name, (rule.at, 1)))
            other = by_name[rule.other]
            cleared = other.times[np.searchsorted(other.arc_lengths, rule.other_at - 1e-6)]
            cleared = min(cleared, np.interp(rule.other_at - 1e-6, *_rising(other)))
            assert schedule.arc_length(cleared + margin - 1e-3) <= rule.at + 1e-5, (schedule.name, rule)
    assert networkx.is_directed_acyclic_graph(graph)


def _rising(schedule: Schedule) -> Tuple[np.ndarray, np.ndarray]:
    """Knots with every wait widened by a hair, so that times can be looked up by arc length."""
    return schedule.arc_lengths + 1e-9 * np.arange(len(schedule.arc_lengths)), schedule.times


def test_one_robot_drives_as_if_alone() -> None:
    only = robot("a", (0, 0), (5, 0), (5, 5), start_yaw=1.0, depart=3.0)
    fleet = coordinate([only])
    assert fleet.objective == pytest.approx(alone(only)) and fleet.gap == 0.0
    assert fleet["a"].times[0] == 3.0 and fleet["a"].arc_lengths[-1] == only.path.length
    assert fleet.windows == () and fleet["a"].precedences == ()


def test_robots_that_stay_where_they_are() -> None:
    fleet = coordinate([robot("a", (0, 0)), robot("b", (3, 0), (3, 0))])
    assert (fleet.objective, fleet.gap, fleet.makespan) == (0.0, 0.0, 0.0)
    assert verify(fleet).min_clearance == pytest.approx(2.5)


def test_one_of_two_waits_at_a_crossing() -> None:
    fleet = coordinate(CROSSING)
    assert len(fleet.windows) == 1 and fleet.windows[0].first in ("a", "b")
    arrivals = sorted(schedule.arrival_time for schedule in fleet.schedules)
    assert arrivals[0] == pytest.approx(alone(CROSSING[0])) and arrivals[1] < arrivals[0] + 4.0
    assert fleet.objective == pytest.approx(sum(arrivals)) and fleet.gap < 1e-6
    assert verify(fleet).min_clearance >= KEPT
    check_orders(fleet.schedules, 1.0)


def test_in_one_lane_the_slow_one_ahead_is_followed() -> None:
    fleet = coordinate([robot("slow", (0, 0), (12, 0), max_speed=0.2), robot("fast", (-2, 0), (10, 0))])
    assert firsts(fleet) == [("same_direction", "slow")]
    assert verify(fleet).min_clearance >= KEPT
    assert fleet["slow"].arrival_time == pytest.approx(alone(fleet["slow"].robot))


def test_overtaking_where_the_slow_one_leaves_the_lane() -> None:
    """Both use 4 m of the lane; the slow one comes from the side, later: it lets the fast one by."""
    fleet = coordinate([robot("slow", (3, -3), (3, 0), (7, 0), (7, -3), max_speed=0.2),
                        robot("fast", (0, 0), (12, 0), max_speed=1.0)])
    assert firsts(fleet) == [("same_direction", "fast")]
    assert fleet["slow"].arrival_time == pytest.approx(alone(fleet["slow"].robot)), "it is there first anyway"


def test_lanes_side_by_side_hinder_nobody() -> None:
    fleet = coordinate([robot("a", (0, 0), (20, 0)), robot("b", (20, 0.75), (0, 0.75))])
    assert fleet.windows == () and fleet.gap == 0.0


@pytest.mark.parametrize("r, s, first", [
    ([(0, 0), (9, 0)], [(4, 0), (4, 5)], "s"), ([(0, 0), (9, 0)], [(4, 5), (4, 0)], "r"),
    ([(4, 0), (4, 5)], [(0, 0), (9, 0)], "r"), ([(0, 0), (4, 0)], [(4, 0.6), (4, 5)], "s")])
def test_a_start_or_a_goal_in_the_way_decides(r: list, s: list, first: str) -> None:
    fleet = coordinate([robot("r", *r), robot("s", *s)])
    assert [one for _, one in firsts(fleet)] == [first]
    assert verify(fleet).min_clearance >= KEPT
    check_orders(fleet.schedules, 1.0)


@pytest.mark.parametrize("r, s", [
    ([(0, 0), (9, 0)], [(4, 0), (-5, 0)]), ([(0, 0), (9, 0)], [(9, 0), (0, 0)]), ([(0, 0), (9, 0)], [(4, 0)])])
def test_those_in_each_other_s_way_are_named(r: list, s: list) -> None:
    with pytest.raises(Infeasible, match="way of") as caught:
        coordinate([robot("amr_3", *r), robot("amr_7", *s), robot("far", (0, 50), (9, 50))])
    assert caught.value.robots == ("amr_3", "amr_7") and caught.value.pairs == (("amr_3", "amr_7"),)
    assert "amr_3" in str(caught.value) and "amr_7" in str(caught.value)


def test_departures_headings_and_waits_at_the_start() -> None:
    fleet = coordinate([robot("a", (0, 0), (6, 0), depart=20.0, start_yaw=2.0, goal_yaw=-2.0),
                        robot("b", (3, -3), (3, 3), depart=20.0, start_yaw=-1.0)])
    for schedule in fleet.schedules:
        assert schedule.times[0] == 20.0 and schedule.arc_length(20.5) == 0.0
    assert min(schedule.arrival_time - alone(schedule.robot) for schedule in fleet.schedules) == pytest.approx(0.0)
    assert verify(fleet).min_clearance >= KEPT


def test_sequential_robots_give_way_to_those_before() -> None:
    fleet = coordinate(CROSSING[::-1], mode="sequential")
    assert [schedule.name for schedule in fleet.schedules] == ["b", "a"]
    assert fleet["b"].arrival_time == pytest.approx(alone(CROSSING[1])) and firsts(fleet)[0][1] == "b"
    check_orders(fleet.schedules, 1.0)


def test_a_later_robot_that_goes_first_is_waited_for() -> None:
    """The one planned first passes late; that the other has gone by then must not rest on the clock alone."""
    fleet = coordinate([robot("slow", (-9, 0), (4, 0), max_speed=0.2), CROSSING[1]], mode="sequential")
    assert firsts(fleet) == [("intersection", "b")]
    assert {rule.other for rule in fleet["slow"].precedences} == {"b"}
    check_orders(fleet.schedules, 1.0)


@pytest.mark.parametrize("later", [0.0, -6.0, -500.0, 30.0])
def test_unified_keeps_clear_of_schedules_under_way(later: float) -> None:
    under_way = [schedule.shifted(later) for schedule in coordinate(CROSSING).schedules]
    before = [schedule.times.copy() for schedule in under_way]
    joined = coordinate([robot("c", (-4, -4), (4, 4)), robot("d", (4, -3), (-4, -3))], mode="unified", fixed=under_way)
    assert [schedule.name for schedule in joined.schedules] == ["c", "d"]
    assert verify(under_way + list(joined.schedules)).min_clearance >= KEPT
    assert all(np.array_equal(times, schedule.times) for times, schedule in zip(before, under_way))


def test_a_crossing_robot_waits_until_one_that_waits_itself_has_gone_by() -> None:
    """A schedule with a long wait in it: no time may be read off across the wait."""
    path = robot("old", (-9, 0), (9, 0))
    waiting = Schedule(path, np.array([0.0, 7.0, 7.0, 18.0]), np.array([0.0, 10.0, 60.0, 76.0]))
    joined = coordinate([robot("new", (0, -4), (0, 4), depart=52.0)], fixed=[waiting], mode="unified")
    assert verify([waiting, *joined.schedules]).min_clearance >= KEPT
    follower = coordinate([robot("new", (-9.0, -4.0), (-9, -1), (-7, 0), (7, 0), (7, 4), max_speed=0.9)],
                          fixed=[waiting], mode="unified")
    assert verify([waiting, *follower.schedules]).min_clearance >= KEPT


def test_a_robot_under_way_learns_whom_it_has_to_let_pass_now() -> None:
    """A fast newcomer goes through the crossing before a slow robot that set out alone."""
    slow = coordinate([robot("slow", (-9, 0), (4, 0), max_speed=0.2)], version=1).schedules[0]
    assert slow.precedences == ()
    joined = coordinate([robot("fast", (0, -4), (0, 4))], mode="unified", fixed=[slow], version=2)
    assert [window.first for window in joined.windows] == ["fast"]
    told, = joined.amended
    assert {(rule.other, rule.other_version) for rule in told.precedences} == {("fast", 2)}
    assert np.array_equal(told.times, slow.times) and told.version == slow.version


def test_the_newcomer_may_stand_still_and_the_robot_under_way_waits_for_it() -> None:
    slow = coordinate([robot("slow", (-9, 0), (4, 0), max_speed=0.2)], version=1).schedules[0]
    joined = coordinate([robot("fast", (0, -4), (0, 4))], mode="unified", fixed=[slow], version=2)
    held = Fault("fast", "pause", at=joined["fast"].arrival_time / 2.0, duration=60.0)
    report, _ = simulate(FleetSchedule(joined.schedules + joined.amended), faults=[held])
    assert report.min_clearance is not None and report.min_clearance > 0.0
    assert all(own.arrived for own in report.robots)


def test_a_robot_planned_anew_is_waited_for_on_its_new_path_only() -> None:
    both = coordinate([robot("slow", (-9, 0), (4, 0), max_speed=0.2), CROSSING[1]], version=1)
    assert {rule.other_version for rule in both["slow"].precedences} == {1}
    anew = coordinate([robot("b", (0, -4), (1, -2), (1, 4))], mode="unified", fixed=[both["slow"]], version=2)
    assert {rule.other_version for rule in anew.amended[0].precedences} == {2}
    away = coordinate([robot("b", (0, -4), (0, -2))], mode="unified", fixed=[both["slow"]], version=2)
    assert away.amended[0].precedences == ()


def test_nobody_is_told_anew_where_nothing_changes() -> None:
    alone_there = coordinate([robot("slow", (-9, 0), (4, 0), max_speed=0.2)]).schedules
    assert coordinate([robot("far", (0, 40), (9, 40))], mode="unified", fixed=alone_there).amended == ()


@pytest.mark.parametrize("arcs, times", [([0.0, 5.0], [0.0, 10.0]), ([2.0, 8.0], [0.0, 10.0])])
def test_a_fixed_schedule_of_half_a_path_is_refused(arcs: list, times: list) -> None:
    half = Schedule(CROSSING[0], np.array(arcs), np.array(times))
    with pytest.raises(InvalidScenario, match="schedule of a "):
        coordinate(CROSSING[1:], fixed=[half], mode="unified")


@pytest.mark.parametrize("seed", range(8))
def test_the_order_of_the_request_does_not_matter(seed: int) -> None:
    fleet = street_fleet(6, seed)
    try:
        wanted = coordinate(fleet)
    except Infeasible as error:
        with pytest.raises(Infeasible, match=str(error).split("(")[0][:40]):
            coordinate(fleet[::-1])
        return
    shuffled = coordinate([fleet[index] for index in np.random.RandomState(seed).permutation(6)])
    for body in fleet:
        assert np.array_equal(wanted[body.name].times, shuffled[body.name].times)
        assert wanted[body.name].precedences == shuffled[body.name].precedences
    assert wanted.windows == shuffled.windows


@pytest.mark.parametrize("seed", range(6))
def test_nor_does_the_order_of_those_under_way(seed: int) -> None:
    fleet = street_fleet(14, seed)
    fixed = coordinate(fleet[:7], partial=True).schedules
    found = []
    for under_way in (fixed, fixed[::-1]):
        try:
            found.append(coordinate(fleet[7:], mode="unified", fixed=under_way, partial=True))
        except Infeasible as error:
            found.append(error)
    if isinstance(found[0], Infeasible):
        assert str(found[0]) == str(found[1])
    else:
        assert found[0].windows == found[1].windows and found[0].unserved == found[1].unserved
        assert [rules.precedences for rules in found[0].amended] == [rules.precedences for rules in found[1].amended]
        for one, other in zip(found[0].schedules, found[1].schedules):
            assert np.array_equal(one.times, other.times) and one.precedences == other.precedences


@pytest.mark.parametrize("count, seed", [*itertools.product((2, 4, 8), range(6)), (16, 0), (16, 1), (16, 2), (16, 3)])
def test_street_fleets_never_touch(count: int, seed: int) -> None:
    fleet = [replace(body, depart=3.0 * (index % 3)) for index, body in enumerate(street_fleet(count, seed))]
    try:
        found = coordinate(fleet)
    except Infeasible as error:
        assert len(error.robots) >= 2
        return
    assert verify(found).min_clearance >= KEPT
    assert found.gap < 1e-3 and all(window.first for window in found.windows)
    assert found.objective == pytest.approx(found.sum_of_completion)
    assert all(schedule.arrival_time >= alone(schedule.robot) - 1e-6 for schedule in found.schedules)
    for schedule in found.schedules:
        assert (np.diff(schedule.arc_lengths) / np.diff(schedule.times)).max() <= schedule.robot.max_speed
    if count <= 4:
        for r, s in itertools.combinations(found.schedules, 2):
            worst = smallest_distance(r, s, 0.05) - r.robot.body_radius - s.robot.body_radius
            assert worst >= verify([r, s]).min_clearance - 1e-9 >= worst - 0.15
    check_orders(found.schedules, 1.0)


def test_most_street_fleets_have_a_schedule() -> None:
    answers: Dict[bool, int] = {True: 0, False: 0}
    for seed in range(6):
        try:
            answers[bool(coordinate(street_fleet(8, seed)).schedules)] += 1
        except Infeasible:
            answers[False] += 1
    assert answers[True] >= 4


@pytest.mark.parametrize("paths", [
    [[(x * 0.001, 0.0) for x in range(4000)], [(2, -3), (2, 3)]],
    [[(0, 0), (0, 0), (5, 0), (5, 0)], [(2, -3), (2, 3), (2, 3)]],
    [[(0, 0), (9, 0), (1, 0.01), (9, 0.02)], [(5, -5), (5, 5)]],
    [[(0, 0), (9, 0), (1, 0), (8, 0)], [(5, 5), (5, -5), (5, 5), (4, -5)]],
    [[(0, 0), (5, 0), (5, 5), (0, 5), (0, -5)], [(-3, 0), (-1, 0), (-1, -3)]],
    [[(-k, 0), (20 - k, 0)] for k in range(12)]], ids=[
        "millimetre segments", "repeated points", "doubling back", "shuttling", "over its own start", "lane of twelve"])
def test_nasty_paths_are_driven_without_touching(paths: list) -> None:
    fleet = coordinate([robot(f"robot_{index:02d}", *path) for index, path in enumerate(paths)])
    assert verify(fleet).min_clearance >= KEPT
    check_orders(fleet.schedules, 1.0)


def test_a_limit_too_small_for_any_answer() -> None:
    with pytest.raises(TimedOut):
        coordinate(CROSSING, time_limit=1e-9)


def test_margin_and_tolerance_may_be_nothing() -> None:
    fleet = coordinate(CROSSING, time_margin=0.0, tracking_tolerance=0.0)
    assert 0.0 <= verify(fleet).min_clearance < 0.2
    check_orders(fleet.schedules, 0.0)


def test_a_heavy_robot_goes_first() -> None:
    def first(weight: float) -> str:
        fleet = coordinate([robot("a", (-4, 0), (4, 0), weight=weight), robot("b", (0, -3), (0, 3))])
        return fleet.windows[0].first
    assert first(10.0) == "a" and first(0.1) == "b"


def test_the_makespan_lets_the_longest_way_go_first() -> None:
    fleet = [robot("a", (-4, 0), (30, 0), max_speed=0.4), robot("b", (0, -4), (0, 4), max_speed=0.5),
             robot("c", (0.0, -6.0), (0.0, 2.5), max_speed=0.5)]
    shortest = coordinate(fleet, objective="makespan", gap=0.0)
    assert shortest.objective == pytest.approx(shortest.makespan)
    assert shortest.makespan <= coordinate(fleet, gap=0.0).makespan + 1e-6
    assert verify(shortest).safe
