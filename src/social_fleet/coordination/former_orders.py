"""Orders that a new schedule takes over: of two robots whose former schedules hold, who went first stays first."""

from dataclasses import replace
from typing import Dict, List, Mapping, Sequence, Tuple

from social_fleet.coordination.encounters import Encounter, Order
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import Schedule
from social_fleet.coordination.timing import Timing


class FormerOrders:
    """Knows who went first by schedules that were in force.

    Parameters
    ----------
    schedules : sequence of Schedule
        Of robots that are to keep their order among each other. Arc lengths are along the paths that are coordinated
        now; times may lie in the past.
    """

    def __init__(self, schedules: Sequence[Schedule] = ()) -> None:
        self._timings: Mapping[str, Timing] = {schedule.name: Timing(schedule.arc_lengths, schedule.times)
                                               for schedule in schedules}
        self._chosen: Dict[Tuple[int, Tuple[str, str]], Tuple[Encounter, Encounter]] = {}

    def applied(self, encounters: Sequence[Encounter], robots: Sequence[Robot]) -> List[Encounter]:
        """The windows, those of two robots with former schedules with one order only."""
        return [self._decided(encounter, robots) for encounter in encounters] if self._timings else list(encounters)

    def _decided(self, encounter: Encounter, robots: Sequence[Robot]) -> Encounter:
        names = robots[encounter.r].name, robots[encounter.s].name
        known = names[0] in self._timings and names[1] in self._timings
        if not (known and encounter.r_first.possible and encounter.s_first.possible):
            return encounter
        key = id(encounter), names
        if self._chosen.get(key, (None, None))[0] is not encounter:
            lateness = [self._lateness(order, robots) for order in encounter.orders]
            keeps_r = lateness[0] <= lateness[1]
            loser = "s_first" if keeps_r else "r_first"
            chosen = replace(encounter, **{loser: replace(getattr(encounter, loser), possible=False)})
            self._chosen[key] = encounter, chosen
        return self._chosen[key][1]

    def _lateness(self, order: Order, robots: Sequence[Robot]) -> float:
        """By how much the leader was later than an order asks for at the most [s]; of the order kept, not positive."""
        leader, follower = (self._timings[robots[index].name] for index in (order.leader, order.follower))
        return float((leader.first_time(order.clear) - follower.last_time(order.at)).max())
