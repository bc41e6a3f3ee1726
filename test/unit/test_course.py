"""The reference on its way: taken over by another path, wherever it is."""

import numpy as np
import pytest
from driving import schedule_of

from social_fleet.execution.course import Course
from social_fleet.geometry import Pose

BENT = [(0.0, 0.0), (4.0, 0.0), (4.0, 6.0)]


def driven_to(arc_length: float, speed: float, *, turning: bool = False) -> Course:
    course = Course(schedule_of(BENT))
    course.leg = 0 if arc_length < 4.0 else 1
    course.turning = turning
    course.governor.arc_length, course.governor.speed = arc_length, speed
    return course


def rest(origin: float) -> Course:
    path = schedule_of(BENT).robot.path.slice(origin, 10.0)
    return Course(schedule_of(path.points), moving=True)


@pytest.mark.parametrize("at, origin", [(2.5, 2.0), (5.0, 2.0), (4.5, 4.5), (9.0, 3.0)])
def test_it_goes_on_from_where_it_is(at: float, origin: float) -> None:
    course = rest(origin)
    course.continue_from(driven_to(at, 0.5), origin)
    x, y, _ = course.reference
    assert np.allclose((x, y), schedule_of(BENT).robot.path.position(at), atol=0.011)
    assert course.governor.speed == 0.5 and not course.turning
    assert course.last_stop.arc_length <= at - origin <= course.next_stop.arc_length


def test_a_turn_in_place_is_gone_on_with() -> None:
    course = rest(3.5)
    course.continue_from(driven_to(4.0, 0.0, turning=True), 3.5)
    assert course.turning and course.last_stop.heading == pytest.approx(np.pi / 2)


@pytest.mark.parametrize("speed", [0.0, 0.02])
def test_at_the_goal_there_is_nothing_left_to_drive(speed: float) -> None:
    course = rest(9.0)
    course.continue_from(driven_to(10.0, speed), 9.0)
    assert course.at_goal and course.turning


def test_behind_its_origin_it_begins_at_the_start() -> None:
    course = rest(5.0)
    course.continue_from(driven_to(4.99, 0.3), 5.0)
    assert course.governor.arc_length == 0.0 and course.leg == 0


def test_the_start_bounds_no_speed_of_one_that_moves() -> None:
    assert rest(5.0).path.speed(0, 0.0) > 0.6 and Course(schedule_of(BENT)).path.speed(0, 0.0) == 0.0


def test_it_joins_a_path_that_it_drives_along_and_no_other() -> None:
    for pose, joined in ((Pose(0.3, 0.02, 0.05), True), (Pose(0.3, 0.2, 0.0), False), (Pose(0.3, 0.0, 1.0), False)):
        course = Course(schedule_of(BENT), moving=True)
        course.join(pose, 0.4, 0.075)
        assert (course.governor.speed == 0.4) is joined is not course.turning
