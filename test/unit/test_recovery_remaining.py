"""What is left of a robot's way, as the beginning of whatever it drives next."""

import numpy as np
import pytest
from driving import schedule_of

from social_fleet.coordination.schedule import Schedule
from social_fleet.coordination.verification import verify
from social_fleet.execution.recovery.messages import Report
from social_fleet.execution.recovery.remaining import Remaining, joined, stretch
from social_fleet.geometry import Polyline, Pose

BENT = [(0.0, 0.0), (4.0, 0.0), (4.0, 6.0)]


def report(arc_length: float, bound: float, **options: object) -> Report:
    return Report("gold", 0, 8.0, version=1, arc_length=arc_length, bound=bound,
                  pose=Pose(1.0, 1.0, 2.0), **options)  # type: ignore[arg-type]


def left(arc_length: float, bound: float, **options: object) -> Remaining:
    return Remaining.of(report(arc_length, bound, **options), schedule_of(BENT))


def test_from_where_it_is_to_where_it_has_promised_to_stop() -> None:
    item = left(3.0, 5.5)
    assert item.prefix.points.tolist() == [[3.0, 0.0], [4.0, 0.0], [4.0, 1.5]] and item.committed == 2.5
    assert item.end == pytest.approx((4.0, 1.5, np.pi / 2)) and item.way.length == 7.0 and item.origin == 3.0


@pytest.mark.parametrize("bound", [10.0, 99.0, np.inf])
def test_no_farther_than_its_goal(bound: float) -> None:
    assert left(3.0, bound).prefix.length == 7.0


def test_astray_or_without_a_schedule_it_stands_where_it_is() -> None:
    for item in (left(3.0, 5.5, astray=True), Remaining.of(report(0.0, np.inf), None)):
        assert item.prefix.points.tolist() == [[1.0, 1.0]] and item.committed == 0.0 and item.end.yaw == 2.0


def test_a_robot_begins_as_it_is_turned_when_it_stands_and_as_it_drives_when_it_does() -> None:
    standing, moving = left(3.0, 5.5), left(3.0, 5.5, speed=0.7)
    assert standing.robot(standing.way, depart=9.0, goal_yaw=None).start_yaw == 2.0
    robot = moving.robot(moving.way, depart=9.0, goal_yaw=1.0)
    assert robot.start_yaw is None and robot.goal_yaw == 1.0 and robot.committed == 2.5 and 8.0 < robot.depart < 9.0


def test_the_former_schedule_runs_along_what_is_left() -> None:
    item = left(3.0, 5.5)
    old = schedule_of(BENT)
    former = item.former(item.robot(item.way, depart=9.0, goal_yaw=None))
    assert former is not None
    for time in np.linspace(former.times[0], old.times[-1], 50):
        assert former.arc_length(time) == pytest.approx(float(old.arc_length(time)) - 3.0, abs=1e-6)
    assert verify([former]).min_clearance > 0.0


def test_of_one_that_has_arrived_the_former_schedule_stands() -> None:
    item = left(10.0, np.inf)
    former = item.former(item.robot(item.way, depart=9.0, goal_yaw=None))
    assert isinstance(former, Schedule) and former.arc_lengths.tolist() == [0.0]
    assert Remaining.of(report(0.0, np.inf), None).former(item.staying(9.0)) is None


def test_paths_are_joined_and_walked() -> None:
    whole = joined(Polyline([(0, 0), (1, 0)]), Polyline([(1, 0), (1, 2)]))
    assert whole.points.tolist() == [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]]
    assert joined(whole, Polyline([(1, 2)])) is whole
    places = stretch(whole, 1.0)
    assert places[0] == (0.0, 0.0) and places[-1] == (1.0, 0.0) and len(places) == 6
