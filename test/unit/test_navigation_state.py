"""What becomes of a robot's goals."""

import pytest

from social_fleet.errors import InvalidParameter
from social_fleet.execution.navigation_state import Errand, Navigation, NavigationConfig, NavigationState, RobotNews
from social_fleet.geometry import Pose

GOAL, OTHER = Pose(5.0, 1.0, 0.0), Pose(1.0, 5.0, 1.57)
STANDS, DRIVES = RobotNews(0, True, False), RobotNews(7, False, False)
CONFIG = NavigationConfig(patience=10.0, blocked_patience=30.0, retry_period=1.0)


def planning() -> Navigation:
    """A robot that stands, with a goal that is being planned for at 0 s."""
    navigation = Navigation(CONFIG)
    navigation.hear(STANDS, 0.0)
    navigation.accept(GOAL, 0.0)
    navigation.hear(STANDS, 0.0)
    assert navigation.errand is Errand.PLAN
    return navigation


def driving(version: int = 7) -> Navigation:
    """A robot that drives to its goal at 1 s."""
    navigation = planning()
    assert navigation.planned(navigation.number, 0.5)
    assert navigation.errand is Errand.COORDINATE
    assert navigation.scheduled(navigation.number, version, 1.0)
    assert not navigation.holds
    return navigation


def test_there_is_nothing_to_do_without_a_goal() -> None:
    navigation = Navigation()
    navigation.hear(DRIVES, 1.0)
    assert (navigation.state, navigation.errand, navigation.holds) == (NavigationState.IDLE, Errand.NOTHING, False)


def test_a_goal_is_planned_coordinated_driven_and_reached() -> None:
    navigation = driving()
    navigation.hear(RobotNews(6, True, True), 1.0)
    assert navigation.state is NavigationState.DRIVING, "it stands at the end of an earlier schedule"
    navigation.hear(DRIVES, 5.0)
    navigation.hear(RobotNews(7, True, True), 9.0)
    assert (navigation.state, navigation.errand, navigation.since) == (NavigationState.SUCCEEDED, Errand.NOTHING, 9.0)


def test_a_robot_that_drives_stops_before_it_is_planned_for() -> None:
    navigation = driving()
    navigation.hear(DRIVES, 2.0)
    navigation.accept(OTHER, 2.0)
    navigation.hear(DRIVES, 2.1)
    assert (navigation.state, navigation.errand, navigation.holds) == (NavigationState.STOPPING, Errand.NOTHING, True)
    navigation.hear(STANDS, 3.0, busy=True)
    assert navigation.state is NavigationState.STOPPING, "a schedule may still come into force"
    navigation.hear(STANDS, 3.0)
    assert (navigation.state, navigation.goal) == (NavigationState.PLANNING, OTHER)


def test_answers_to_an_earlier_goal_change_nothing() -> None:
    navigation = planning()
    former = navigation.number
    navigation.accept(OTHER, 1.0)
    assert not navigation.planned(former, 1.0)
    navigation.refused(former, 1.0, "too late", final=True)
    assert navigation.state is NavigationState.STOPPING
    assert not navigation.scheduled(former, 7, 1.0)
    assert navigation.state is NavigationState.STOPPING and navigation.holds


def test_a_goal_that_is_wrong_is_given_up_at_once_and_the_next_one_runs() -> None:
    navigation = planning()
    navigation.refused(navigation.number, 1.0, "in a wall", final=True)
    assert (navigation.state, navigation.reason, navigation.holds) == (NavigationState.ABORTED, "in a wall", False)
    navigation.accept(OTHER, 2.0)
    navigation.hear(STANDS, 2.0)
    assert (navigation.errand, navigation.reason) == (Errand.PLAN, "")


def test_what_is_refused_is_tried_again_until_patience_ends() -> None:
    navigation, now, attempts = planning(), 0.0, 0
    while navigation.active and now < 60.0:
        if navigation.errand is Errand.PLAN:
            attempts += 1
            navigation.refused(navigation.number, now, "occupied")
        navigation.hear(STANDS, now)
        now += 0.5
    assert navigation.state is NavigationState.ABORTED
    assert 10.0 <= navigation.since <= 11.0
    assert 7 <= attempts <= 11


@pytest.mark.parametrize("state", ["planning", "coordinating", "driving", "waiting"])
def test_a_goal_can_be_taken_back_at_any_time(state: str) -> None:
    navigation = driving() if state == "driving" else planning()
    if state == "coordinating":
        navigation.planned(navigation.number, 1.0)
    if state == "waiting":
        navigation.refused(navigation.number, 1.0, "occupied")
    navigation.cancel(2.0)
    assert navigation.state is NavigationState.CANCELED
    navigation.hear(DRIVES, 2.0)
    assert navigation.errand is Errand.NOTHING
    navigation.hear(RobotNews(7, True, False), 3.0)
    assert (navigation.errand is Errand.PARK) is navigation.holds is (state == "driving")
    navigation.parked(4.0)
    assert (navigation.errand, navigation.holds) == (Errand.NOTHING, False)


def test_a_schedule_that_comes_after_all_is_not_driven() -> None:
    navigation = planning()
    navigation.planned(navigation.number, 1.0)
    former = navigation.number
    navigation.cancel(1.0)
    navigation.scheduled(former, 7, 2.0)
    navigation.hear(RobotNews(7, True, False), 2.0)
    assert navigation.holds and navigation.errand is Errand.PARK


def test_a_robot_in_trouble_gets_another_path() -> None:
    navigation = driving()
    navigation.hear(RobotNews(7, True, False, trouble="off its way"), 5.0)
    assert (navigation.errand, navigation.replans, navigation.reason) == (Errand.PLAN, 1, "off its way")
    navigation.refused(navigation.number, 6.0, "no path", final=True)
    assert navigation.state is NavigationState.WAITING, "what was possible before may be so again"
    navigation.hear(RobotNews(7, True, False, trouble="off its way"), 8.0)
    assert navigation.errand is Errand.PLAN


def test_a_robot_that_is_blocked_keeps_its_schedule_while_there_is_no_other_way() -> None:
    navigation, now = driving(), 5.0
    blocked = RobotNews(7, True, False, blocked="something is in the way")
    while navigation.active and now < 100.0:
        navigation.hear(blocked, now)
        if navigation.errand is Errand.PLAN:
            assert navigation.holds
            navigation.refused(navigation.number, now, "no path round it", final=True)
            assert navigation.state is not NavigationState.DRIVING or not navigation.holds
        now += 0.5
    assert (navigation.state, navigation.reason) == (NavigationState.ABORTED, "no path round it")
    assert 30.0 <= navigation.since - 5.0 <= 32.0


def test_a_way_that_is_free_again_makes_patience_begin_anew() -> None:
    navigation = driving()
    blocked = RobotNews(7, True, False, blocked="something is in the way")
    navigation.hear(blocked, 5.0)
    navigation.refused(navigation.number, 5.0, "no path round it")
    navigation.hear(DRIVES, 20.0)
    assert navigation.reason == ""
    navigation.hear(blocked, 40.0)
    navigation.refused(navigation.number, 40.0, "no path round it")
    assert navigation.state is NavigationState.DRIVING


def test_parameters_are_checked() -> None:
    with pytest.raises(InvalidParameter, match="retry_period"):
        NavigationConfig(retry_period=0.0)
