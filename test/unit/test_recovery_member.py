"""A robot's part in the exchange of schedules: it promises, holds to it, and takes up only what is meant for it."""

import math
from dataclasses import replace
from typing import Optional

import pytest
from driving import PERIOD, integrate, schedule_of

from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import Precedence, Schedule
from social_fleet.execution.config import TrackerConfig
from social_fleet.execution.recovery.config import RecoveryConfig
from social_fleet.execution.recovery.member import Member
from social_fleet.execution.recovery.messages import Assignment, Body, Directive, Errand, Report
from social_fleet.execution.state import ProgressState
from social_fleet.execution.tracker import Tracker
from social_fleet.geometry import Pose

CONFIG = RecoveryConfig()


class Driven:
    """A member on a plant."""

    def __init__(self, schedule: Optional[Schedule], *, session: int = 0) -> None:
        self.member = Member("gold", Body(), Tracker(schedule), session=session, config=CONFIG)
        self.pose = Pose(0.0, 0.0, 0.0)
        self.tick = 0
        self.farthest = 0.0
        self.heard = True

    @property
    def now(self) -> float:
        return self.tick * PERIOD

    def drive(self, seconds: float, *, horizon: float = math.inf) -> "Driven":
        for _ in range(int(round(seconds / PERIOD))):
            if self.heard:
                self.member.hear(Directive(self.now, {"gold": self.now}))
            command = self.member.step(self.now, self.pose, horizon=horizon)
            self.pose = integrate(self.pose, command, pieces=5)
            self.tick += 1
        return self

    def say(self, exchange: int = 0, given: Optional[Assignment] = None) -> Optional[Assignment]:
        return self.member.hear(Directive(self.now, {"gold": self.now}, exchange,
                                          {} if given is None else {"gold": given}))

    @property
    def report(self) -> Report:
        return self.member.report(self.now)


def straight(version: int = 1, **options: object) -> Schedule:
    return replace(schedule_of([(0, 0), (20, 0)], **options), version=version)  # type: ignore[arg-type]


def onward(report: Report, version: int, *, peers: tuple = ()) -> Assignment:
    """A new schedule from a promise: on along the same line, then aside."""
    start, bound = report.arc_length, report.bound
    robot = Robot("gold", [(start, 0), (bound, 0), (20, 0), (20, 3)], committed=bound - start)  # type: ignore[arg-type]
    plain = schedule_of(robot.path.points, wait=report.stamp - 0.5 * report.speed / 0.8)
    return Assignment(report.session, Schedule(robot, plain.arc_lengths, plain.times, version=version, peers=peers),
                      origin=start)


def test_without_an_exchange_it_promises_nothing() -> None:
    assert Driven(straight()).drive(5.0).report.bound == math.inf


def test_a_promise_leaves_room_to_brake_and_is_held() -> None:
    gold = Driven(straight()).drive(5.0)
    gold.say(exchange=2)
    report = gold.drive(PERIOD).report
    assert report.exchange == 2 and report.version == 1
    assert report.arc_length + 0.25 < report.bound < report.arc_length + 0.7 * (CONFIG.lookahead + 1.0)
    assert gold.drive(20.0).pose.x <= report.bound + 0.01
    assert gold.report.bound == report.bound and gold.member.tracker.command.speed == 0.0


def test_a_promise_is_never_beyond_the_gate() -> None:
    gold = Driven(straight(precedences=[Precedence(4.0, "green", 1.0, 1)])).drive(6.5)
    gold.say(exchange=2)
    assert gold.drive(PERIOD).report.bound <= 4.0


def test_it_goes_on_without_a_pause_with_what_was_made_from_its_promise() -> None:
    gold = Driven(straight()).drive(5.0)
    gold.say(exchange=2)
    given = onward(gold.drive(PERIOD).report, 2)
    gold.drive(0.5)
    assert gold.say(given=given, exchange=2) is given
    speeds = []
    for _ in range(40):
        gold.drive(PERIOD)
        speeds.append(gold.member.tracker.command.speed)
    assert min(speeds) > 0.55 and gold.report.version == 2 and gold.report.bound == math.inf
    assert gold.report.arc_length == pytest.approx(gold.pose.x - given.origin, abs=0.05)
    gold.drive(60.0)
    assert gold.member.tracker.arrived and gold.pose.y == pytest.approx(3.0, abs=0.05)


def test_it_passes_nothing_beyond_that_before_all_others_have_left_the_old_schedules() -> None:
    gold = Driven(straight()).drive(5.0)
    gold.say(exchange=2)
    report = gold.drive(PERIOD).report
    gold.say(given=onward(report, 2, peers=("blue", "green")), exchange=2)
    gold.member.hear_report(Report("blue", 0, 1.0, version=3))
    gold.member.hear_report(Report("green", 0, 1.0, version=1))
    assert gold.drive(20.0).pose.x <= report.bound + 0.01
    assert gold.member.tracker.waiting_for is not None and gold.member.tracker.waiting_for.other == "green"
    gold.member.hear_report(Report("green", 0, 2.0, version=2))
    assert gold.drive(10.0).pose.x > report.bound + 2.0


@pytest.mark.parametrize("change", ["session", "older", "not promised"])
def test_what_is_not_meant_for_it_now_is_not_taken_up(change: str) -> None:
    gold = Driven(straight(version=3), session=4).drive(5.0)
    gold.say(exchange=5)
    given = onward(gold.drive(PERIOD).report, 5)
    if change == "session":
        given = replace(given, session=3)
    else:
        given = replace(given, schedule=replace(given.schedule, version=2 if change == "older" else 6))
    assert gold.say(given=given, exchange=5) is None and gold.report.version == 3
    assert gold.drive(20.0).report.bound < 10.0


def test_a_second_exchange_asks_for_no_more_than_was_promised() -> None:
    gold = Driven(straight()).drive(5.0)
    gold.say(exchange=2)
    first = gold.drive(PERIOD).report.bound
    gold.say(exchange=3)
    second = gold.drive(PERIOD).report
    assert second.exchange == 3 and second.bound <= first


def test_late_directives_change_nothing() -> None:
    gold = Driven(straight()).drive(5.0)
    gold.say(exchange=4)
    bound = gold.drive(PERIOD).report.bound
    gold.say(exchange=2)
    gold.member.hear(Directive(0.0, {"gold": 0.0}))
    assert gold.drive(PERIOD).report.exchange == 4 and gold.report.bound == bound


def test_silence_is_a_standstill_until_the_next_schedule() -> None:
    gold = Driven(straight()).drive(3.0)
    gold.heard = False
    gold.drive(CONFIG.lapse + 2.0)
    stands = gold.pose.x
    assert gold.report.lapsed and gold.member.tracker.command.speed == 0.0
    gold.heard = True
    assert gold.drive(10.0).pose.x == stands
    gold.say(exchange=2)
    report = gold.drive(PERIOD).report
    gold.say(given=onward(report, 2), exchange=2)
    assert gold.drive(5.0).pose.x > stands + 1.0 and not gold.report.lapsed


def test_who_is_heard_of_and_does_not_know_it_stands_too() -> None:
    gold = Driven(straight()).drive(3.0)
    gold.heard = False
    for _ in range(9):
        gold.member.hear(Directive(gold.now, {"gold": 2.0, "green": gold.now}))
        gold.drive(1.0)
    assert gold.report.lapsed


def test_off_its_path_it_asks_for_another_and_stands_until_it_has_one() -> None:
    gold = Driven(straight()).drive(5.0)
    gold.pose = Pose(gold.pose.x, 1.0, 0.0)
    assert not gold.drive(5.0).report.astray
    assert gold.drive(TrackerConfig().pose_settle + CONFIG.astray).report.astray
    gold.say(exchange=2)
    gold.drive(PERIOD)
    gold.pose = place = Pose(gold.pose.x, 0.0, 0.0)  # localisation is back, but the promise has been given
    assert gold.drive(15.0).pose == place and gold.report.astray
    robot = Robot("gold", [(place.x, 0.0), (20.0, 0.0)], committed=0.0)  # type: ignore[arg-type]
    plain = schedule_of(robot.path.points, wait=gold.now)
    gold.say(given=Assignment(0, Schedule(robot, plain.arc_lengths, plain.times, version=2)), exchange=2)
    assert gold.drive(5.0).pose.x > place.x + 1.0 and not gold.report.astray


def test_what_stands_in_its_way_is_reported_for_as_long_as_it_does() -> None:
    gold = Driven(straight()).drive(10.0, horizon=3.0)
    assert gold.report.blocked > 2.0 and gold.member.tracker.state is ProgressState.DRIVING
    assert gold.drive(10.0).report.blocked == 0.0


def test_older_reports_are_passed_over() -> None:
    gold = Driven(straight())
    for session, stamp, version in ((1, 5.0, 4), (1, 4.0, 9), (0, 9.0, 8)):
        gold.member.hear_report(Report("blue", session, stamp, version=version))
    assert gold.member.others["blue"].version == 4


def test_what_it_last_heard_of_a_missing_robot_is_passed_on() -> None:
    gold = Driven(straight())
    gold.member.hear_report(Report("blue", 0, 3.0))
    assert gold.member.remembered(Directive(9.0, {}, missing=("blue", "red"))) == [Report("blue", 0, 3.0)]
    assert gold.member.remembered(Directive(9.0, {})) == []


def test_it_is_served_only_at_the_goal_of_its_latest_errand() -> None:
    gold = Driven(replace(schedule_of([(0, 0), (1, 0)]), version=1))
    gold.member.errand = Errand(1, (1.0, 0.0))
    gold.member.assignment = Assignment(0, gold.member.tracker.schedule, errand=1)  # type: ignore[arg-type]
    assert not gold.member.served
    assert gold.drive(10.0).member.served
    gold.member.errand = Errand(2, (1.0, 0.0))
    assert not gold.member.served
