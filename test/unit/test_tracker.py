"""One robot under its tracker: boundary conditions, limits, turns, gate, and what stops it."""

import math
from typing import Sequence

import numpy as np
import pytest
from driving import PERIOD, drive, integrate, schedule_of

from social_fleet.coordination.robot import MotionLimits
from social_fleet.coordination.schedule import Precedence
from social_fleet.execution.gate import ReportedProgress
from social_fleet.execution.state import STANDSTILL, Command, ProgressState
from social_fleet.execution.tracker import Tracker
from social_fleet.geometry import Pose

LIMITS = MotionLimits()
ZIGZAG = [(0, 0), (3, 0), (5, 0.5), (5, 3), (2, 3)]


def assert_within_limits(commands: Sequence[Command]) -> None:
    values = np.array([STANDSTILL, *commands])
    assert values[:, 0].min() >= 0.0 and values[:, 0].max() <= LIMITS.max_speed + 1e-12
    assert np.abs(values[:, 1]).max() <= LIMITS.max_turn_rate + 1e-12
    steps = np.abs(np.diff(values, axis=0)) / PERIOD
    assert steps[:, 0].max() <= LIMITS.max_acceleration + 1e-9
    assert steps[:, 1].max() <= LIMITS.max_turn_acceleration + 1e-9


@pytest.mark.parametrize("start_yaw, goal_yaw", [(0.0, math.pi), (2.5, -1.0), (-3.0, None)])
def test_from_start_to_goal_on_time_and_on_the_path(start_yaw: float, goal_yaw: float) -> None:
    schedule = schedule_of(ZIGZAG, start_yaw=start_yaw, goal_yaw=goal_yaw)
    tracker = Tracker(schedule)
    poses, commands, errors = drive(tracker, Pose(0.0, 0.0, start_yaw))
    assert tracker.arrived and commands[-1] == STANDSTILL
    assert np.hypot(*(poses[-1, :2] - (2, 3))) <= 0.02
    assert goal_yaw is None or abs(math.remainder(poses[-1, 2] - goal_yaw, math.tau)) <= 0.05
    assert len(commands) * PERIOD == pytest.approx(schedule.arrival_time, abs=0.5)
    assert max(errors) <= 0.02
    assert tracker.progress == schedule.robot.path.length
    assert_within_limits(commands)


def test_it_comes_back_from_a_push_within_the_limits() -> None:
    tracker = Tracker(schedule_of([(0, 0), (10, 0)]))
    pose, commands = Pose(0.0, 0.0, 0.0), []
    for tick in range(400):
        commands.append(tracker.step(tick * PERIOD, pose, {}))
        pose = integrate(pose, commands[-1], pieces=20)
        if tick == 100:
            pose = Pose(pose.x - 0.05, pose.y + 0.15, pose.yaw - 0.2)
    assert tracker.arrived and abs(pose.y) < 0.02
    assert_within_limits(commands)


def test_it_turns_in_place_and_says_so() -> None:
    tracker = Tracker(schedule_of(ZIGZAG, start_yaw=2.0))
    assert tracker.step(0.0, Pose(0.0, 0.0, 2.0), {}).speed == 0.0
    assert tracker.state is ProgressState.TURNING and tracker.command.turn_rate < 0.0


def test_it_does_not_move_before_its_time() -> None:
    tracker = Tracker(schedule_of([(0, 0), (5, 0)], depart=10.0, start_yaw=1.0))
    assert tracker.step(9.9, Pose(0.0, 0.0, 1.0), {}) == STANDSTILL
    assert tracker.state is ProgressState.IDLE


def held_tracker() -> Tracker:
    return Tracker(schedule_of([(0, 0), (10, 0)], precedences=[Precedence(4.0, "green", 6.0)]))


def test_it_holds_before_the_gate_without_news_and_goes_on_with() -> None:
    tracker, pose, poses = held_tracker(), Pose(0.0, 0.0, 0.0), []
    for tick in range(600):
        others = {"green": ReportedProgress(0, 6.0, 20.0)} if tick >= 400 else {}
        pose = integrate(pose, tracker.step(tick * PERIOD, pose, others), pieces=20)
        poses.append(pose)
        if tick == 399:
            assert tracker.state is ProgressState.HOLDING and tracker.command == STANDSTILL
            assert tracker.waiting_for is not None
            assert tracker.waiting_for.other == "green" and 6.0 < tracker.waiting_for.since < 9.0
    assert max(pose.x for pose in poses[:400]) <= 4.0 and poses[399].x >= 3.97
    assert poses[-1].x > 8.0


def test_an_obstacle_ahead_is_stopped_for() -> None:
    tracker, pose = Tracker(schedule_of([(0, 0), (10, 0)])), Pose(0.0, 0.0, 0.0)
    for tick in range(300):
        pose = integrate(pose, tracker.step(tick * PERIOD, pose, {}, horizon=5.0), pieces=20)
    assert 4.95 < pose.x <= 5.001


def moving_tracker() -> Tracker:
    tracker, pose = Tracker(schedule_of([(0, 0), (10, 0)])), Pose(0.0, 0.0, 0.0)
    for tick in range(100):
        pose = integrate(pose, tracker.step(tick * PERIOD, pose, {}), pieces=20)
    assert tracker.command.speed > 0.6
    return tracker


@pytest.mark.parametrize("pose, stamp", [(None, None), (Pose(math.nan, 0.0, 0.0), None), (Pose(3.1, 0.0, 0.0), 3.0),
                                         (Pose(3.1, 0.5, 0.0), None)])
def test_no_fresh_pose_or_too_far_off_is_a_standstill(pose: Pose, stamp: float) -> None:
    tracker, speeds = moving_tracker(), []
    for tick in range(100, 130):
        speeds.append(tracker.step(tick * PERIOD, pose, {}, pose_stamp=stamp).speed)
        assert tracker.state is ProgressState.STOPPED and tracker.reason
    assert speeds[-1] == 0.0
    assert np.diff(speeds[:10]) == pytest.approx(-PERIOD * LIMITS.max_acceleration)


def test_a_robot_moved_forward_along_its_path_drives_on_from_there() -> None:
    tracker, pose = moving_tracker(), Pose(4.0, 0.0, 0.0)
    assert tracker.step(100 * PERIOD, pose, {}).speed < 0.7 and tracker.state is ProgressState.STOPPED
    for tick in range(101, 700):
        pose = integrate(pose, tracker.step(tick * PERIOD, pose, {}), pieces=20)
    assert tracker.arrived and pose.x == pytest.approx(10.0, abs=0.02)


@pytest.mark.parametrize("back", [0.4, 1.0])
def test_a_robot_moved_behind_its_reported_progress_stands_until_it_gets_another_path(back: float) -> None:
    tracker = moving_tracker()
    reported = tracker.progress
    pose = Pose(reported - 0.25 - back, 0.0, 0.0)  # 0.25 m is its way until it stands
    for tick in range(100, 700):
        pose = integrate(pose, tracker.step(tick * PERIOD, pose, {}), pieces=20)
    assert tracker.state is ProgressState.STOPPED and "behind the progress" in tracker.reason
    assert tracker.progress == reported and pose.x < reported - 0.2
    tracker.follow(schedule_of([(pose.x, 0), (10, 0)], wait=35.0))
    for tick in range(700, 1400):
        pose = integrate(pose, tracker.step(tick * PERIOD, pose, {}), pieces=20)
    assert tracker.arrived


@pytest.mark.parametrize("aside", [0.08, -0.13])
def test_a_robot_aside_of_its_path_stops_creeps_back_and_drives_on(aside: float) -> None:
    tracker, states = moving_tracker(), []
    assert tracker.reference is not None
    pose = Pose(tracker.reference.x, aside, 0.0)
    for tick in range(100, 900):
        pose = integrate(pose, tracker.step(tick * PERIOD, pose, {}), pieces=20)
        states.append(tracker.state)
        assert abs(pose.y) <= abs(aside) + 0.01
    assert states[0] is ProgressState.STOPPED and tracker.arrived and abs(pose.y) < 0.03


def test_a_robot_that_lags_on_its_path_is_only_late() -> None:
    tracker, pose = moving_tracker(), None
    for tick in range(100, 130):  # a wheel that slips: the robot stands where it had come to
        pose = pose or Pose(tracker.progress, 0.0, 0.0)
        tracker.step(tick * PERIOD, pose, {})
        assert tracker.excursion < 0.02 and tracker.state is ProgressState.DRIVING


def test_a_stalled_process_brakes_first() -> None:
    tracker = moving_tracker()
    assert tracker.reference is not None
    pose, speed = tracker.reference, tracker.command.speed
    assert tracker.step(100 * PERIOD + 1.0, pose, {}).speed < speed
    assert tracker.state is ProgressState.STOPPED and "ago" in tracker.reason


def test_progress_is_what_was_measured_and_never_falls() -> None:
    tracker = Tracker(schedule_of([(0, 0), (10, 0)]))
    for tick, x in enumerate((0.0, 0.02, 0.01, 0.05)):
        tracker.step(tick * PERIOD, Pose(x, 0.0, 0.0), {})
        assert tracker.progress == pytest.approx((0.0, 0.02, 0.02, 0.05)[tick])
    assert tracker.report(7.0) == (0, tracker.progress, 7.0)


def test_without_schedule_it_stands() -> None:
    tracker = Tracker()
    assert tracker.step(0.0, Pose(0.0, 0.0, 0.0), {}) == STANDSTILL
    assert tracker.reference is None and tracker.state is ProgressState.IDLE


def test_cancelled_it_brakes_and_stands() -> None:
    tracker = moving_tracker()
    tracker.cancel()
    speeds = [tracker.step(tick * PERIOD, Pose(3.1, 0.0, 0.0), {}).speed for tick in range(100, 120)]
    assert np.diff(speeds[:10]) == pytest.approx(-PERIOD * LIMITS.max_acceleration) and speeds[-1] == 0.0


def test_arrived_it_stands_for_ever() -> None:
    tracker = Tracker(schedule_of([(0, 0), (1, 0)]))
    drive(tracker, Pose(0.0, 0.0, 0.0))
    for now in (50.0, 51.0, 60.0):
        assert tracker.step(now, Pose(1.4, 0.2, 0.0), {}) == STANDSTILL and tracker.arrived


def test_beside_its_goal_it_corrects_itself() -> None:
    tracker = Tracker(schedule_of([(0, 0), (2, 0)], goal_yaw=0.0))
    pose = Pose(0.0, 0.0, 0.0)
    for tick in range(800):
        pose = integrate(pose, tracker.step(tick * PERIOD, pose, {}), pieces=20)
        if tracker.state is ProgressState.DRIVING and pose.x > 1.95 and tick < 100:
            pose = Pose(pose.x, 0.12, pose.yaw)
    assert tracker.arrived and math.hypot(pose.x - 2.0, pose.y) <= 0.05 and abs(pose.yaw) <= 0.1


def test_new_times_on_the_same_path_keep_the_progress() -> None:
    tracker = moving_tracker()
    before, command = tracker.progress, tracker.command
    tracker.follow(schedule_of([(0, 0), (10, 0)], wait=1.0))
    assert tracker.progress == before
    assert abs(tracker.step(100 * PERIOD, Pose(3.1, 0.0, 0.0), {}).speed - command.speed) <= PERIOD + 1e-9


def test_a_new_path_is_joined_on_the_move() -> None:
    tracker = moving_tracker()
    x = tracker.reference.x if tracker.reference else 0.0
    tracker.follow(schedule_of([(x, 0), (x + 3, 0), (x + 5, 1)], wait=5.0))
    assert tracker.step(100 * PERIOD, Pose(x, 0.0, 0.0), {}).speed > 0.6


@pytest.mark.parametrize("points", [[(1, 1)], [(0, 0), (0.001, 0)], [(0, 0), (0.5, 0), (0, 0)]])
def test_odd_paths_end_too(points: list) -> None:
    tracker = Tracker(schedule_of(points, goal_yaw=1.0))
    poses, _, _ = drive(tracker, Pose(points[0][0], points[0][1], 0.0))
    assert tracker.arrived and poses[-1, 2] == pytest.approx(1.0, abs=0.05)


def test_the_clock_may_stand_or_jump_back() -> None:
    tracker, pose = moving_tracker(), Pose(3.1, 0.0, 0.0)
    command = tracker.command
    assert tracker.step(99 * PERIOD, pose, {}) == command
    assert abs(tracker.step(0.0, pose, {}).speed - command.speed) <= PERIOD * LIMITS.max_acceleration + 1e-9


@pytest.mark.parametrize("yaw", [-2.0, 1.0, 3.0])
def test_one_that_is_to_stay_where_it_is_does_not_turn(yaw: float) -> None:
    tracker = Tracker(schedule_of([(1.0, 2.0)]))
    poses, commands, _ = drive(tracker, Pose(1.0, 2.0, yaw), limit=5.0)
    assert tracker.arrived
    assert all(command == STANDSTILL for command in commands)
    assert (poses == poses[0]).all()
