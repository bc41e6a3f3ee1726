"""What robots and coordinator say to each other survives the way through messages."""

import math
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("social_fleet.msg", reason="needs the built workspace's messages; tools/test has them")

import genpy  # noqa: E402
from social_fleet.coordination.robot import MotionLimits, Robot  # noqa: E402
from social_fleet.coordination.schedule import Precedence, Schedule  # noqa: E402
from social_fleet.errors import InvalidInput  # noqa: E402
from social_fleet.execution.gate import Waiting  # noqa: E402
from social_fleet.execution.recovery.messages import Assignment, Body, Directive, Errand, Report  # noqa: E402
from social_fleet.execution.state import ProgressState  # noqa: E402
from social_fleet.geometry import Pose  # noqa: E402
from social_fleet.msg import Errand as ErrandMessage, Progress  # noqa: E402
from social_fleet.planning.overlays.shapes import DiscObstacle  # noqa: E402
from social_fleet.ros import exchange_conversions as conversions  # noqa: E402

CLOCK = conversions.FleetClock(genpy.Time(1700000000, 250000000))
ROBOT = Robot("gold", np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)]), 0.5, 0.3, goal_yaw=None, committed=1.25,
              weight=2.0)
SCHEDULE = Schedule(ROBOT, np.array([0.0, 3.0, 7.0]), np.array([-2.5, 4.0, 15.125]),
                    (Precedence(2.0, "blue", 3.5, 1700000000),), 1700000001, ("blue", "red"))
REPORT = Report("gold", 1700000000123, 3.5, Body(0.3, MotionLimits(0.5, 0.4, 1.1, 2.2), 2.0), 1700000001, 1.5, 0.25,
                ProgressState.HOLDING, Pose(1.5, 0.01, 0.5), 1700000002, math.inf, True, False, Errand(8, (4.0, 3.0)),
                7, "no way", True, {"a": DiscObstacle(1.0, 2.0, 0.4)}, ("b",), 2.5, Waiting("blue", 2.0, 3.5, 1.0))


def same(one: Schedule, other: Schedule) -> None:
    """Equal but for arrays, which dataclasses do not compare, and what rounding does."""
    assert one.robot.path.points.tolist() == other.robot.path.points.tolist()
    assert one.arc_lengths.tolist() == other.arc_lengths.tolist()
    assert other.times == pytest.approx(one.times, abs=1e-8)
    assert (one.precedences, one.version, one.peers) == (other.precedences, other.version, other.peers)
    for name in ("name", "max_speed", "radius", "goal_yaw", "start_yaw", "committed", "weight", "limits"):
        assert getattr(one.robot, name) == getattr(other.robot, name), name


@pytest.mark.parametrize("seconds", [0.0, 0.1, 12345.678, -3.25])
def test_times_come_back(seconds: float) -> None:
    assert CLOCK.seconds(CLOCK.stamp(seconds)) == pytest.approx(seconds, abs=1e-8)


def test_a_schedule_comes_back_whatever_the_clocks_zero() -> None:
    message = conversions.schedule_to_absolute(SCHEDULE, "map", CLOCK)
    assert message.times[0] == 0.0
    same(SCHEDULE, conversions.schedule_from_absolute(message, "map", CLOCK))
    late = conversions.FleetClock(CLOCK.stamp(100.0))
    same(SCHEDULE.shifted(-100.0), conversions.schedule_from_absolute(message, "map", late))


def test_headings_that_do_not_matter_stay_so() -> None:
    turned = replace(SCHEDULE, robot=replace(ROBOT, start_yaw=0.0, goal_yaw=0.0, committed=None))
    same(turned, conversions.schedule_from_absolute(conversions.schedule_to_absolute(turned, "map", CLOCK), "map",
                                                    CLOCK))


@pytest.mark.parametrize("report", [REPORT, replace(REPORT, pose=None, errand=None, waiting_for=None, bound=2.0),
                                    replace(REPORT, errand=Errand(9, (4.0, 3.0, 1.5)), lapsed=False, astray=True)])
def test_a_report_comes_back(report: Report) -> None:
    message = conversions.report_to_message(report, "map", CLOCK)
    result = conversions.report_from_message(message, CLOCK)
    assert result.stamp == pytest.approx(report.stamp)
    assert replace(result, stamp=report.stamp, waiting_for=report.waiting_for) == report
    assert (result.waiting_for is None) == (report.waiting_for is None)


def test_progress_tells_gates_what_they_need() -> None:
    message = Progress(robot="gold", session=7, schedule_version=3, arc_length=1.5)
    message.header.stamp = CLOCK.stamp(2.0)
    report = conversions.report_from_progress(message, CLOCK)
    assert (report.name, report.session, report.version, report.arc_length) == ("gold", 7, 3, 1.5)
    assert report.stamp == pytest.approx(2.0)


def test_a_directive_comes_back() -> None:
    assignment = Assignment(9, SCHEDULE, 0.75, 8, "no way", True, True)
    directive = Directive(5.0, {"gold": 4.5, "blue": 4.0}, 12, {"gold": assignment},
                          {"a": DiscObstacle(1.0, 2.0, 0.4)}, ("red",))
    message = conversions.directive_to_message(directive, "map", CLOCK)
    result = conversions.directive_from_message(message, "map", CLOCK)
    assert result.heard == pytest.approx(dict(directive.heard))
    assert (result.exchange, result.obstacles, result.missing) == (12, directive.obstacles, ("red",))
    same(SCHEDULE, result.assignments["gold"].schedule)
    assert replace(result.assignments["gold"], schedule=SCHEDULE) == assignment
    assert not conversions.directive_from_message(message, "map", CLOCK, only="blue").assignments


def test_wrong_messages_are_refused() -> None:
    message = conversions.report_to_message(REPORT, "map", CLOCK)
    for name, value in (("robot", ""), ("session", 0), ("state", 77), ("max_speed", -1.0)):
        wrong = conversions.report_to_message(REPORT, "map", CLOCK)
        setattr(wrong, name, value)
        with pytest.raises(InvalidInput):
            conversions.report_from_message(wrong, CLOCK)
    message.errand = ErrandMessage(number=3)
    message.errand.goal.x = math.nan
    with pytest.raises(InvalidInput, match="not finite"):
        conversions.report_from_message(message, CLOCK)
    directive = conversions.directive_to_message(Directive(5.0, {"gold": 4.5}), "map", CLOCK)
    directive.heard = []
    with pytest.raises(InvalidInput):
        conversions.directive_from_message(directive, "map", CLOCK)
