"""True motion of a fleet over time: what reports, pictures and animations are made from."""

from array import array
from dataclasses import dataclass
from itertools import chain
from typing import Iterable, List, Optional, Sequence, Tuple, Union

import numpy as np

from social_fleet.errors import InvalidInput

Rows = Union[np.ndarray, Iterable[Sequence[float]]]
"""Numbers of each robot in turn."""


@dataclass(frozen=True)
class Recording:
    """Poses of all robots at common times.

    Attributes
    ----------
    names : tuple of str
        The robots.
    times : (T,) array
        Rising [s].
    poses : (T, R, 3) array
        True x, y, yaw [m, m, rad, map frame], R as in `names`.
    references : (T, R, 2) array, optional
        Where each robot ought to have been [m]; NaN where it had no reference.

    Raises
    ------
    InvalidInput
        When the arrays do not fit together, or times do not rise.
    """

    names: Tuple[str, ...]
    times: np.ndarray
    poses: np.ndarray
    references: Optional[np.ndarray] = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(self.names))
        object.__setattr__(self, "times", np.asarray(self.times, dtype=float))
        object.__setattr__(self, "poses", np.asarray(self.poses, dtype=float))
        count = (len(self.times), len(self.names))
        if self.times.ndim != 1 or not len(self.times) or self.poses.shape != count + (3,):
            raise InvalidInput(f"needs (T,) times with T >= 1 and (T, R, 3) poses, not {self.times.shape} and "
                               f"{self.poses.shape} for {len(self.names)} robots", field="recording")
        if (np.diff(self.times) <= 0.0).any():
            raise InvalidInput("times must rise", field="recording")
        if not (np.isfinite(self.times).all() and np.isfinite(self.poses).all()):
            raise InvalidInput("a time or a pose is not finite", field="recording")
        if self.references is not None and np.shape(self.references) != count + (2,):
            raise InvalidInput(f"references must have shape {count + (2,)}, not {np.shape(self.references)}",
                               field="recording")

    def index(self, name: str) -> int:
        """The place of robot `name` in `poses`."""
        return self.names.index(name)

    @property
    def duration(self) -> float:
        """From the first time to the last [s]."""
        return float(self.times[-1] - self.times[0])


class Recorder:
    """Collects poses sample by sample.

    Parameters
    ----------
    names : sequence of str
        The robots, in the order in which `add` gets them.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self._times: List[float] = []
        self._poses = array("d")
        self._references = array("d")
        self._unknown = [(np.nan, np.nan)] * len(self.names)

    def add(self, time: float, poses: Rows, references: Optional[Rows] = None) -> None:
        """Add one sample: (R, 3) poses, and (R, 2) references where known; a time that does not rise is skipped."""
        if self._times and time <= self._times[-1]:
            return
        self._times.append(time)
        self._poses.extend(chain.from_iterable(poses))
        self._references.extend(chain.from_iterable(self._unknown if references is None else references))

    def __len__(self) -> int:
        return len(self._times)

    def recording(self) -> Recording:
        """What was collected so far."""
        references = np.array(self._references).reshape(-1, len(self.names), 2)
        poses = np.array(self._poses).reshape(-1, len(self.names), 3)
        return Recording(self.names, np.array(self._times), poses,
                         None if not len(references) or np.isnan(references).all() else references)
