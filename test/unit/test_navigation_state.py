"""What becomes of a robot's goals."""

import pytest

from social_fleet.errors import InvalidParameter
from social_fleet.execution.navigation_state import Navigation, NavigationConfig, NavigationState, Order, RobotNews
from social_fleet.geometry import Pose

GOAL, OTHER = Pose(5.0, 1.0, 0.0), Pose(1.0, 5.0, 1.57)
CONFIG = NavigationConfig(patience=10.0, waiting_patience=30.0, retry_period=1.0)
DRIVES, ARRIVED = RobotNews(7), RobotNews(7, arrived=True)
BLOCKED = RobotNews(7, reason="gold has no way to its goal")


def planning() -> Navigation:
    """A goal, number 7, that the planner was asked about at 0 s."""
    navigation = Navigation(CONFIG)
    navigation.hear(RobotNews(), 0.0)
    navigation.accept(GOAL, 7, 0.0)
    assert navigation.wants_path and navigation.order is None
    return navigation


def driving() -> Navigation:
    """A robot that drives to it at 2 s."""
    navigation = planning()
    navigation.planned(7, 1.0)
    assert navigation.state is NavigationState.COORDINATING and navigation.order == Order(7, GOAL)
    navigation.hear(RobotNews(6), 1.5)
    assert navigation.state is NavigationState.COORDINATING
    navigation.hear(DRIVES, 2.0)
    assert navigation.state is NavigationState.DRIVING
    return navigation


def test_there_is_nothing_to_do_without_a_goal() -> None:
    navigation = Navigation()
    navigation.hear(ARRIVED, 1.0)
    navigation.cancel(1.0)
    assert (navigation.state, navigation.order, navigation.wants_path) == (NavigationState.IDLE, None, False)


def test_a_goal_is_planned_coordinated_driven_and_reached() -> None:
    navigation = driving()
    navigation.hear(DRIVES, 5.0)
    navigation.hear(ARRIVED, 9.0)
    assert (navigation.state, navigation.since, navigation.order) == (NavigationState.SUCCEEDED, 9.0, Order(7, GOAL))


def test_standing_at_the_end_of_an_earlier_schedule_is_no_arrival() -> None:
    navigation = planning()
    navigation.planned(7, 1.0)
    navigation.hear(RobotNews(6, arrived=True), 1.0)
    assert navigation.state is NavigationState.COORDINATING


def test_the_robot_goes_on_to_the_old_goal_until_there_is_a_path_to_the_new_one() -> None:
    navigation = driving()
    navigation.accept(OTHER, 8, 3.0)
    assert navigation.order == Order(7, GOAL)
    navigation.hear(DRIVES, 3.1)
    assert navigation.state is NavigationState.PLANNING
    navigation.planned(8, 3.5)
    assert navigation.order == Order(8, OTHER)
    navigation.hear(DRIVES, 3.6)
    assert navigation.state is NavigationState.COORDINATING
    navigation.hear(RobotNews(8), 4.0)
    assert navigation.state is NavigationState.DRIVING


def test_answers_to_an_earlier_goal_change_nothing() -> None:
    navigation = planning()
    navigation.accept(OTHER, 8, 1.0)
    navigation.planned(7, 1.0)
    navigation.refused(7, 1.0, "too late", final=True)
    assert (navigation.state, navigation.order) == (NavigationState.PLANNING, None)


def test_a_goal_that_is_wrong_is_given_up_at_once_and_the_next_one_runs() -> None:
    navigation = driving()
    navigation.accept(OTHER, 8, 3.0)
    navigation.refused(8, 3.0, "in a wall", final=True)
    assert (navigation.state, navigation.reason) == (NavigationState.ABORTED, "in a wall")
    assert navigation.order == Order(8, None), "the robot stays where it is"
    navigation.accept(GOAL, 9, 4.0)
    assert navigation.wants_path and navigation.reason == ""


def test_a_planner_that_is_not_ready_is_asked_again_until_patience_ends() -> None:
    navigation, now, asked = planning(), 0.0, 0
    while navigation.active and now < 60.0:
        if navigation.wants_path:
            asked += 1
            navigation.refused(7, now, "no map has come yet", final=False)
        navigation.hear(RobotNews(), now)
        now += 0.25
    assert (navigation.state, navigation.reason) == (NavigationState.ABORTED, "no map has come yet")
    assert 10.0 <= navigation.since <= 11.5
    assert 8 <= asked <= 12


def test_a_planner_that_becomes_ready_is_enough() -> None:
    navigation = planning()
    navigation.refused(7, 0.0, "no map has come yet", final=False)
    navigation.hear(RobotNews(), 1.5)
    navigation.planned(7, 2.0)
    assert (navigation.state, navigation.reason) == (NavigationState.COORDINATING, "")


@pytest.mark.parametrize("state", ["planning", "coordinating", "driving", "waiting"])
def test_a_goal_can_be_taken_back_at_any_time(state: str) -> None:
    navigation = driving() if state in ("driving", "waiting") else planning()
    if state == "coordinating":
        navigation.planned(7, 1.0)
    if state == "waiting":
        navigation.hear(BLOCKED, 3.0)
    navigation.cancel(4.0)
    assert navigation.state is NavigationState.CANCELED
    assert navigation.order == (None if state == "planning" else Order(7, None))
    navigation.hear(DRIVES, 5.0)
    assert navigation.state is NavigationState.CANCELED


def test_what_the_fleet_cannot_serve_now_is_waited_for() -> None:
    navigation = driving()
    navigation.hear(BLOCKED, 5.0)
    assert (navigation.state, navigation.reason) == (NavigationState.WAITING, BLOCKED.reason)
    navigation.hear(DRIVES, 20.0)
    assert (navigation.state, navigation.reason) == (NavigationState.DRIVING, "")
    navigation.hear(BLOCKED, 30.0)
    navigation.hear(BLOCKED, 50.0)
    assert navigation.state is NavigationState.WAITING, "patience has begun anew"


def test_what_the_fleet_gives_up_is_aborted_with_its_reason() -> None:
    navigation = driving()
    navigation.hear(BLOCKED._replace(final=True), 5.0)
    assert (navigation.state, navigation.reason, navigation.order) == (NavigationState.ABORTED, BLOCKED.reason,
                                                                       Order(7, None))


def test_nothing_is_waited_for_without_end() -> None:
    navigation, now = driving(), 5.0
    while navigation.active and now < 100.0:
        navigation.hear(RobotNews(7, trouble="its tracker says nothing"), now)
        now += 1.0
    assert (navigation.state, navigation.since) == (NavigationState.ABORTED, 35.0)


def test_a_fleet_that_does_not_answer_is_not_waited_for_without_end() -> None:
    navigation, now = planning(), 1.0
    navigation.planned(7, 1.0)
    while navigation.active and now < 100.0:
        navigation.hear(RobotNews(), now)
        now += 1.0
    assert navigation.state is NavigationState.ABORTED and "made room" in navigation.reason


def test_parameters_are_checked() -> None:
    with pytest.raises(InvalidParameter, match="retry_period"):
        NavigationConfig(retry_period=0.0)


def test_the_fleet_can_be_asked_anew_while_patience_goes_on() -> None:
    navigation, now = driving(), 3.0
    while navigation.active and now < 100.0:
        navigation.hear(RobotNews(navigation.number, trouble="its schedule has ended elsewhere"), now)
        if navigation.active:
            navigation.again(navigation.number + 1, now)
            navigation.planned(navigation.number, now)
            assert navigation.order == Order(navigation.number, GOAL)
        now += 1.0
    assert (navigation.state, navigation.since) == (NavigationState.ABORTED, 33.0)
