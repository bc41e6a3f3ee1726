"""Several robots in one place: faults, obstacles, and what each sees of the others."""

import math
from dataclasses import replace

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.coordination.robot import Robot
from social_fleet.errors import InvalidScenario
from social_fleet.simulation.config import LidarConfig
from social_fleet.simulation.faults import CircleObstacle, Fault, pose_shift, speed_share
from social_fleet.simulation.lidar import Lidar
from social_fleet.simulation.world import World

GOLD = Robot("gold", np.array([(1.5, 1.5), (5.5, 1.5)]))
GREEN = Robot("green", np.array([(4.5, 1.5), (4.5, 2.5)]))
HALL = grid_from_text("""
    ########
    #......#
    #......#
    ########
""")


def test_robots_start_at_their_starts() -> None:
    world = World([GOLD, GREEN])
    assert world.poses().tolist() == [[1.5, 1.5, 0.0], [4.5, 1.5, math.pi / 2]]


def test_commands_move_those_they_are_for() -> None:
    world = World([GOLD, GREEN])
    for _ in range(40):
        world.command({"gold": (0.5, 0.0)})
        world.step()
    assert world.now == 2.0 and world.poses()[0, 0] > 2.2 and world.poses()[1].tolist() == [4.5, 1.5, math.pi / 2]


def test_a_pause_stands_and_ends() -> None:
    world, speeds = World([GOLD], faults=[Fault("gold", "pause", 1.0, 2.0)]), {}
    while world.now < 5.0:
        world.command({"gold": (0.5, 0.0)})
        world.step()
        speeds[world.clock.tick] = world.robots["gold"].speed
    assert (speeds[20], speeds[40], speeds[59], speeds[80]) == (0.5, 0.0, 0.0, 0.5)


def test_robots_and_present_obstacles_are_seen() -> None:
    ahead = Lidar(LidarConfig(angle_min=0.0, angle_max=0.01, angle_increment=1.0))
    world = World([GOLD, GREEN], HALL, obstacles=[CircleObstacle(3.0, 1.5, 0.25, 0.1, 0.2)])
    seen = [float(world.scan("gold", ahead)[0])]
    while world.now < 0.3:
        world.step()
        seen.append(float(world.scan("gold", ahead)[0]))
    assert seen == pytest.approx([2.75, 2.75, 1.25, 1.25, 2.75, 2.75, 2.75][:len(seen)])


def test_what_contradicts_itself_is_refused() -> None:
    with pytest.raises(InvalidScenario, match="two robots are named gold"):
        World([GOLD, GOLD])
    with pytest.raises(InvalidScenario, match="no robot blue"):
        World([GOLD], faults=[Fault("blue", "pause", 1.0, 2.0)])
    with pytest.raises(InvalidScenario, match="map"):
        World([GOLD]).scan("gold", Lidar())


@pytest.mark.parametrize("values", [{"kind": "explode"}, {"at": -1.0}, {"duration": math.inf}, {"factor": 0.0}])
def test_a_fault_out_of_range_is_refused(values: dict) -> None:
    with pytest.raises(InvalidScenario) as caught:
        replace(Fault("gold", "slow", 1.0, 1.0), **values)
    assert caught.value.field == next(iter(values))


def test_the_worst_of_several_faults_counts() -> None:
    faults = [Fault("gold", "slow", 0.0, 10.0, 0.5), Fault("gold", "pause", 5.0, 1.0),
              Fault("green", "pause", 0.0, 9.0)]
    assert [speed_share(faults, "gold", now) for now in (1.0, 5.0, 6.0, 10.0)] == [0.5, 0.0, 0.5, 1.0]


@pytest.mark.parametrize("values", [{"radius": 0.0}, {"x": math.nan}, {"appears": 3.0, "disappears": 3.0}])
def test_an_obstacle_out_of_range_is_refused(values: dict) -> None:
    with pytest.raises(InvalidScenario):
        CircleObstacle(**{"x": 1.0, "y": 1.0, "radius": 0.3, **values})


def test_a_jump_is_there_at_once_and_a_drift_comes_and_goes() -> None:
    jump = Fault("gold", "jump", 1.0, 4.0, distance=2.0, direction=0.0)
    drift = replace(jump, kind="drift")
    assert [pose_shift(jump, now)[0] for now in (0.9, 1.0, 4.9, 5.0)] == [0.0, 2.0, 2.0, 0.0]
    assert [pose_shift(drift, now)[0] for now in (1.0, 2.0, 3.0, 4.0, 5.0)] == [0.0, 1.0, 2.0, 1.0, 0.0]


def test_a_lost_robot_knows_no_pose_and_a_shifted_one_a_wrong_one() -> None:
    faults = [Fault("gold", "lost", 0.0, 0.1), Fault("green", "jump", 0.0, 0.1, distance=1.0, direction=0.0)]
    world = World([GOLD, GREEN], faults=faults)
    assert world.localise("gold") is None
    x, y, _ = world.robots["green"].pose
    assert world.localise("green")[:2] == (x + 1.0, y)  # type: ignore[index]
    assert world.befalls("gold", "lost", "dead") and not world.befalls("gold", "dead")


@pytest.mark.parametrize("values, field", [
    ({"robot": "dispatcher", "kind": "pause"}, "kind"), ({"kind": "errand"}, "goal"), ({"goal": (1.0, 2.0)}, "goal"),
    ({"distance": math.nan}, "distance")])
def test_faults_that_make_no_sense_are_refused(values: dict, field: str) -> None:
    with pytest.raises(InvalidScenario) as caught:
        Fault(**{"robot": "gold", "kind": "pause", "at": 1.0, "duration": 2.0, **values})
    assert caught.value.field == field
