"""Poses that jump, and when they are believed again."""

import pytest

from social_fleet.coordination.robot import MotionLimits
from social_fleet.execution.pose_watch import PoseWatch
from social_fleet.geometry import Pose

LIMITS = MotionLimits(max_speed=0.5, max_turn_rate=1.0)


def test_motion_within_the_limits_and_the_noise_is_believed() -> None:
    watch = PoseWatch(jump=0.1, settle=1.0)
    assert all(watch.believes(0.1 * tick, Pose(0.05 * tick + 0.09 * (tick % 2), 0.0, 0.1 * tick), LIMITS)
               for tick in range(20))


@pytest.mark.parametrize("pose", [Pose(0.9, 0.0, 0.0), Pose(0.0, 0.0, 0.9)])
def test_a_jump_is_not_believed_before_poses_hang_together(pose: Pose) -> None:
    watch = PoseWatch(jump=0.1, turn_jump=0.2, settle=5.0)
    assert watch.believes(0.0, Pose(0.0, 0.0, 0.0), LIMITS)
    assert not watch.believes(0.1, pose, LIMITS) and "jumped" in watch.reason
    assert not watch.believes(5.0, pose, LIMITS)
    assert watch.believes(5.2, pose, LIMITS) and not watch.reason


def test_back_where_the_robot_can_be_it_is_believed_soon() -> None:
    watch = PoseWatch(jump=0.1, settle=5.0)
    for now, x in ((0.0, 0.0), (0.1, 1.0), (0.9, 0.0)):
        believed = watch.believes(now, Pose(x, 0.0), LIMITS)
    assert not believed and not watch.believes(1.5, Pose(0.0, 0.0), LIMITS)
    assert watch.believes(2.0, Pose(0.0, 0.0), LIMITS)


def test_poses_that_go_on_jumping_are_not() -> None:
    watch = PoseWatch(jump=0.1, settle=5.0)
    watch.believes(0.0, Pose(0.0, 0.0), LIMITS)
    assert not any(watch.believes(0.5 * tick, Pose(2.0 + tick % 2, 0.0), LIMITS) for tick in range(1, 40))


def test_after_a_gap_it_may_be_as_far_as_it_could_drive() -> None:
    watch = PoseWatch(jump=0.1, settle=1.0)
    watch.believes(0.0, Pose(0.0, 0.0), LIMITS)
    assert watch.believes(10.0, Pose(4.9, 0.0), LIMITS)
    assert not watch.believes(11.0, Pose(6.0, 0.0), LIMITS)


def test_a_clock_that_starts_anew_is_no_reason_to_wait_for_ever() -> None:
    watch = PoseWatch(jump=0.1, settle=1.0)
    watch.believes(100.0, Pose(0.0, 0.0), LIMITS)
    watch.believes(100.1, Pose(5.0, 0.0), LIMITS)
    assert watch.believes(0.0, Pose(5.0, 0.0), LIMITS)
