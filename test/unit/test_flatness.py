"""The tracking law: exact on the reference, back to it from beside it, and harmless at standstill."""

import math

import pytest
from driving import integrate

from social_fleet.execution.config import TrackerConfig
from social_fleet.execution.flatness import ReferenceMotion, track
from social_fleet.execution.state import Command
from social_fleet.geometry import Pose

CONFIG = TrackerConfig()
PERIOD = CONFIG.period


@pytest.mark.parametrize("speed", [0.0, 0.05, 0.15, 0.3, 1.0])
def test_without_error_it_commands_the_reference(speed: float) -> None:
    motion = ReferenceMotion(1.0, 2.0, 0.5, speed, speed, 0.4)
    assert track(Pose(1.0, 2.0, 0.5), speed, motion, PERIOD, CONFIG) == pytest.approx((speed, 0.4), abs=0.4 * (
        speed == 0.0))


@pytest.mark.parametrize("speed", [0.1, 0.3, 0.7])
@pytest.mark.parametrize("offset", [(0.0, 0.1, 0.0), (-0.1, 0.0, 0.0), (0.05, -0.05, 0.4)])
def test_it_comes_back_to_a_moving_reference(speed: float, offset: tuple) -> None:
    pose, command = Pose(*offset), Command(speed, 0.0)
    steps = int(12.0 / PERIOD)
    for index in range(steps):
        motion = ReferenceMotion(index * PERIOD * speed, 0.0, 0.0, speed, speed, 0.0)
        command = Command(*track(pose, command.speed, motion, PERIOD, CONFIG))
        pose = integrate(pose, command, pieces=20)
    assert pose.x == pytest.approx(steps * PERIOD * speed, abs=0.01)
    assert pose.y == pytest.approx(0.0, abs=0.01) and pose.yaw == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize("speed", [0.0, 1e-12, 1e-3])
def test_standstill_is_no_singularity(speed: float) -> None:
    motion = ReferenceMotion(0.02, 0.02, 0.3, speed, speed, 0.0)
    assert all(map(math.isfinite, track(Pose(0.0, 0.0, 0.0), speed, motion, PERIOD, CONFIG)))
    assert abs(track(Pose(0.0, 0.0, 0.0), speed, motion, PERIOD, CONFIG)[1]) < 1.0
