"""What all experiments share: maps to run on, a number of trials, a seed, and a result in three files."""

import csv
import io
import os
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Sequence, Tuple

from matplotlib.figure import Figure

from social_fleet.errors import InvalidInput, InvalidParameter
from social_fleet.experiments.cells import Progress, Work, cells_file
from social_fleet.files import PathLike, atomic_write, check_writable, dump_json
from social_fleet.mapping.files import load_map
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.locations import package_folder
from social_fleet.scenario.pictures.style import save_figure

Row = Dict[str, Any]
ENDINGS = (".json", ".csv", ".png")


@dataclass(frozen=True)
class World:
    """A map with the name that tables and pictures give it."""

    name: str
    grid: OccupancyGrid

    @classmethod
    def from_file(cls, path: PathLike) -> "World":
        """The map of a map_server file, named after the file."""
        return cls(os.path.splitext(os.path.basename(os.fspath(path)))[0], load_map(path))

    @classmethod
    def of_package(cls, name: str) -> "World":
        """A map that comes with the package, such as ``environment_1``."""
        return cls.from_file(os.path.join(package_folder(), "maps", f"{name}.yaml"))

    def is_package(self, name: str) -> bool:
        """Whether it is that map of the package."""
        return self.grid == World.of_package(name).grid


@dataclass(frozen=True)
class Result:
    """What an experiment found.

    Attributes
    ----------
    name : str
        Of the experiment, and of its files.
    caption : str
        What was done and what is to be seen, in sentences.
    rows : list of dict
        The table: the same keys in every row, numbers in SI units; None where there is no value.
    settings : dict
        Maps, trials, seed and whatever else decides the numbers.
    figure : Figure
        The picture.
    details : dict
        What does not fit into the table.
    """

    name: str
    caption: str
    rows: List[Row]
    settings: Dict[str, Any]
    figure: Figure
    details: Dict[str, Any] = field(default_factory=dict)

    def to_dict(self) -> Dict[str, Any]:
        """The content of NAME.json."""
        return {"experiment": self.name, "caption": self.caption, "settings": self.settings, "rows": self.rows,
                **self.details}


class Experiment(ABC):
    """One table or figure of the paper.

    Attributes
    ----------
    name : str
        On the command line.
    trials : int
        Random pairs or paths, unless the user says otherwise.
    maps : tuple of str
        Maps of the package that it runs on.
    adds_maps : bool
        Whether the user's maps come beside these, or in their stead.
    limit : float, optional
        Wall time that a method has for one solve [s], unless the user says otherwise; None where there is no limit.
    """

    name: str
    trials: int
    maps: Tuple[str, ...]
    adds_maps = True
    limit: Optional[float] = None

    def worlds(self, own: Sequence[PathLike] = (), *, only: bool = False) -> List[World]:
        """The maps to run on.

        Parameters
        ----------
        own : sequence of paths
            The user's map files.
        only : bool
            Leave out those of the package even where `own` would come beside them.

        Raises
        ------
        InvalidInput
            When `only` leaves none, or a map comes twice or cannot be read.
        """
        if only and not own:
            raise InvalidInput("leaves no map to run on; give one with --map", field="--only")
        worlds = [] if own and (only or not self.adds_maps) else [World.of_package(name) for name in self.maps]
        worlds += [World.from_file(path) for path in own]
        names = [world.name for world in worlds]
        for name in names:
            if names.count(name) > 1:
                raise InvalidInput(f"{name} comes twice; rename one of the files, or leave one out", field="--map")
        if not self.adds_maps and len(worlds) > 1:
            raise InvalidInput(f"{self.name} draws one map, not {len(worlds)}", field="--map")
        return worlds

    def run(self, worlds: Sequence[World], *, trials: int, seed: int, folder: Optional[PathLike] = None,
            progress: Progress = lambda done, total: None) -> Result:
        """Run it.

        Parameters
        ----------
        worlds : sequence of World
            Maps; see `worlds`.
        trials : int
            Pairs or paths per map.
        seed : int
            Same seed, same result, times aside.
        folder : path, optional
            Where the values of finished cells are kept, and found by the next run; see `cells`.
        progress : callable
            Called with how much is done, and of how much.

        Raises
        ------
        InvalidParameter
            When there are no trials or the seed is negative.
        InvalidInput
            When a map has no room for a robot and a goal, or the folder cannot be written.
        """
        for value, least, name in ((trials, 1, "trials"), (seed, 0, "seed")):
            if value < least:
                raise InvalidParameter(f"must be at least {least}, not {value}", field=name)
        work = Work(self.name, type(self).__module__, folder=folder, progress=progress)
        return self._run(worlds, trials, seed, work)

    @abstractmethod
    def _run(self, worlds: Sequence[World], trials: int, seed: int, work: Work) -> Result:
        """What `run` does, with arguments that are checked; what takes long is done in cells, by `work.values`."""


def files_of(name: str, folder: PathLike) -> List[str]:
    """The files that a result is written to."""
    return [os.path.join(os.fspath(folder), name + ending) for ending in ENDINGS]


def check_folder(name: str, folder: PathLike) -> None:
    """Find out that results cannot be written before they are computed; a folder that is not there must be creatable.

    Raises
    ------
    InvalidInput
        With the path as its source.
    """
    if os.path.isdir(folder):
        for path in [*files_of(name, folder), cells_file(name, folder)]:
            check_writable(path)
    elif os.path.exists(folder):
        raise InvalidInput("is a file; name a folder", source=os.fspath(folder))
    else:
        check_writable(os.path.abspath(folder))


def write_result(result: Result, folder: PathLike) -> List[str]:
    """Write NAME.json, NAME.csv and NAME.png, each whole or not at all, and return their paths.

    Raises
    ------
    InvalidInput
        When a file cannot be created.
    """
    check_folder(result.name, folder)
    document, table = dump_json(result.to_dict()) + "\n", csv_text(result.rows)
    os.makedirs(folder, exist_ok=True)
    paths = files_of(result.name, folder)
    save_figure(result.figure, paths[2])
    for path, text in zip(paths, (document, table)):
        with atomic_write(path) as stream:
            stream.write(text)
    return paths


def csv_text(rows: Sequence[Row]) -> str:
    """A header and a line per row; empty where there is no value."""
    stream = io.StringIO()
    writer = csv.DictWriter(stream, fieldnames=list(rows[0]) if rows else [], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return stream.getvalue()
