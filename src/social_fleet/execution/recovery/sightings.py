"""What the fleet has seen that the map does not hold, until somebody sees it gone."""

import math
from typing import Dict, Iterable, Mapping, Sequence, Set

from social_fleet.execution.recovery.messages import Report
from social_fleet.planning.overlays.shapes import DiscObstacle

SPARE = 0.1  # what is kept from obstacles, of which one side is seen only [m]
_SAME = 0.3  # what is so close to the disc of a robot is that robot [m]


class Sightings:
    """All robots' obstacles under one roof.

    Attributes
    ----------
    obstacles : dict of str to DiscObstacle
        By name.
    version : int
        Grows whenever one comes, goes or changes.
    """

    def __init__(self) -> None:
        self.obstacles: Dict[str, DiscObstacle] = {}
        self.version = 0
        self._gone: Set[str] = set()
        self._silent = 0

    def hear(self, report: Report) -> None:
        """Take in what a robot sees, and what it sees gone."""
        found = dict(self.obstacles)
        for name in report.cleared:
            if found.pop(name, None) is not None:
                self._gone.add(name)  # for good: who sees something there again gives it another name
        found.update((name, shape) for name, shape in report.obstacles.items() if name not in self._gone)
        if found != self.obstacles:
            self.obstacles = found
            self.version += 1

    def put(self, name: str, shapes: Sequence[DiscObstacle]) -> None:
        """Places where the robot `name`, which is silent, may be, until somebody sees that it is not."""
        self.drop(name)
        self._silent += 1
        self.obstacles.update({f"{name}#{self._silent}/{number}": shape for number, shape in enumerate(shapes)})
        self.version += 1

    def drop(self, name: str) -> None:
        """The robot `name` is heard of again."""
        kept = {key: shape for key, shape in self.obstacles.items() if not key.startswith(f"{name}#")}
        if len(kept) < len(self.obstacles):
            self.obstacles = kept
            self.version += 1

    def beside(self, reports: Iterable[Report]) -> Mapping[str, DiscObstacle]:
        """The obstacles that are no robot of those that report."""
        places = [(report.pose, report.body.radius) for report in reports]
        return {name: DiscObstacle(shape.x, shape.y, shape.radius + SPARE) for name, shape in self.obstacles.items()
                if not any(pose is not None and math.hypot(pose.x - shape.x, pose.y - shape.y) < radius + _SAME
                           for pose, radius in places)}
