"""Corridors of a map, found by code: long straight free stretches with a wall on both sides."""

import math
from typing import List, NamedTuple, Optional, Tuple

import numpy as np

from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.simulation.lidar import cast_rays

DIRECTIONS = 90  # looked at in half a turn
WIDTHS = (1.5, 5.0)  # [m]
TURNS = 3  # directions to either side in which it must not be narrower
EVENNESS = 1.5  # where it is so many times as wide as where it was found, there is an opening
NARROWEST = 0.4  # [m] from the centre line to a wall
SHORTEST = 8.0  # [m]
LONGEST_OPENING = 2.0  # [m] without a wall, such as a door
WALLED = 0.6  # share of the length with a wall on both sides, at least
STEP = 0.1  # [m] along a corridor; less than a wall is thick, so that no door is missed
INSET = 1.0  # [m] from where it ends to where robots start
SPACING = 0.5  # [m] between the places where one may be found
OFF_MIDDLE = 0.2  # share of the width by which such a place may be off its middle


Stretch = Tuple[np.ndarray, np.ndarray, float]  # ends of the centre line in cells, least width [m]


class Corridor(NamedTuple):
    """Ends of the centre line [m, map frame] and the least width [m] along it."""

    start: Tuple[float, float]
    end: Tuple[float, float]
    width: float


def corridors(grid: OccupancyGrid) -> List[Corridor]:
    """All corridors, the longest first, none within another of nearly its direction."""
    walls = np.pad(grid.blocked, 1, constant_values=True)
    rows, columns = np.nonzero(~grid.blocked)
    every = max(round(SPACING / grid.resolution), 1)
    chosen = (rows % every == 0) & (columns % every == 0)
    places = np.column_stack([columns[chosen], rows[chosen]]) + 1.5
    angles = np.arange(2 * DIRECTIONS) * math.pi / DIRECTIONS
    beams = np.stack([cast_rays(walls, place[0], place[1], angles, WIDTHS[1] / grid.resolution) for place in places])
    beams = np.where(np.isfinite(beams), beams * grid.resolution, 2.0 * WIDTHS[1])
    found = []
    widths = beams[:, :DIRECTIONS] + beams[:, DIRECTIONS:]
    narrowest = np.min([np.roll(widths, turn, axis=1) for turn in range(-TURNS, TURNS + 1)], axis=0)
    for index in range(DIRECTIONS):
        left, right = (beams[:, (index + turn * DIRECTIONS // 2) % (2 * DIRECTIONS)] for turn in (1, 3))
        width = left + right
        # A corridor's direction is the one across which it is narrowest.
        middle = (width > WIDTHS[0]) & (width < WIDTHS[1]) & (np.abs(left - right) < OFF_MIDDLE * width)
        middle &= width <= narrowest[:, (index + DIRECTIONS // 2) % DIRECTIONS] + grid.resolution
        across = np.array([-math.sin(angles[index]), math.cos(angles[index])])
        for place, shift in zip(places[middle], 0.5 * (left - right)[middle] / grid.resolution):
            stretch = _stretch(walls, place + shift * across, angles[index], grid.resolution)
            if stretch is not None:
                found.append(stretch)
    found.sort(key=lambda stretch: -np.hypot(*(stretch[1] - stretch[0])))
    kept: List[Stretch] = []
    for stretch in found:
        if not any(_covers(other, stretch, grid.resolution) for other in kept):
            kept.append(stretch)
    return [Corridor(*(tuple(grid.from_local((end[None] - 1.0) * grid.resolution)[0]) for end in stretch[:2]),
                     stretch[2]) for stretch in kept]


def _sides(walls: np.ndarray, place: np.ndarray, angle: float, resolution: float) -> np.ndarray:
    """Distance of the walls on the left and on the right [m], infinite beyond the widest corridor."""
    angles = np.array([angle + 0.5 * math.pi, angle - 0.5 * math.pi])
    return cast_rays(walls, place[0], place[1], angles, WIDTHS[1] / resolution) * resolution


def _stretch(walls: np.ndarray, place: np.ndarray, angle: float, resolution: float) -> Optional[Stretch]:
    """How far the corridor round a place goes: ends of its centre line in cells, and its least width [m]."""
    ends, least, walled = [], np.inf, 0
    own = float(_sides(walls, place, angle, resolution).sum())
    for sense in (-1.0, 1.0):
        step = sense * STEP / resolution * np.array([math.cos(angle), math.sin(angle)])
        here, end, opening = place, place, 0.0
        while opening <= LONGEST_OPENING:
            here = here + step
            if walls[int(here[1]), int(here[0])]:
                break
            left, right = _sides(walls, here, angle, resolution)
            if min(left, right) < NARROWEST or left + right < WIDTHS[0]:
                break
            opening += STEP
            if left + right < EVENNESS * own:
                end, opening, least, walled = here, 0.0, min(least, left + right), walled + 1
        ends.append(end)
    axis = ends[1] - ends[0]
    length = float(np.hypot(*axis)) * resolution
    if length < SHORTEST + 2.0 * INSET or walled * STEP < WALLED * length:
        return None
    inset = INSET / length * axis
    return ends[0] + inset, ends[1] - inset, float(least)


def _covers(other: Stretch, stretch: Stretch, resolution: float) -> bool:
    """Whether half of `stretch` lies along `other`."""
    axis = other[1] - other[0]
    length = np.hypot(*axis)
    axis = axis / length
    own = stretch[1] - stretch[0]
    if abs(axis @ own) < 0.9 * np.hypot(*own):
        return False
    offsets = stretch[0] + np.linspace(0.0, 1.0, 21)[:, None] * own - other[0]
    along, across = offsets @ axis, np.abs(offsets @ np.array([-axis[1], axis[0]]))
    inside = (along > 0.0) & (along < length) & (across * resolution < other[2])
    return bool(inside.mean() > 0.5)
