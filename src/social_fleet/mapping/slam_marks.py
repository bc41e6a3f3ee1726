"""The marks that a SLAM run leaves on a map of a building: what makes a drawn floor look and behave like a scanned one.

A lidar sees only surfaces, so walls are thin and unknown within. Its map is a little bent, its walls are ragged; single
cells are wrongly occupied, mostly near walls; corners that it looked into too flatly stay unknown; and rays leave
through windows.
"""

from dataclasses import dataclass
from typing import Any, Mapping, Tuple

import numpy as np

from social_fleet.mapping.grid import FREE, OCCUPIED, UNKNOWN
from social_fleet.parameters import from_mapping, parameter


@dataclass(frozen=True)
class SlamMarks:
    """How much of each mark."""

    seed: int = parameter(0, minimum=0)
    bend: float = parameter(0.1, minimum=0.0)  # how far a place is displaced at most, per axis [m]
    bend_wavelength: float = parameter(20.0, above=0.0)  # over which the displacement goes back and forth [m]
    thickening: float = parameter(0.35, minimum=0.0, maximum=1.0)  # share of the walls that are two cells thick
    gaps: float = parameter(0.02, minimum=0.0, maximum=1.0)  # share of the walls' cells that were missed
    fringe: float = parameter(0.04, minimum=0.0, maximum=1.0)  # share of free cells at walls that are occupied
    speckle: int = parameter(0, minimum=0)  # single occupied cells anywhere in the open
    patches: int = parameter(0, minimum=0)  # unknown patches at walls
    patch_radius: float = parameter(0.2, above=0.0)  # of the largest of them [m]
    windows: int = parameter(0, minimum=0)  # through which rays leave
    ray_length: float = parameter(3.0, above=0.0)  # of the longest ray [m]


def bent(places: np.ndarray, marks: Mapping[str, Any]) -> np.ndarray:
    """`places` (2, rows, columns) [m], displaced smoothly along two waves per axis, whose phases the seed gives."""
    settings = from_mapping(SlamMarks, marks, prefix="slam.")
    random = np.random.RandomState(settings.seed)
    number = 2.0 * np.pi / settings.bend_wavelength
    x, y = places
    phases = random.uniform(0.0, 2.0 * np.pi, 4)
    return np.stack([
        x + 0.5 * settings.bend * (np.sin(number * y + phases[0]) + np.sin(0.7 * number * (x + y) + phases[1])),
        y + 0.5 * settings.bend * (np.sin(number * x + phases[2]) + np.sin(0.6 * number * (x - y) + phases[3]))])


def leave_marks(values: np.ndarray, resolution: float, marks: Mapping[str, Any]) -> np.ndarray:
    """A copy of the map `values` (rows, columns), with marks.

    Raises
    ------
    InvalidParameter
        When a setting is unknown or out of its range.
    """
    settings = from_mapping(SlamMarks, marks, prefix="slam.")
    random = np.random.RandomState(settings.seed + 1)
    values = _surfaces(values, settings, random)
    _draw_patches(values, resolution, settings, random)
    _draw_rays(values, resolution, settings, random)
    _draw_speckle(values, settings, random)
    return values


def _surfaces(values: np.ndarray, settings: SlamMarks, random: np.random.RandomState) -> np.ndarray:
    """Walls as a scan has them: one or two ragged cells where free space ends, and nothing known behind."""
    free = values == FREE
    at_free = _grown(free)
    thick = _grown(_noise(values.shape, random) < settings.thickening)
    skin = at_free | (_grown(at_free) & thick & (random.random_sample(values.shape) < 0.7))
    seen = (values == OCCUPIED) & skin & (random.random_sample(values.shape) >= settings.gaps)
    marked = np.full(values.shape, UNKNOWN, dtype=np.int8)
    marked[free] = FREE
    marked[seen] = OCCUPIED
    marked[free & _grown(seen) & (random.random_sample(values.shape) < settings.fringe)] = OCCUPIED
    return marked


def _draw_patches(values: np.ndarray, resolution: float, settings: SlamMarks, random: np.random.RandomState) -> None:
    rows, columns = np.indices(values.shape)
    ragged = 0.4 + 0.6 * _noise(values.shape, random)
    reach = int(settings.patch_radius / resolution) + 1
    walls = np.argwhere(values == OCCUPIED)
    for row, column in walls[random.randint(len(walls), size=settings.patches)]:
        radius = settings.patch_radius / resolution * random.uniform(0.2, 1.0)
        window = slice(max(row - reach, 0), row + reach), slice(max(column - reach, 0), column + reach)
        near = np.hypot(rows[window] - row, columns[window] - column) < radius * ragged[window]
        values[window][near] = UNKNOWN


def _draw_rays(values: np.ndarray, resolution: float, settings: SlamMarks, random: np.random.RandomState) -> None:
    """Fans of rays that go from walls into the unknown; a ray that would come back into free space is left out."""
    walls = np.argwhere(values == OCCUPIED)
    drawn = 0
    for _ in range(100 * settings.windows):
        if drawn == settings.windows:
            return
        start = walls[random.randint(len(walls))] + 0.5
        middle = random.uniform(0.0, 2.0 * np.pi)
        lengths = settings.ray_length * random.uniform(0.2, 1.0, 9)
        angles = middle + random.uniform(-0.35, 0.35, len(lengths))
        rays = [_ray(values, start, angle, length / resolution) for angle, length in zip(angles, lengths)]
        if all(len(ray) and _stays_outside(values[ray[:, 0], ray[:, 1]]) for ray in rays):
            for ray in rays:
                values[ray[:, 0], ray[:, 1]] = FREE
                values[tuple(ray[-1])] = OCCUPIED
            drawn += 1


def _ray(values: np.ndarray, start: np.ndarray, angle: float, length: float) -> np.ndarray:
    """The cells (M, 2) that a ray goes through; none if it leaves the map."""
    steps = np.arange(0.0, length + 1.0, 0.5)[:, None]
    cells = np.floor(start + steps * (np.sin(angle), np.cos(angle))).astype(int)
    if (cells < 0).any() or (cells >= values.shape).any():
        return cells[:0]
    return cells


def _stays_outside(met: np.ndarray) -> bool:
    return (met != FREE).all() and (met == UNKNOWN).mean() > 0.7


def _draw_speckle(values: np.ndarray, settings: SlamMarks, random: np.random.RandomState) -> None:
    free = np.argwhere(values == FREE)
    for row, column in free[random.randint(len(free), size=settings.speckle)]:
        values[row, column] = OCCUPIED


def _grown(mask: np.ndarray) -> np.ndarray:
    """`mask` and its eight neighbours."""
    padded = np.pad(mask, 1, mode="constant")
    rows, columns = mask.shape
    grown = np.zeros_like(mask)
    for row in range(3):
        for column in range(3):
            grown |= padded[row:row + rows, column:column + columns]
    return grown


def _noise(shape: Tuple[int, ...], random: np.random.RandomState) -> np.ndarray:
    """Uniform noise in blocks of 4 x 4 cells: real walls change their thickness in stretches, not cell by cell."""
    rows, columns = (size // 4 + 1 for size in shape)
    coarse = random.random_sample((rows, columns))
    return np.kron(coarse, np.ones((4, 4)))[:shape[0], :shape[1]]
