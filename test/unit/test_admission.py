"""What the coordinator makes sure of before schedules come into force."""

import time

import pytest

pytest.importorskip("social_fleet.msg", reason="needs the built workspace's messages; tools/test has them")

import genpy  # noqa: E402
from driving import schedule_of  # noqa: E402
from social_fleet.errors import InvalidScenario, SolverFailed  # noqa: E402
from social_fleet.msg import Progress, Schedule as ScheduleMessage  # noqa: E402
from social_fleet.ros.admission import (check_all_considered, check_clear, check_in_force,  # noqa: E402
                                        next_version, stands_for_good)

EAST, NORTH = schedule_of([(0, 5), (10, 5)], name="gold"), schedule_of([(5, 0), (5, 10)], name="green")


@pytest.mark.parametrize("state, version, standing", [
    (Progress.ARRIVED, 3, True), (Progress.IDLE, 0, True), (Progress.IDLE, 3, False), (Progress.TURNING, 3, False),
    (Progress.DRIVING, 3, False), (Progress.HOLDING, 3, False), (Progress.STOPPED, 3, False)])
def test_who_stands_for_good(state: int, version: int, standing: bool) -> None:
    assert stands_for_good(Progress(robot="gold", state=state, schedule_version=version)) is standing


def test_robots_that_may_move_must_be_considered() -> None:
    fleet = [Progress(robot=name, state=state, schedule_version=3) for name, state in (
        ("blue", Progress.DRIVING), ("gold", Progress.HOLDING), ("red", Progress.ARRIVED), ("teal", Progress.IDLE))]
    check_all_considered(fleet, ["teal", "gold", "blue"])
    with pytest.raises(InvalidScenario, match="gold, teal may move"):
        check_all_considered(fleet, ["blue"])


def test_contact_is_refused_by_both_names() -> None:
    check_clear([EAST], [])
    check_clear([EAST], [schedule_of([(5, 0), (5, 10)], name="green", wait=30.0)])
    with pytest.raises(SolverFailed, match="gold and green overlap by 0.500 m"):
        check_clear([EAST], [NORTH])
    with pytest.raises(SolverFailed, match="gold and green"):
        check_clear([EAST, NORTH], [])


def test_contact_of_fixed_schedules_is_not_the_requests() -> None:
    check_clear([schedule_of([(20, 0), (30, 0)], name="blue")], [EAST, NORTH])


def test_versions_rise_also_above_those_of_a_coordinator_that_ran_before() -> None:
    begun = int(time.time())
    first = next_version([])
    assert begun <= first < 2**32
    assert next_version([first, 5]) > first
    assert next_version([0, first + 1000, 7]) == first + 1001


def test_a_robot_under_way_is_not_taken_for_parked() -> None:
    held = ScheduleMessage(robot="a", version=7, times=[0.0, 10.0])
    held.header.stamp = genpy.Time(100)
    parked = ScheduleMessage(robot="a", version=0, times=[0.0])
    with pytest.raises(InvalidScenario, match="a drives by schedule 7, not by 0"):
        check_in_force([parked], {"a": held}.get, genpy.Time(105))
    check_in_force([parked], {"a": held}.get, genpy.Time(111))
    check_in_force([held], {"a": held}.get, genpy.Time(105))
    check_in_force([parked], {}.get, genpy.Time(105))


def test_who_has_not_taken_up_what_is_in_force_may_do_so_at_any_moment() -> None:
    fleet = [Progress(robot="gold", state=Progress.IDLE), Progress(robot="blue", state=Progress.ARRIVED,
                                                                   schedule_version=4)]
    held = {"gold": ScheduleMessage(robot="gold", version=4), "blue": ScheduleMessage(robot="blue", version=4)}.get
    check_all_considered(fleet, ["gold"], held)
    with pytest.raises(InvalidScenario, match="gold may move"):
        check_all_considered(fleet, [], held)
