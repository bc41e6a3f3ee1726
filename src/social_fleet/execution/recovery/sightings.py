"""What the fleet has seen that the map does not hold, until somebody sees it gone."""

import math
from typing import Dict, FrozenSet, Iterable, Mapping, Sequence, Set, Tuple

from social_fleet.execution.recovery.messages import Report
from social_fleet.planning.overlays.shapes import DiscObstacle

_DOUBT = 30.0  # after so long a silent robot need not be where nobody has looked [s]
SPARE = 0.1  # what is kept from obstacles, of which one side is seen only [m]


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
        self._silent_since: Dict[str, float] = {}

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

    def put(self, name: str, shapes: Sequence[DiscObstacle], now: float) -> None:
        """Places where the robot `name`, silent at `now` [s], may be, until somebody sees that it is not."""
        self.drop(name)
        self._silent_since[name] = now
        self._silent += 1
        self.obstacles.update({f"{name}#{self._silent}/{number}": shape for number, shape in enumerate(shapes)})
        self.version += 1

    def doubtful(self, now: float) -> FrozenSet[str]:
        """Names of places where one that has long been silent may be, all but the one that it last reported."""
        return frozenset(key for key in self.obstacles if "#" in key and not key.endswith("/0")
                         and now - self._silent_since[key.split("#")[0]] >= _DOUBT)

    def places(self, name: str) -> Tuple[DiscObstacle, ...]:
        """Where the robot `name`, which is silent, may be."""
        return tuple(shape for key, shape in self.obstacles.items() if key.startswith(f"{name}#"))

    def drop(self, name: str) -> None:
        """The robot `name` is heard of again."""
        kept = {key: shape for key, shape in self.obstacles.items() if not key.startswith(f"{name}#")}
        if len(kept) < len(self.obstacles):
            self.obstacles = kept
            self.version += 1

    def beside(self, reports: Iterable[Report]) -> Mapping[str, DiscObstacle]:
        """The obstacles that are no robot of those that report: none has its middle in a robot."""
        places = [(report.pose, report.body.radius) for report in reports]
        return {name: DiscObstacle(shape.x, shape.y, shape.radius + SPARE) for name, shape in self.obstacles.items()
                if not any(pose is not None and math.hypot(pose.x - shape.x, pose.y - shape.y) < radius
                           for pose, radius in places)}
