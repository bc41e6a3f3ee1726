"""The simulated robot: exact arcs, limits as physics, odometry of its own."""

import math

import numpy as np
import pytest
from driving import integrate

from social_fleet.coordination.robot import MotionLimits
from social_fleet.execution.state import Command
from social_fleet.geometry import Pose
from social_fleet.simulation.clock import TickClock
from social_fleet.simulation.localisation import Localisation
from social_fleet.simulation.robot import DifferentialDriveRobot, along_arc


def test_a_full_circle_ends_where_it_began() -> None:
    pose = Pose(1.0, 2.0, 0.3)
    for _ in range(100):
        pose = along_arc(pose, 0.05, 2.0 * math.pi / 100)
    assert pose == pytest.approx((1.0, 2.0, 0.3), abs=1e-12)


@pytest.mark.parametrize("speed, turn_rate", [(0.5, 0.0), (0.5, 1.0), (0.0, -1.0), (0.3, 1e-7)])
def test_arcs_agree_with_small_steps(speed: float, turn_rate: float) -> None:
    small = integrate(Pose(0.0, 0.0, 1.0), Command(speed, turn_rate), period=1.0, pieces=20000)
    assert along_arc(Pose(0.0, 0.0, 1.0), speed, turn_rate) == pytest.approx(small, abs=1e-4)


def test_the_drive_cannot_do_more_than_its_limits() -> None:
    robot = DifferentialDriveRobot("gold", Pose(0.0, 0.0, 0.0), limits=MotionLimits(0.7, 1.0, 1.5, 3.0))
    velocities = [(0.0, 0.0)]
    for tick in range(80):
        robot.command(*((9.0, 9.0) if tick < 40 else (-9.0, -9.0)))
        robot.step(0.05)
        velocities.append((robot.speed, robot.turn_rate))
    steps = np.abs(np.diff(velocities, axis=0)).max(axis=0)
    assert np.abs(velocities).max(axis=0) == pytest.approx((0.7, 1.5)) and steps == pytest.approx((0.05, 0.15))


def test_stuck_it_stops_and_loses_nothing_else() -> None:
    robot = DifferentialDriveRobot("gold", Pose(0.0, 0.0, 0.0))
    robot.command(0.5, 0.0)
    for share, speed in ((1.0, 0.5), (0.0, 0.0), (0.5, 0.25)):
        robot.speed_share = share
        for _ in range(20):
            robot.step(0.05)
        assert robot.speed == pytest.approx(speed)


def test_without_news_it_brakes_to_a_stop() -> None:
    robot = DifferentialDriveRobot("gold", Pose(0.0, 0.0, 0.0), command_timeout=0.5)
    speeds = []
    for tick in range(60):
        if tick <= 20:
            robot.command(0.5, 0.2)
        robot.step(0.05)
        speeds.append(robot.speed)
    assert speeds[20:30] == pytest.approx([0.5] * 10)  # half a second from the last command on
    assert speeds[30:40] == pytest.approx([0.45 - 0.05 * step for step in range(10)])
    assert set(speeds[40:]) == {0.0} and robot.turn_rate == 0.0
    robot.command(0.5, 0.0)
    robot.step(0.05)
    assert robot.speed == pytest.approx(0.05)


def test_odometry_is_the_truth_from_its_own_origin_or_drifts_by_its_seed() -> None:
    def drive(noise: float, seed: int) -> DifferentialDriveRobot:
        robot = DifferentialDriveRobot("gold", Pose(3.0, 4.0, math.pi / 2), odometry_noise=noise, seed=seed)
        robot.command(0.5, 0.1)
        for _ in range(100):
            robot.step(0.05)
        return robot
    exact = drive(0.0, 0)
    assert exact.pose == pytest.approx((3.0 - exact.odometry.y, 4.0 + exact.odometry.x,
                                        math.pi / 2 + exact.odometry.yaw))
    assert drive(0.05, 1).odometry == drive(0.05, 1).odometry != drive(0.05, 2).odometry
    assert drive(0.05, 1).pose == exact.pose and drive(0.05, 1).odometry != exact.odometry


def test_localisation_errs_within_its_bounds_and_not_at_random() -> None:
    def errors(seed: int) -> np.ndarray:
        localisation = Localisation(0.05, 0.03, seed=seed, name="gold")
        return np.array([localisation.estimate(Pose(1.0, 2.0, 0.0), 0.05) for _ in range(4000)]) - (1.0, 2.0, 0.0)
    found = errors(3)
    assert 0.03 < np.hypot(found[:, 0], found[:, 1]).max() <= 0.05 + 1e-12
    assert 0.02 < np.abs(found[:, 2]).max() <= 0.03
    assert (found == errors(3)).all() and (found != errors(4)).any()
    assert Localisation().estimate(Pose(1.0, 2.0, 3.0), 0.05) == (1.0, 2.0, 3.0)


def test_the_clock_does_not_drift() -> None:
    clock = TickClock(0.05)
    for _ in range(20 * 3600):
        clock.advance()
    assert clock.now == 3600.0
