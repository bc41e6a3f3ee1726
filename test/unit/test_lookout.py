"""Where obstacles block a path."""

import math

import pytest
from driving import schedule_of

from social_fleet.scenario.lookout import Lookout
from social_fleet.simulation.faults import CircleObstacle

ROBOT = schedule_of([(0, 0), (20, 0)]).robot


def test_the_horizon_is_before_the_obstacle_while_it_is_there_and_in_sight() -> None:
    lookout = Lookout(ROBOT, [CircleObstacle(10.0, 0.2, 0.3, appears=5.0, disappears=9.0)])
    assert lookout.horizon(4.0, 8.0) == math.inf
    assert lookout.horizon(6.0, 8.0) == pytest.approx(10.0 - math.sqrt(0.65 ** 2 - 0.2 ** 2), abs=0.06)
    assert lookout.horizon(6.0, 1.0) == math.inf
    assert lookout.horizon(6.0, 11.0) == math.inf
    assert lookout.horizon(9.0, 8.0) == math.inf


def test_beside_the_path_nothing_is_blocked() -> None:
    assert Lookout(ROBOT, [CircleObstacle(10.0, 2.0, 0.3)]).horizon(0.0, 8.0) == math.inf
