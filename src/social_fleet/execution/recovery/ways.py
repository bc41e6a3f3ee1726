"""Which path each robot of an exchange is to drive: what is left of its present one, another, or none."""

import math
from dataclasses import dataclass, field
from typing import Callable, Dict, FrozenSet, List, Mapping, Tuple

import numpy as np

from social_fleet.coordination.robot import Robot
from social_fleet.errors import InvalidGoal, InvalidInput, InvalidStart, NoPath, SocialFleetError
from social_fleet.execution.recovery.decision import Need
from social_fleet.execution.recovery.remaining import Remaining, joined
from social_fleet.geometry import Pose
from social_fleet.planning.overlays.shapes import DiscObstacle
from social_fleet.planning.plan import Plan
from social_fleet.planning.planner import SocialPlanner

_SPARE_CELLS = (0.1, 0.5, 1.0, 2.0)  # tried one after the other
_SMALLEST = 0.05  # radius of an obstacle [m]
_LONGEST_REST = 60.0  # that a robot is expected to stand on at the most [s]


@dataclass
class Request:
    """What is to be planned in one exchange.

    Attributes
    ----------
    version : int
        Of the exchange.
    now : float
        [s].
    remaining : list of Remaining
        All robots that take part.
    need : Need
        Whom to plan anew.
    rests : mapping of str to float
        For how long robots are expected to stand on before they move [s].
    obstacles : mapping of str to DiscObstacle
        What the map does not hold.
    standing : mapping of str to tuple of DiscObstacle
        The places of robots that do not move, by their names: others are led round them.
    doubtful : frozenset of str
        Obstacles where a silent robot may be, but was not seen: driven through where there is no other way, for the
        lidar sees it if it is there.
    silent : frozenset of str
        Those among them that take no part, and cannot be waited for.
    give_up : frozenset of str
        Robots that need not wait any longer for a way to their goals.
    """

    version: int
    now: float
    remaining: List[Remaining]
    need: Need
    rests: Mapping[str, float] = field(default_factory=dict)
    obstacles: Mapping[str, DiscObstacle] = field(default_factory=dict)
    standing: Mapping[str, Tuple[DiscObstacle, ...]] = field(default_factory=dict)
    doubtful: FrozenSet[str] = frozenset()
    silent: FrozenSet[str] = frozenset()
    give_up: FrozenSet[str] = frozenset()


class Ways:
    """Finds the robots' paths.

    Parameters
    ----------
    request : Request
        What is to be planned.
    planner_for : callable
        The planner for robots of a radius [m].

    Attributes
    ----------
    kept : dict of str to Remaining
        Robots that keep their paths, by name.
    reasons : dict of str to str
        Why robots are not led to their goals.
    temporary : list of str
        Robots on detours.
    """

    def __init__(self, request: Request, planner_for: Callable[[float], SocialPlanner]) -> None:
        self.request = request
        self.kept: Dict[str, Remaining] = {}
        self.reasons: Dict[str, str] = {}
        self.temporary: List[str] = []
        self._planner_for = planner_for

    def stays(self, item: Remaining, reason: str) -> Robot:
        """The robot that goes no farther than it has promised to, and why."""
        self.kept.pop(item.report.name, None)
        self.reasons[item.report.name] = reason
        return item.staying(self._depart(item))

    def _depart(self, item: Remaining) -> float:
        return self.request.now + min(self.request.rests.get(item.report.name, 0.0), _LONGEST_REST)

    def _keeps(self, item: Remaining) -> Robot:
        self.kept[item.report.name] = item
        return item.robot(item.way, depart=self._depart(item), goal_yaw=item.goal_yaw)

    def robot(self, item: Remaining) -> Robot:
        """A robot with its path: what is left of the present one where that does, else another, else none."""
        report, name = item.report, item.report.name
        if report.errand is None:
            return item.staying(self._depart(item))
        anew = name in self.request.need.new_paths or report.errand.number != report.serving
        if report.unserved and report.errand.number == report.serving and not anew:
            return self.stays(item, report.unserved)
        if name in self.request.give_up and report.blocked > 0.0:
            return self.stays(item, f"something has held {name} up for {report.blocked:.0f} s, and no way round it "
                                    "helped")
        obstructed = self._obstructed(item)
        if item.schedule is not None and not anew and not obstructed:
            return self._keeps(item)
        try:
            plan = self._planned(item)
        except (NoPath, InvalidInput) as error:
            usable = item.schedule is not None and self._leads_there(item) and not (obstructed & self.request.silent)
            if usable and name not in self.request.give_up:
                return self._keeps(item)
            return self.stays(item, f"{name} has no way to its goal: {getattr(error, 'message', error)}")
        if plan.temporary:
            self.temporary.append(name)
        return item.robot(joined(item.prefix, plan.path), depart=self._depart(item), goal_yaw=plan.goal_yaw)

    def _planned(self, item: Remaining) -> Plan:
        """A path to the goal round all that is known, or at least round what is certain."""
        report = item.report
        assert report.errand is not None
        others = {f"{name} {number}": shape for name, shapes in self.request.standing.items()
                  if name != report.name and name not in self.request.silent  # whose places are among the obstacles
                  for number, shape in enumerate(shapes)}
        overlays = {**self.request.obstacles, **others}
        planner = self._planner_for(report.body.radius)
        certain = {name: shape for name, shape in overlays.items() if name not in self.request.doubtful}
        for attempt in (overlays, certain):
            # it may stand nearer to an obstacle than a plan may begin; and obstacles are blocked cells to the planner
            for cells in _SPARE_CELLS:
                shrunk = {name: _beside(shape, item.end, report.body.radius, cells * planner.grid.resolution)
                          for name, shape in attempt.items()}
                try:
                    return planner.plan(item.end, report.errand.goal, overlays=shrunk)
                except InvalidStart as error:
                    failure: SocialFleetError = error
                except (InvalidGoal, NoPath) as error:
                    failure = error
                    break
        raise failure

    def _obstructed(self, item: Remaining) -> FrozenSet[str]:
        """Robots that stand for good in the way that is left, behind what the robot is committed to."""
        way, radius = item.way, item.report.body.radius
        beyond = way.slice(item.committed, way.length) if way.length > item.committed else None
        if beyond is None:
            return frozenset()
        points = beyond.position(np.linspace(0.0, beyond.length, int(beyond.length / 0.1) + 2))
        return frozenset(
            name for name, shapes in self.request.standing.items() for shape in shapes if name != item.report.name
            and (np.hypot(points[:, 0] - shape.x, points[:, 1] - shape.y) < shape.radius + radius - 0.05).any())

    def _leads_there(self, item: Remaining) -> bool:
        """Whether the present path ends at the goal of the errand."""
        assert item.schedule is not None and item.report.errand is not None
        end, goal = item.schedule.robot.path.points[-1], item.report.errand.goal
        return math.hypot(end[0] - goal[0], end[1] - goal[1]) < 1e-6


def _beside(shape: DiscObstacle, pose: Pose, radius: float, spare: float) -> DiscObstacle:
    """An obstacle no larger than leaves a robot room to stand at `pose`, and `spare` [m] more."""
    room = math.hypot(shape.x - pose.x, shape.y - pose.y) - radius - spare
    return shape if shape.radius <= room else DiscObstacle(shape.x, shape.y, max(room, _SMALLEST))
