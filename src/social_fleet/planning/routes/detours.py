"""Temporary heatmaps: paths round obstacles, kept apart until the obstacles go or turn out to be permanent."""

from typing import Dict, FrozenSet, List, Mapping, Sequence, Tuple

import numpy as np

from social_fleet.planning.overlays.shapes import Shape
from social_fleet.planning.routes.heatmaps import EdgeCounts

_LOOSE = 64  # paths of one group that are kept one by one before they become counts


class Detours:
    """The detours of a fleet, by the set of obstacles that each came near. Not safe to use from several threads.

    A detour round several obstacles is forgotten when any of them goes, and counts like any other path once all of
    them are permanent.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of the map.
    """

    def __init__(self, shape: Tuple[int, int]) -> None:
        self._shape = shape
        self._groups: Dict[FrozenSet[str], _Group] = {}
        self._shapes: Dict[str, Shape] = {}

    def add(self, obstacles: Mapping[str, Shape], edges: np.ndarray) -> None:
        """Keep one path, as `edges_of` gives it, that came near these obstacles."""
        self._shapes.update(obstacles)
        self._groups.setdefault(frozenset(obstacles), _Group(self._shape)).add(edges)

    @property
    def obstacles(self) -> Dict[str, Shape]:
        """Names and shapes of the obstacles that detours went round."""
        return dict(self._shapes)

    def paths(self, name: str) -> int:
        """How many detours came near the obstacle."""
        return sum(group.paths for names, group in self._groups.items() if name in names)

    def counts(self, name: str) -> EdgeCounts:
        """The heatmaps of the obstacle's detours."""
        return EdgeCounts.total(self._shape, [group.counts() for names, group in self._groups.items()
                                              if name in names])

    def forget(self, names: Sequence[str]) -> None:
        """Forget all detours that came near one of these obstacles."""
        gone = set(names)
        self._groups = {key: group for key, group in self._groups.items() if not key & gone}
        self._keep_shapes()

    def release(self, name: str) -> EdgeCounts:
        """The counts of the detours round this obstacle and no other; they are no longer detours then.

        Detours that came near others, too, remain detours round these.
        """
        released = self._groups.pop(frozenset((name,)), None)
        for key in [key for key in self._groups if name in key]:
            group = self._groups.pop(key)
            self._groups.setdefault(key - {name}, _Group(self._shape)).merge(group)
        self._keep_shapes()
        return EdgeCounts.none(self._shape) if released is None else released.counts()

    def _keep_shapes(self) -> None:
        used = frozenset().union(*self._groups) if self._groups else frozenset()
        self._shapes = {name: shape for name, shape in self._shapes.items() if name in used}


class _Group:
    """Paths that came near the same obstacles."""

    def __init__(self, shape: Tuple[int, int]) -> None:
        self.paths = 0
        self._shape = shape
        self._settled = EdgeCounts.none(shape)
        self._loose: List[np.ndarray] = []

    def add(self, edges: np.ndarray) -> None:
        self.paths += 1
        self._loose.append(edges.astype(np.int32))
        if len(self._loose) > _LOOSE:
            self._settled = self.counts()
            self._loose = []

    def merge(self, other: "_Group") -> None:
        self._settled = EdgeCounts.total(self._shape, [self.counts(), other.counts()])
        self._loose = []
        self.paths += other.paths

    def counts(self) -> EdgeCounts:
        ones = [EdgeCounts(self._shape, edges.astype(np.int64), np.ones(len(edges), dtype=np.uint16))
                for edges in self._loose]
        return EdgeCounts.total(self._shape, [self._settled, *ones])
