"""Delays are what a robot loses against driving alone; occupancies say when robots are where they could meet."""

import numpy as np
import pytest

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import EncounterWindow, FleetSchedule, Precedence, Schedule
from social_fleet.coordination.timing import nominal_timing
from social_fleet.scenario.pictures.timeline import delays, driven_arcs, occupancies, when
from social_fleet.scenario.recording import Recording

L_SHAPE = np.array([[0.0, 0.0], [5.0, 0.0], [5.0, 5.0]])


def free_schedule(name: str = "a", wait_at: float = -1.0, seconds: float = 0.0, other: str = "") -> Schedule:
    """A robot alone on an L with a turn in place, standing for `seconds` more at `wait_at` [m]."""
    robot = Robot(name, L_SHAPE)
    timing = nominal_timing(robot.path, robot.limits)
    arcs, times = timing.arc_lengths, timing.times
    if seconds:
        moment = float(timing.last_time(wait_at))
        later = times > moment
        arcs = np.concatenate((arcs[~later], np.array([wait_at, wait_at]), arcs[later]))
        times = np.concatenate((times[~later], moment + np.array([1e-6, seconds]), times[later] + seconds))
    rules = (Precedence(wait_at + 0.5, other, 2.0),) if other else ()
    return Schedule(robot, arcs, times, rules)


def test_turning_in_place_is_no_delay() -> None:
    schedule = free_schedule()
    assert delays(FleetSchedule((schedule,)), schedule) == []


@pytest.mark.parametrize("place", [2.0, 7.03])
def test_a_wait_is_found_where_it_is(place: float) -> None:
    schedule = free_schedule(wait_at=place, seconds=4.0)
    found, = delays(FleetSchedule((schedule,)), schedule)
    assert found.standing and found.reason is None
    assert found.seconds == pytest.approx(4.0, abs=0.01)
    assert found.end[1] == pytest.approx(place)


def test_a_late_departure_is_a_wait() -> None:
    schedule = free_schedule().shifted(3.0)
    found, = delays(FleetSchedule((schedule,)), schedule)
    assert (found.seconds, found.times[0], found.end[1]) == (pytest.approx(3.0, abs=1e-3), 0.0, 0.0)


def test_slow_driving_is_a_delay_but_no_wait() -> None:
    schedule = free_schedule()
    slow = Schedule(schedule.robot, schedule.arc_lengths, schedule.times * 2.0)
    found, = delays(FleetSchedule((slow,)), slow)
    assert not found.standing
    assert found.seconds == pytest.approx(schedule.arrival_time, rel=0.01)


def test_the_rule_that_binds_is_the_reason() -> None:
    waiting = free_schedule("a", wait_at=2.0, seconds=4.0, other="b")
    leader = Robot("b", L_SHAPE)
    leading = Schedule(leader, np.array([0.0, 2.0, 10.0]), np.array([0.0, waiting.times[-1] - 13.0, 20.0]))
    reason = delays(FleetSchedule((waiting, leading)), waiting)[0].reason
    assert reason is not None and reason.other == "b"


def test_times_at_places() -> None:
    schedule = Schedule(Robot("a", L_SHAPE), np.array([0.0, 4.0, 4.0, 10.0]), np.array([1.0, 5.0, 8.0, 14.0]))
    assert when(schedule, 2.0) == 3.0
    assert (when(schedule, 4.0), when(schedule, 4.0, last=True)) == (5.0, 8.0)
    assert (when(schedule, -1.0), when(schedule, 99.0)) == (1.0, 14.0)


def test_the_first_robot_comes_first() -> None:
    a, b = free_schedule("a"), free_schedule("b")
    window = EncounterWindow("a", "b", "intersection", 1.0, 2.0, 3.0, 4.0, "b")
    (kind, first, second), = occupancies(FleetSchedule((a, b), (window,)))
    assert (kind, first.robot, second.robot) == ("intersection", "b", "a")
    assert (first.enter, first.leave) == (3.0, 4.0) and first.begin < first.end
    stranger = EncounterWindow("a", "fixed", "intersection", 1.0, 2.0, 3.0, 4.0, "a")
    assert occupancies(FleetSchedule((a, b), (stranger,))) == []


def test_only_one_robot_is_in_an_intersection() -> None:
    fleet = coordinate([Robot("a", np.array([[0.0, 5.0], [10.0, 5.0]])),
                        Robot("b", np.array([[5.0, 0.0], [5.0, 10.0]]))])
    (_, first, second), = occupancies(fleet)
    assert first.end <= second.begin


def test_progress_is_read_off_true_positions() -> None:
    schedule = free_schedule()
    times = np.arange(0.0, schedule.arrival_time + 5.0, 0.1)
    poses = np.zeros((len(times), 1, 3))
    poses[:, 0, :2] = schedule.position(times) + 0.02
    driven, arcs = driven_arcs(FleetSchedule((schedule,)), Recording(("a",), times, poses))["a"]
    assert np.abs(arcs - schedule.arc_length(driven)).max() < 0.05
    assert driven[-1] < schedule.arrival_time + 1.0
