"""Orders that a new schedule takes over."""

import numpy as np
import pytest

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import Schedule

GOLD = Robot("gold", np.array([(0.0, 5.0), (10.0, 5.0)]))
GREEN = Robot("green", np.array([(5.0, 0.0), (5.0, 10.0)]), depart=3.0)


def former(robot: Robot, begin: float) -> Schedule:
    return Schedule(robot, [0.0, robot.path.length], [begin, begin + 15.0])  # type: ignore[arg-type]


@pytest.mark.parametrize("gold, green, first", [(0.0, 30.0, "gold"), (30.0, 0.0, "green")])
def test_who_went_first_stays_first_whatever_it_costs(gold: float, green: float, first: str) -> None:
    fleet = coordinate([GOLD, GREEN], former=[former(GOLD, gold), former(GREEN, green)])
    assert [window.first for window in fleet.windows] == [first]


def test_without_a_former_schedule_of_both_the_cheaper_order_is_taken() -> None:
    assert coordinate([GOLD, GREEN], former=[former(GREEN, 0.0)]).windows[0].first == "gold"
    assert coordinate([GOLD, GREEN]).windows[0].first == "gold"


def test_what_one_is_committed_to_goes_before_a_former_order() -> None:
    gold = Robot("gold", np.array([(4.0, 5.0), (10.0, 5.0)]), committed=1.5)
    fleet = coordinate([gold, GREEN], former=[former(gold, 50.0), former(GREEN, 0.0)])
    assert fleet.windows[0].first == "gold"
