"""Where a robot of a crowd could wait until others have passed, and what it reaches from there."""

from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np

from social_fleet.coordination.crowd import ROOM, Crowd
from social_fleet.coordination.replanning import Replanner, nearest_apart, sure_gaps
from social_fleet.geometry import Polyline
from social_fleet.planning.regions import Regions

_NEAREST = 8  # places from which ...
_PLACES = 3  # ... so many are named, ...
_APART = 1.5  # ... and between them, and from where the robot stands [m]
_PASSING = 1.0  # what a way that leads past a place counts like [m]


class WaitingPlaces:
    """Finds places to wait, and tells what is cut off from what.

    Parameters
    ----------
    crowd : Crowd
    replanner : Replanner
    """

    def __init__(self, crowd: Crowd, replanner: Replanner) -> None:
        self._crowd = crowd
        self._replanner = replanner
        self._known: Dict[Tuple[str, float], Tuple[Tuple[int, ...], Regions]] = {}

    def within_reach(self, robot: int, ways: Sequence[Polyline], *, arriving: Optional[int] = None) -> List[np.ndarray]:
        """Places clear of some ways that a robot reaches while all others stand.

        Parameters
        ----------
        robot : int
        ways : sequence of Polyline
        arriving : int, optional
            From where it still gets to its goal when this one stands at its own.

        Returns
        -------
        list of (2,) array
            The best first [m]; empty where there are none.
        """
        room = self._room(robot)
        inside = np.isin(self._regions("standing", robot).holding(room), self._around(robot))
        inside &= self._connected(robot, room)  # for on the other side of a wall is around, too
        return self._best(robot, room[inside], ways, arriving)

    def beyond_others(self, robot: int, ways: Sequence[Polyline], *,
                      arriving: Optional[int] = None) -> List[np.ndarray]:
        """Places that it reaches when those that are still to arrive make way; else as `within_reach`."""
        room = self._room(robot)
        return self._best(robot, room[self._connected(robot, room)], ways, arriving)

    def reaches_goal(self, robot: int) -> bool:
        """Whether there may be a way to its goal round all that stand."""
        return self._regions("standing", robot).of(self._crowd.goals[[robot]])[0] in self._around(robot)

    def shut_out_by(self, robot: int) -> Optional[int]:
        """Who would be cut off from its goal when a robot stands at its own; None when nobody is."""
        crowd = self._crowd
        others = [other for other in crowd.waiting if other != robot]
        for radius in sorted({crowd.robots[other].body_radius for other in others}):
            alike = [other for other in others if crowd.robots[other].body_radius == radius]
            if not self._regions("settled", alike[0]).may_be_cut_by(crowd.disc(alike[0], robot, crowd.goals[robot])):
                continue
            regions = self._after(alike[0], robot)
            here, there = regions.of(crowd.places[alike]), regions.of(crowd.goals[alike])
            lost = np.flatnonzero((here != there) | (here == 0))
            if len(lost):
                return alike[lost[0]]
        return None

    def _best(self, robot: int, room: np.ndarray, ways: Sequence[Polyline],
              arriving: Optional[int]) -> List[np.ndarray]:
        """Of some places the best: clear of the others and of some ways, near, and in few other ways."""
        crowd = self._crowd
        if arriving is not None and arriving != robot:
            regions = self._after(robot, arriving)
            room = room[_in_one_part(regions, room, crowd.goals[robot])]
        others = crowd.others(robot)
        room = room[(np.hypot(*(room[:, None] - crowd.places[others]).T).T
                     >= crowd.distances[robot, others] + ROOM).all(axis=1)]
        room = room[sure_gaps(room, ways) >= crowd.distances[robot].max() + ROOM]
        here = crowd.places[robot]
        places = np.array(nearest_apart(room, here, apart=_APART, most=_NEAREST, besides=[here])).reshape(-1, 2)
        cost = np.hypot(*(places - here).T) + _PASSING * crowd.passing(robot, places)
        return list(places[np.argsort(cost, kind="stable")[:_PLACES]])

    def _around(self, robot: int) -> np.ndarray:
        """The parts that lie round a robot's place, all that stand closed."""
        return self._regions("standing", robot).touching(
            self._crowd.disc(robot, robot, self._crowd.places[robot]))

    def _connected(self, robot: int, room: np.ndarray) -> np.ndarray:
        """Which of some places it could get to round those that have arrived."""
        return _in_one_part(self._regions("settled", robot), room, self._crowd.places[robot])

    def _after(self, robot: int, arriving: int) -> Regions:
        """What robots of one size reach from where when one more stands at its goal."""
        crowd = self._crowd
        discs = [crowd.disc(robot, other, crowd.goals[other]) for other in [*crowd.settled(), arriving]]
        return self._replanner.regions(crowd.robots[robot], discs)

    def _regions(self, closed: str, robot: int) -> Regions:
        """What robots of one size reach from where round all that are `standing` now, or those `settled`."""
        crowd, radius = self._crowd, self._crowd.robots[robot].body_radius
        state = tuple(crowd.waiting) if closed == "settled" else (crowd.turns,)
        if (closed, radius) not in self._known or self._known[closed, radius][0] != state:
            owners = crowd.settled() if closed == "settled" else range(len(crowd.robots))
            discs = [crowd.disc(robot, other, crowd.places[other]) for other in owners]
            self._known[closed, radius] = state, self._replanner.regions(crowd.robots[robot], discs)
        return self._known[closed, radius][1]

    def _room(self, robot: int) -> np.ndarray:
        """Where a robot fits (M, 2) [m]."""
        return self._replanner.standing_room(self._crowd.robots[robot])


def _in_one_part(regions: Regions, room: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Which of some places (M, 2) [m] hang together with one."""
    labels = regions.holding(room)
    return (labels > 0) & (labels == regions.of(place[None])[0])
