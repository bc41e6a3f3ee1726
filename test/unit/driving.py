"""Schedules written by hand, and a plant that shares nothing with the simulation."""

import math
from typing import Any, List, Sequence, Tuple, Union

import numpy as np

from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import FleetSchedule, Precedence, Schedule
from social_fleet.coordination.timing import nominal_timing
from social_fleet.execution.state import Command
from social_fleet.execution.tracker import Tracker
from social_fleet.geometry import Pose

PERIOD = 0.05


def schedule_of(points: Union[np.ndarray, Sequence[Sequence[float]]], *, name: str = "gold",
                precedences: Sequence[Precedence] = (), wait: float = 0.0, **options: Any) -> Schedule:
    """The fastest schedule along `points` [m], begun after `wait` seconds."""
    robot = Robot(name, np.array(points, dtype=float), **options)
    timing = nominal_timing(robot.path, robot.limits, start_yaw=robot.start_yaw, goal_yaw=robot.goal_yaw)
    return Schedule(robot, timing.arc_lengths, timing.times + robot.depart + wait, tuple(precedences))


def crossing() -> FleetSchedule:
    """Gold drives east, green north, and green goes second: gold's 6 m clear its crossing at (5, 5)."""
    gold = schedule_of([(0, 5), (10, 5)], name="gold")
    green = schedule_of([(5, 0), (5, 10)], name="green", wait=4.0, precedences=[Precedence(4.0, "gold", 6.0)])
    return FleetSchedule((gold, green))


def integrate(pose: Pose, command: Command, period: float = PERIOD, pieces: int = 200) -> Pose:
    """The unicycle's equations in many small steps."""
    x, y, yaw = pose
    for _ in range(pieces):
        x += command.speed * math.cos(yaw) * period / pieces
        y += command.speed * math.sin(yaw) * period / pieces
        yaw += command.turn_rate * period / pieces
    return Pose(x, y, yaw)


def drive(tracker: Tracker, pose: Pose, *, limit: float = 120.0) -> Tuple[np.ndarray, List[Command], List[float]]:
    """Let the tracker drive until it has arrived: poses (T, 3), commands, tracking errors."""
    poses, errors = [pose], []
    commands: List[Command] = []
    while not tracker.arrived and len(commands) * PERIOD < limit:
        commands.append(tracker.step(len(commands) * PERIOD, pose, {}))
        errors.append(tracker.tracking_error)
        pose = integrate(pose, commands[-1])
        poses.append(pose)
    return np.array(poses), commands, errors
