"""Where a robot of a crowd could wait until others have passed, and what it reaches from there.

The parts of the map that hang together when all goals are occupied decide: from the parts round its own goal, or from
the one with most room (the *hub*), a robot can be let in whenever its turn comes.
"""

from typing import Dict, List, Optional, Tuple

import numpy as np

from social_fleet.coordination.crowd import ROOM, Crowd
from social_fleet.coordination.replanning import Replanner, nearest_apart, sure_gaps
from social_fleet.geometry import Polyline
from social_fleet.planning.regions import Regions

_PLACES = 3  # that are named at most, ...
_APART = 1.5  # ... and between them, and from where the robot stands [m]
_PARTS = 25  # of the map in which a place is named, where any will do
_TRIED = 400  # places that are tried for whether others can drive round them


class WaitingPlaces:
    """Finds places to wait, and tells what is cut off from what.

    Parameters
    ----------
    crowd : Crowd
    replanner : Replanner
    attempt : int
        Which part of the map is the hub: 0 for the one with most room.
    """

    def __init__(self, crowd: Crowd, replanner: Replanner, attempt: int) -> None:
        self._crowd = crowd
        self._replanner = replanner
        self._attempt = attempt
        self._hub: Optional[np.ndarray] = None
        self._known: Dict[Tuple[str, float], Tuple[int, Regions]] = {}
        self._gaps: Dict[float, Tuple[np.ndarray, List[Optional[Polyline]]]] = {}

    def at_home(self, places: np.ndarray, robot: int) -> np.ndarray:
        """From which of some places a robot comes to its goal when all others are occupied, or to the hub (M,) bool."""
        if self._hub is None:
            self._hub = self._most_room()
        regions = self._regions("goals", robot)
        own = regions.touching(self._crowd.disc(robot, robot, self._crowd.goals[robot]))
        return np.isin(regions.holding(places), np.append(own, regions.of(self._hub[None])))

    def off_ways(self, robot: int) -> List[np.ndarray]:
        """Places at home that are in nobody's way, nearest first."""
        room = self._room_off_ways(robot, at_home=True)
        here = self._crowd.places[robot]
        return nearest_apart(room, here, apart=_APART, most=_PLACES, besides=[here])

    def beside_passages(self, robot: int) -> List[np.ndarray]:
        """Places at home that others can drive round: what the widest of them reaches still hangs together."""
        room = self._room(robot)[self._within_reach(robot, at_home=True)]
        away = np.hypot(*(room - self._crowd.places[robot]).T)
        widest = self._crowd.widest()
        regions = self._regions("waiting", widest)
        largest = int(np.argmax(np.bincount(regions.holding(self._room(widest)))[1:])) + 1
        chosen: List[np.ndarray] = []
        for place in room[np.argsort(away, kind="stable")[:_TRIED]]:
            disc = self._crowd.disc(widest, robot, place)
            if (all(np.hypot(*(place - other)) >= _APART for other in chosen)
                    and largest in regions.touching(disc) and not regions.may_be_cut_by(disc)):
                chosen.append(place)
                if len(chosen) == _PLACES:
                    break
        return chosen

    def anywhere(self, robot: int) -> List[np.ndarray]:
        """One place in each part that it gets to now where it is in nobody's way, nearest first."""
        room = self._room_off_ways(robot, at_home=False)
        away = np.hypot(*(room - self._crowd.places[robot]).T)
        room, away = room[away > _APART], away[away > _APART]
        room = room[np.argsort(away, kind="stable")]
        nearest = np.unique(self._regions("goals", robot).holding(room), return_index=True)[1]
        return list(room[np.sort(nearest)[:_PARTS]])

    def part(self, robot: int, place: np.ndarray) -> int:
        """The number of the part between the goals that a place lies in; 0 where it is beside one of them."""
        return int(self._regions("goals", robot).holding(place[None])[0])

    def reaches_goal(self, robot: int) -> bool:
        """Whether there may be a way to its goal round all that stand."""
        regions = self._regions("standing", robot)
        return regions.of(self._crowd.goals[[robot]])[0] in self._around(robot)

    def shut_out_by(self, robot: int) -> Optional[int]:
        """Whose place or goal is cut off from the rest when a robot stands at its goal; None when none is."""
        crowd = self._crowd
        places = crowd.places.copy()
        places[robot] = crowd.goals[robot]
        settled = [*crowd.settled(), robot]
        others = [other for other in crowd.waiting if other != robot]
        for radius in sorted({crowd.robots[other].body_radius for other in others}):
            alike = [other for other in others if crowd.robots[other].body_radius == radius]
            if not self._regions("settled", alike[0]).may_be_cut_by(crowd.disc(alike[0], robot, crowd.goals[robot])):
                continue
            regions = self._replanner.regions(crowd.robots[alike[0]], [
                crowd.disc(alike[0], other, places[other]) for other in settled])
            labels = regions.of(np.vstack((places[alike], crowd.goals[alike])))
            lost = np.flatnonzero(labels != np.argmax(np.bincount(labels)))
            if len(lost):
                return alike[lost[0] % len(alike)]
        return None

    def _most_room(self) -> np.ndarray:
        """A place in the part with most room, all goals occupied; of equals, the one in which more robots stand."""
        widest = self._crowd.widest()
        regions = self._regions("goals", widest)
        here = regions.of(self._crowd.places[self._crowd.waiting])
        room = self._room(widest)
        labels = regions.holding(room)
        counts = np.bincount(labels[labels > 0])
        held = np.bincount(here[here > 0], minlength=len(counts))[:len(counts)]
        ranked = [part for part in np.lexsort((held, counts))[::-1] if counts[part]]
        inside = room[labels == ranked[self._attempt % len(ranked)]]
        return inside[np.argmin(np.hypot(*(inside - inside.mean(axis=0)).T))]

    def _regions(self, closed: str, robot: int) -> Regions:
        """What robots of one size reach from where round all `goals`, those, too, that stand aside (`waiting`), all
        that are `standing` now, or those `settled`."""
        crowd, radius = self._crowd, self._crowd.robots[robot].body_radius
        state = {"goals": 0, "settled": len(crowd.waiting)}.get(closed, crowd.turns)
        if (closed, radius) not in self._known or self._known[closed, radius][0] != state:
            owners = crowd.settled() if closed == "settled" else range(len(crowd.robots))
            places = crowd.goals if closed in ("goals", "waiting") else crowd.places
            discs = [crowd.disc(robot, other, places[other]) for other in owners]
            if closed == "waiting":
                discs += [crowd.disc(robot, other, crowd.places[other]) for other in np.flatnonzero(crowd.aside)]
            self._known[closed, radius] = state, self._replanner.regions(crowd.robots[robot], discs)
        return self._known[closed, radius][1]

    def _around(self, robot: int) -> np.ndarray:
        """The parts that a robot reaches when it leaves its place, round those that stand."""
        return self._regions("standing", robot).touching(
            self._crowd.disc(robot, robot, self._crowd.places[robot]))

    def _room(self, robot: int) -> np.ndarray:
        """Where a robot fits (M, 2) [m]."""
        return self._replanner.standing_room(self._crowd.robots[robot])

    def _room_off_ways(self, robot: int, *, at_home: bool) -> np.ndarray:
        crowd = self._crowd
        inside = self._within_reach(robot, at_home=at_home)
        ways = [other for other in crowd.waiting if other != robot]
        away = self._from_ways(robot)[inside][:, ways].min(axis=1, initial=np.inf)
        return self._room(robot)[inside[away >= crowd.distances[robot].max() + ROOM]]

    def _within_reach(self, robot: int, *, at_home: bool) -> np.ndarray:
        """Where of its room a robot could stand now, clear of the others: positions in it."""
        crowd, room = self._crowd, self._room(robot)
        inside = np.isin(self._regions("standing", robot).holding(room), self._around(robot))
        if at_home:
            inside &= self.at_home(room, robot)
        found = np.flatnonzero(inside)
        others = crowd.others(robot)
        away = np.hypot(*(room[found, None] - crowd.places[others]).T).T
        return found[(away >= crowd.distances[robot, others] + ROOM).all(axis=1)]

    def _from_ways(self, robot: int) -> np.ndarray:
        """How far its room is from everybody's way at least (M, R) [m]; kept until a way changes."""
        crowd, radius = self._crowd, self._crowd.robots[robot].body_radius
        room = self._room(robot)
        if radius not in self._gaps:
            self._gaps[radius] = np.full((len(room), len(crowd.robots)), np.inf), [None] * len(crowd.robots)
        away, known = self._gaps[radius]
        for other in crowd.waiting:
            if known[other] is not crowd.ways[other]:
                away[:, other] = sure_gaps(room, [crowd.ways[other]])
                known[other] = crowd.ways[other]
        return away
