"""The obstacles that are there now, under names, each until a time, until it is removed, or for good."""

import math
import threading
from dataclasses import dataclass, field, replace
from typing import Dict, Mapping, Optional, Sequence, Tuple, Union

from social_fleet.errors import InvalidOverlay
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.overlays.raster import rasterised
from social_fleet.planning.overlays.shapes import Shape


@dataclass(frozen=True)
class Overlay:
    """One obstacle.

    Attributes
    ----------
    name : str
        Unique among the obstacles of a planner.
    shape : Shape
        What it covers.
    expires : float, optional
        Time [s] from which it counts as gone; None: never by itself.
    permanent : bool
        Plans near it are no detours: routes round it are learnt like any others.
    robot : str
        Only this robot's plans go round it; empty: everybody's.
    """

    name: str
    shape: Shape
    expires: Optional[float] = field(default=None, compare=False)
    permanent: bool = False
    robot: str = ""


class OverlaySet:
    """Obstacles on one map. Safe to use from several threads.

    Parameters
    ----------
    grid : OccupancyGrid
        The map.

    Attributes
    ----------
    version : int
        Grows whenever an obstacle comes, goes, or becomes permanent; a longer life alone does not count.
    """

    def __init__(self, grid: OccupancyGrid) -> None:
        self.grid = grid
        self.version = 0
        self._lock = threading.Lock()
        self._by_name: Dict[str, Overlay] = {}
        self._all: Tuple[Overlay, ...] = ()

    def __len__(self) -> int:
        return len(self._all)

    @property
    def all(self) -> Tuple[Overlay, ...]:
        """The obstacles in the order in which they came; the same object until something changes."""
        return self._all

    def get(self, name: str) -> Optional[Overlay]:
        """The obstacle `name`, None when there is none."""
        return self._by_name.get(name)

    def of(self, robot: str) -> Tuple[Overlay, ...]:
        """Those of `all` that plans of `robot` go round."""
        return tuple(overlay for overlay in self._all if overlay.robot in ("", robot))

    def add(self, name: str, shape: Shape, *, expires: Optional[float] = None, robot: str = "") -> None:
        """Put an obstacle there; it takes the place of one with the same name.

        The same shape again means a longer life: what is permanent stays so.

        Raises
        ------
        InvalidOverlay
            When the name is empty, the time is not finite, or the shape lies off the map; `field` says which.
        """
        if not isinstance(name, str) or not name.strip():
            raise InvalidOverlay(f"an obstacle needs a name, not {name!r}", field="name")
        if expires is not None and not math.isfinite(expires):
            raise InvalidOverlay(f"must be a finite time in seconds, not {expires!r}", field="expires")
        rasterised(self.grid, shape)
        with self._lock:
            known = self._by_name.get(name)
            if known is None or (known.shape, known.robot) != (shape, robot):
                self._put(Overlay(name, shape, expires, robot=robot), changed=True)
            elif not known.permanent:
                self._put(replace(known, expires=expires), changed=False)

    def remove(self, name: str) -> None:
        """Take an obstacle away.

        Raises
        ------
        InvalidOverlay
            When there is none of that name.
        """
        with self._lock:
            if name not in self._by_name:
                there = ", ".join(sorted(self._by_name)) or "none at all"
                raise InvalidOverlay(f"there is no obstacle '{name}'; there is {there}", field="name")
            self._drop((name,))

    def clear(self) -> Tuple[str, ...]:
        """Take all obstacles away; returns their names."""
        with self._lock:
            return self._drop(tuple(self._by_name))

    def expire(self, now: float) -> Tuple[str, ...]:
        """Take away what expires at `now` [s] or before; returns the names."""
        with self._lock:
            return self._drop(tuple(name for name, overlay in self._by_name.items()
                                    if overlay.expires is not None and overlay.expires <= now))

    def make_permanent(self, name: str) -> None:
        """Let an obstacle stay for good; nothing happens when there is none of that name."""
        with self._lock:
            if name in self._by_name:
                self._put(replace(self._by_name[name], expires=None, permanent=True), changed=True)

    def moved_to(self, grid: OccupancyGrid) -> Tuple["OverlaySet", Tuple[str, ...]]:
        """The obstacles on another map in the same frame, and the names of those that lie off it."""
        moved, lost = OverlaySet(grid), []
        for overlay in self._all:
            try:
                rasterised(grid, overlay.shape)
            except InvalidOverlay:
                lost.append(overlay.name)
            else:
                moved._put(overlay, changed=True)
        return moved, tuple(lost)

    def _put(self, overlay: Overlay, *, changed: bool) -> None:
        # A new dictionary each time: readers need no lock.
        self._by_name = {**self._by_name, overlay.name: overlay}
        self._refresh(changed)

    def _drop(self, names: Tuple[str, ...]) -> Tuple[str, ...]:
        if names:
            self._by_name = {name: overlay for name, overlay in self._by_name.items() if name not in names}
            self._refresh(True)
        return names

    def _refresh(self, changed: bool) -> None:
        self._all = tuple(self._by_name.values())
        self.version += changed


Overlays = Union[OverlaySet, Mapping[str, Shape], Sequence[Union[Overlay, Shape]]]
"""What a planner takes as obstacles: a set, some of a set, shapes by name, or just shapes."""


def as_overlays(given: Overlays) -> Tuple[Overlay, ...]:
    """Obstacles one by one; shapes without names are called ``obstacle 1`` and so on."""
    if isinstance(given, OverlaySet):
        return given.all
    if isinstance(given, Mapping):
        return tuple(Overlay(name, shape) for name, shape in given.items())
    return tuple(item if isinstance(item, Overlay) else Overlay(f"obstacle {number}", item)
                 for number, item in enumerate(given, start=1))
