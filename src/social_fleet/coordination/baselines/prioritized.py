"""Prioritized planning: one robot after the other, each round all that were planned before it."""

from typing import Iterator, List, Optional, Set, Tuple

import numpy as np

from social_fleet.coordination.baselines.deadline import Deadline
from social_fleet.coordination.baselines.fleet_planner import FleetPlanner, Ground
from social_fleet.coordination.baselines.traffic import Trajectory, owned
from social_fleet.errors import Infeasible, InvalidParameter

Order = Tuple[int, ...]


class PrioritizedPlanner(FleetPlanner):
    """Robots with longer ways first, as in the paper; where one finds no way, it goes first in the next order.

    Incomplete: no order need lead to a solution even where there is one.

    Parameters
    ----------
    restarts : int
        Orders tried after the first. One that was tried already gives way to a random one.
    seed : int
        Of the random orders.

    References
    ----------
    M. Erdmann and T. Lozano-Perez, "On multiple moving objects", Algorithmica 2, 1987.
    """

    name = "prioritized planning"

    def __init__(self, *, coarsening: int = 4, restarts: int = 50, seed: int = 0) -> None:
        super().__init__(coarsening=coarsening)
        if not isinstance(restarts, int) or isinstance(restarts, bool) or restarts < 0:
            raise InvalidParameter(f"must be a whole number from 0 on, not {restarts!r}", field="restarts")
        self.restarts = restarts
        self.seed = seed

    def _solve(self, ground: Ground, deadline: Deadline) -> Tuple[List[Trajectory], float]:
        orders = _Orders(ground, self.seed)
        for order in orders.first(self.restarts + 1):
            found = _in_order(ground, order, deadline)
            deadline.check(f"{self.name} of {len(order)} robots")
            if len(found) == len(order):
                by_robot = dict(zip(order, found))
                trajectories = [by_robot[index] for index in range(len(order))]
                return trajectories, _gap(ground, trajectories)
            stuck = order[len(found)]
            orders.promote(stuck)
        name = ground.robots[stuck].name
        raise Infeasible(f"{self.name} found no way for {name} round those planned before it, in {self.restarts + 1} "
                         "orders; that does not prove that there is no schedule", robots=[name])


class _Orders:
    """The orders to try, each after the failure of the one before."""

    def __init__(self, ground: Ground, seed: int) -> None:
        ways = [traveller.shortest for traveller in ground.travellers]
        self._order: Order = tuple(sorted(range(len(ways)), key=lambda index: (-ways[index], index)))
        self._tried: Set[Order] = set()
        self._random = np.random.RandomState(seed)

    def first(self, count: int) -> Iterator[Order]:
        for _ in range(count):
            if self._order in self._tried:
                self._order = tuple(self._random.permutation(len(self._order)).tolist())
            self._tried.add(self._order)
            yield self._order

    def promote(self, stuck: int) -> None:
        """Let the robot that found no way go first."""
        self._order = (stuck,) + tuple(index for index in self._order if index != stuck)


def _in_order(ground: Ground, order: Order, deadline: Deadline) -> List[Trajectory]:
    """Motions in the order given, up to the first robot that finds none."""
    found: List[Trajectory] = []
    pieces: List[np.ndarray] = []
    for index in order:
        trajectory: Optional[Trajectory] = ground.travellers[index].search(ground.traffic(pieces), deadline.stop)
        if trajectory is None:
            break
        found.append(trajectory)
        pieces.append(owned(trajectory, index, hard=True))
    return found


def _gap(ground: Ground, trajectories: List[Trajectory]) -> float:
    """Relative distance of the arrivals' sum to what it would be if no robot met another."""
    total = sum(trajectory.arrival for trajectory in trajectories)
    alone = sum(traveller.depart + traveller.shortest / traveller.speed for traveller in ground.travellers)
    return max(total - alone, 0.0) / total if total > 0.0 else 0.0
