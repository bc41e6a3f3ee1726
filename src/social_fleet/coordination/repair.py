"""Other paths where the given ones admit no schedule: round a parked robot, aside, or for all to take turns."""

import logging
from typing import Callable, Dict, FrozenSet, Iterator, List, Optional, Sequence, Set, Tuple

import numpy as np

from social_fleet.coordination.encounters import EncounterFinder
from social_fleet.coordination.options import OUT_OF_TIME
from social_fleet.coordination.replanning import Replanner
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.turn_taking import TurnTaking
from social_fleet.coordination.turns import Turn
from social_fleet.errors import Infeasible, TimedOut
from social_fleet.planning.overlays.discs import Disc

log = logging.getLogger(__name__)

_ROOM = 0.05  # kept beyond the safety distance, so that rounding does not undo a repair [m]
_MANY = 10  # contradictory windows from which on all take turns, rather than that one after the other is mended

Option = Tuple[str, Robot, Tuple[Disc, ...]]
"""What a robot does to let others pass, the robot with that path, and the discs that it now avoids."""


class Repairs:
    """The repairs of one fleet, in order; remembers what was tried, so that it ends.

    Parameters
    ----------
    finder : EncounterFinder
        Knows the safety distance of each pair.
    replanner : Replanner
    feasible : callable
        Whether some robots have a schedule among themselves.
    limit : int
        Greatest number of repairs.
    expired : callable
        Whether to give up a search for turns.

    Attributes
    ----------
    notes : list of str
        What was changed, for people.
    turns : sequence of Turn
        Turns that the paths of now allow; empty where that is not known.
    """

    def __init__(self, finder: EncounterFinder, replanner: Replanner, feasible: Callable[[Sequence[Robot]], bool], *,
                 limit: int, expired: Callable[[], bool]) -> None:
        self._finder = finder
        self._replanner = replanner
        self._feasible = feasible
        self._limit = limit
        self._expired = expired
        self._asked: Dict[str, Robot] = {}
        self._took_turns: FrozenSet[str] = frozenset()
        self._avoided: Dict[str, Tuple[Disc, ...]] = {}
        self._tried: Set[Tuple[str, str, str]] = set()
        self.notes: List[str] = []
        self.turns: Sequence[Turn] = ()

    def mend(self, planned: Sequence[Robot], fleet: Sequence[Robot], error: Infeasible, *,
             contradictions: int) -> List[Robot]:
        """`planned` with one path changed so that the robots named in `error` have a schedule among themselves.

        Where there is no such path, or contradictory windows are many, perhaps many are changed so that all have one.

        Raises
        ------
        Infeasible
            `error` itself, when nothing is left to try.
        TimedOut
            When `expired` says so first.
        """
        if len(self.notes) >= self._limit:
            raise error
        for robot in planned:
            self._asked.setdefault(robot.name, robot)
        one_will_do = error.pairs and contradictions < _MANY  # without pairs, what contradicts what is not known
        mended = self._with_one_changed(planned, fleet, error) if one_will_do else None
        if mended is not None:
            self.turns = ()
            return mended
        mended = self._taking_turns(planned, fleet)
        if mended is None and self._expired():
            raise TimedOut(OUT_OF_TIME) from error
        if mended is None:
            raise error
        return mended

    def _with_one_changed(self, planned: Sequence[Robot], fleet: Sequence[Robot],
                          error: Infeasible) -> Optional[List[Robot]]:
        concerned = [robot for robot in fleet if robot.name in error.robots]
        movable = [robot for robot in planned if robot.name in error.robots]
        best = (self._shortest(self._detours, movable, concerned)
                or self._shortest(self._asides, movable, concerned))
        if best is None:
            return None
        extra, how, changed, avoided = best
        self._avoided[changed.name] = avoided
        self._note(f"{changed.name} {how} ({extra:+.1f} m)")
        return [changed if robot.name == changed.name else robot for robot in planned]

    def may_take_turns(self, planned: Sequence[Robot]) -> bool:
        """Whether these robots have not been asked yet to take turns, and could be."""
        return (self._replanner.leads_anywhere and frozenset(robot.name for robot in planned) != self._took_turns
                and not any(robot.committed is not None for robot in planned))

    def _taking_turns(self, planned: Sequence[Robot], fleet: Sequence[Robot]) -> Optional[List[Robot]]:
        """All on paths that they could drive one after the other; tried once for the same robots."""
        if not self.may_take_turns(planned):
            return None
        self._took_turns = frozenset(robot.name for robot in planned)
        asked = [self._asked[robot.name] for robot in planned]
        search = TurnTaking(asked + list(fleet[len(planned):]), len(planned), self._replanner,
                            self._finder.safety_distance, self._expired)
        found = search.find()
        if found is None:
            return None
        self.turns = search.turns
        extra = sum(after.path.length - before.path.length for before, after in zip(asked, found))
        changed = [after.name for before, after in zip(asked, found) if after is not before]
        self._note(f"{', '.join(changed)} make way in turn ({extra:+.1f} m in all)")
        return found[:len(planned)]

    def _note(self, what: str) -> None:
        self.notes.append(what)
        log.info("repair: %s", what)

    def _shortest(self, ways: Callable[[Robot, Sequence[Robot]], Iterator[Option]], movable: Sequence[Robot],
                  concerned: Sequence[Robot]) -> Optional[Tuple[float, str, Robot, Tuple[Disc, ...]]]:
        """The change of path that helps and costs the least length, with that length [m]."""
        best: Optional[Tuple[float, str, Robot, Tuple[Disc, ...]]] = None
        for robot in movable:
            others = [other for other in concerned if other.name != robot.name]
            for how, changed, avoided in ways(robot, others):
                extra = changed.path.length - robot.path.length
                if (best is None or extra < best[0]) and self._feasible(others + [changed]):
                    best = extra, how, changed, avoided
        return best

    def _detours(self, robot: Robot, others: Sequence[Robot]) -> Iterator[Option]:
        """Paths round where another stands, each tried once."""
        known = self._avoided.get(robot.name, ())
        for other in others:
            discs = self._discs_in_the_way(robot, other)
            choices = [("the start", discs[:1]), ("the goal", discs[1:]), ("start and goal", discs)]
            for what, chosen in choices:
                found = tuple(disc for disc in chosen if disc is not None)
                if len(found) != len(chosen) or not self._first_try(robot, other, what):
                    continue
                changed = self._replanner.detour(robot, known + found)
                if changed is not None:
                    yield f"drives round {what} of {other.name}", changed, known + found

    def _asides(self, robot: Robot, others: Sequence[Robot]) -> Iterator[Option]:
        """Paths by way of a place where the others do not come, tried once."""
        known = self._avoided.get(robot.name, ())
        names = ", ".join(other.name for other in others)
        distance = max(self._finder.safety_distance(robot, other) for other in others)
        if self._first_try(robot, others[0], "aside " + names):
            for changed in self._replanner.aside(robot, others, distance + _ROOM, known):
                yield f"steps aside for {names}", changed, known

    def _first_try(self, robot: Robot, other: Robot, what: str) -> bool:
        key = robot.name, other.name, f"{what} {robot.path.length:.3f} {other.path.length:.3f}"
        if key in self._tried:
            return False
        self._tried.add(key)
        return True

    def _discs_in_the_way(self, robot: Robot, other: Robot) -> List[Optional[Disc]]:
        """Discs round the other's start and goal, None where the robot's path keeps clear of it or starts in it."""
        distance = self._finder.safety_distance(robot, other) + _ROOM
        discs: List[Optional[Disc]] = []
        for x, y in (other.path.points[0], other.path.points[-1]):
            nearest = robot.path.position(robot.path.project((x, y), 0.0, robot.path.length))
            ends = robot.path.points[[0, -1]] - (x, y)
            blocked = np.hypot(*(nearest - (x, y))) < distance <= np.hypot(ends[:, 0], ends[:, 1]).min()
            discs.append(Disc(float(x), float(y), distance) if blocked else None)
        return discs
