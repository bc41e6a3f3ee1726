"""Experiments in cells: independent pieces of work whose values stay on disk, so that one that is stopped goes on.

What is finished stands in NAME.cells in the experiment's folder, a line of JSON each. A line is found again by a digest
of what its value depends on: the experiment, the cell's key and the code. So another seed, map or number of trials
takes up what still holds, and no value of older code is taken for one of today's.
"""

import ast
import fcntl
import functools
import inspect
import json
import os
import sys
from typing import Any, Callable, Dict, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from social_fleet.errors import InvalidInput
from social_fleet.files import PathLike, plain
from social_fleet.planning.cache import digest_of

SUFFIX = ".cells"
Progress = Callable[[int, int], None]  # called with how many cells are done, and of how many
_PACKAGE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))  # the package's own may be a relay of catkin's


class Cell(NamedTuple):
    """A piece of work that no other has to come before.

    Attributes
    ----------
    key : mapping
        Plain values that, with the code, decide the value: the map's digest, seed, trial, size, options.
    compute : callable
        Works the value out: numbers, strings, lists and dicts as JSON has them; NumPy's become such.
    """

    key: Mapping[str, Any]
    compute: Callable[[], Any]


class Work:
    """What an experiment does its work with: it keeps the values of cells, and tells how far it is.

    Parameters
    ----------
    name : str
        Of the experiment.
    module : str
        Full name of the module that the cells are made in; it and all that it imports are the code.
    folder : path, optional
        Where values are kept; without one they are not.
    progress : callable
        Called with cells done and cells in all.
    """

    def __init__(self, name: str, module: str, *, folder: Optional[PathLike] = None,
                 progress: Progress = lambda done, total: None) -> None:
        self.progress = progress
        self._file = None if folder is None else cells_file(name, folder)
        self._code = [name, code_of(module)]

    def values(self, cells: Sequence[Cell], *, before: int = 0, total: Optional[int] = None) -> List[Any]:
        """The values of all `cells`, in their order: those on disk, the others worked out one after the other.

        Parameters
        ----------
        cells : sequence of Cell
            What is to be done; all there is, or, when the next cells depend on these, a part.
        before, total : int
            Of a part: cells done before it, and in all.

        Returns
        -------
        list
            As JSON holds values, whether they were on disk or not: tuples are lists, NaN is None.

        Raises
        ------
        InvalidInput
            When a value cannot be kept.
        """
        digests = [digest_of(self._code, plain(cell.key)) for cell in cells]
        wanted = set(digests)
        known = {} if self._file is None else {digest: value for digest, value in finished(self._file)
                                               if digest in wanted}
        done = before + sum(digest in known for digest in digests)
        total = len(cells) if total is None else total
        self.progress(done, total)
        for digest, cell in zip(digests, cells):
            if digest not in known:
                value = json.loads(json.dumps(plain(_computed(cell)), allow_nan=False))
                if self._file is not None:
                    _keep(self._file, {"cell": digest, "key": plain(cell.key), "value": value})
                known[digest] = value
                done += 1
                self.progress(done, total)
        return [known[digest] for digest in digests]


def _computed(cell: Cell) -> Any:
    """A cell's value. Ctrl-C that strikes while a compiled function hands out its arrays comes as a SystemError."""
    try:
        return cell.compute()
    except SystemError as error:
        cause: Optional[BaseException] = error
        while cause is not None and not isinstance(cause, KeyboardInterrupt):
            cause = cause.__cause__ or cause.__context__
        if cause is not None:
            raise KeyboardInterrupt from error
        raise


def cells_file(name: str, folder: PathLike) -> str:
    """Where an experiment keeps its cells."""
    return os.path.join(os.fspath(folder), name + SUFFIX)


def finished(path: str) -> Iterator[Any]:
    """Digests and values of the cells in a file; none when it is not there. A line that was cut short is left out."""
    try:
        with open(path, encoding="utf-8", errors="replace") as stream:
            lines = stream.readlines()
    except FileNotFoundError:
        return
    for line in lines:
        try:
            entry = json.loads(line)
            yield entry["cell"], entry["value"]
        except (ValueError, TypeError, KeyError):
            continue


def _keep(path: str, entry: Dict[str, Any]) -> None:
    """Add a line in one piece, alone in the file while it does so; one that was cut short before it is ended first."""
    line = json.dumps(entry, ensure_ascii=False).encode() + b"\n"
    try:
        os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
        with open(path, "a+b", buffering=0) as stream:
            fcntl.flock(stream, fcntl.LOCK_EX)
            size = stream.seek(0, os.SEEK_END)
            if size and os.pread(stream.fileno(), 1, size - 1) != b"\n":
                line = b"\n" + line
            if stream.write(line) != len(line):
                raise InvalidInput("a finished cell could not be written: the disk is full", source=path)
    except OSError as error:
        raise InvalidInput(f"a finished cell could not be written: {error.strerror}", source=path) from error


@functools.lru_cache(maxsize=None)
def code_of(module: str) -> str:
    """A digest of a module that is loaded and of all that it imports from this package, pictures aside."""
    source = inspect.getsource(sys.modules[module])
    texts, waiting = {module: source}, list(_imports(ast.parse(source)))
    while waiting:
        name = waiting.pop()
        tree, text = _read(name)
        if name not in texts and not _draws(tree):
            texts[name] = text
            waiting += _imports(tree)
    return digest_of(*sorted(texts.items()))


def _imports(tree: ast.AST) -> Iterator[str]:
    """Modules of this package that a module imports, at its top or within functions."""
    for node in ast.walk(tree):
        names: List[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and not node.level:
            members = [f"{node.module}.{alias.name}" for alias in node.names]
            names = [member if _file(member) else str(node.module) for member in members]
        yield from (name for name in names if _file(name))


def _draws(tree: ast.AST) -> bool:
    """Whether a module is about pictures, and decides no value."""
    return any(isinstance(node, ast.ImportFrom) and str(node.module).startswith("matplotlib")
               for node in ast.walk(tree))


@functools.lru_cache(maxsize=None)
def _read(name: str) -> Tuple[ast.AST, str]:
    with open(_file(name), encoding="utf-8") as stream:
        text = stream.read()
    return ast.parse(text), text


def _file(name: str) -> str:
    """The file of a module of this package; empty when there is none of that name."""
    package, *parts = name.split(".")
    base = os.path.join(_PACKAGE, *parts)
    places = (base + ".py", os.path.join(base, "__init__.py")) if package == "social_fleet" and parts else ()
    return next((place for place in places if os.path.isfile(place)), "")
