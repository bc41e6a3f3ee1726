"""Fleets that coordinate by themselves, for tests of the protocols between robots."""

from typing import Any, List, Optional, Sequence

from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import Schedule
from social_fleet.fleet.in_process import InProcessNetwork
from social_fleet.fleet.messages import Round
from social_fleet.fleet.participant import Participant


def round_of(robots: Sequence[Robot], fixed: Sequence[Schedule] = (), **settings: Any) -> Round:
    """The round in which `robots` plan round what is `fixed`."""
    return Round(settings.pop("version", 1), tuple(robot.name for robot in robots),
                 tuple(schedule.name for schedule in fixed), **settings)


def participants(robots: Sequence[Robot], fixed: Sequence[Schedule] = (), *, round_: Optional[Round] = None,
                 network: Optional[InProcessNetwork] = None, **options: Any) -> List[Participant]:
    """All robots of a round on one network."""
    network = network or InProcessNetwork()
    round_ = round_ or round_of(robots, fixed)
    return [Participant(own, round_, network.join(), **options) for own in [*robots, *fixed]]
