"""Files: YAML and JSON read with a clear answer to what is wrong, output that appears whole or not at all."""

import json
import math
import os
import secrets
import stat
import tempfile
from contextlib import contextmanager
from typing import IO, Any, Iterator, Set, Tuple, Type, Union

import numpy as np
import yaml

from social_fleet.errors import InvalidInput

PathLike = Union[str, "os.PathLike[str]"]
PART = ".part"  # the end of the name of a file that is being written
# What parsers raise beside their own exceptions: numbers and dates that are none, brackets without end.
_UNREADABLE = (ValueError, OverflowError, RecursionError)
_unfinished: Set[Tuple[str, int]] = set()  # files that are being written, and by which process


@contextmanager
def atomic_write(path: PathLike, mode: str = "w") -> Iterator[IO[Any]]:
    """Open a file for writing that replaces `path` only when the block ends without an exception.

    A device or pipe (``/dev/stdout``) is written directly. Text is UTF-8.

    Parameters
    ----------
    path
        The file to appear; its folder must exist.
    mode
        ``w`` for text, ``wb`` for bytes.

    Raises
    ------
    InvalidInput
        When the file cannot be created there; `source` is the path.
    """
    if mode not in ("w", "wb"):
        raise ValueError(f"mode must be 'w' or 'wb', not {mode!r}")
    encoding = None if "b" in mode else "utf-8"
    check_writable(path)
    target = os.path.realpath(os.fspath(path))
    if is_special(target):
        with open(os.fspath(path), mode, encoding=encoding) as stream:
            yield stream
        return
    temporary = os.path.join(os.path.dirname(target), f".{secrets.token_hex(8)}{PART}")
    unfinished = temporary, os.getpid()
    _unfinished.add(unfinished)
    try:
        with open(temporary, mode.replace("w", "x"), encoding=encoding) as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        if os.path.exists(target):
            os.chmod(temporary, stat.S_IMODE(os.stat(target).st_mode))
        os.replace(temporary, target)
    except BaseException:
        if os.path.exists(temporary):
            os.unlink(temporary)
        raise
    finally:
        _unfinished.discard(unfinished)


def discard_unfinished() -> None:
    """Remove what `atomic_write` has not finished in this process, which is about to end."""
    for temporary, process in list(_unfinished):
        if process == os.getpid() and os.path.exists(temporary):
            os.unlink(temporary)


def check_writable(path: PathLike) -> None:
    """Find out that `path` cannot be written before long work starts, and leave no trace.

    Raises
    ------
    InvalidInput
        When the folder is missing or closed, or when `path` is a folder.
    """
    target = os.path.realpath(os.fspath(path))
    folder = os.path.dirname(target)
    reason = ""
    if not os.fspath(path):
        reason = "the name is empty; name a file"
    elif os.path.isdir(target) or os.fspath(path).endswith(os.sep):
        reason = "is a folder; name a file in it"
    elif not os.path.isdir(folder):
        reason = f"the folder {folder} does not exist; create it first"
    elif os.path.exists(target) and not os.access(target, os.W_OK):
        reason = "cannot be written: permission denied"
    elif not is_special(target):
        try:
            tempfile.TemporaryFile(dir=folder).close()
        except OSError as error:
            reason = f"cannot be written: {error.strerror}"
    if reason:
        raise InvalidInput(reason, source=os.fspath(path))


def read_yaml(path: PathLike, refuse: Type[InvalidInput] = InvalidInput) -> Any:
    """The value in a YAML file; a key given twice is an error, not an overwrite.

    Raises
    ------
    InvalidInput
        As the subclass `refuse`, when there is no such file or it is not YAML; the message has the line.
    """
    text = _read_text(path, refuse)
    try:
        return yaml.load(text, Loader=_StrictLoader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        place = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
        problem = getattr(error, "problem", None) or str(error).splitlines()[0]
        raise refuse(f"{place}not valid YAML: {problem}", source=os.fspath(path)) from error
    except _UNREADABLE as error:
        raise refuse(f"not valid YAML: {error}", source=os.fspath(path)) from error


def read_json(path: PathLike, refuse: Type[InvalidInput] = InvalidInput) -> Any:
    """The value in a JSON file; NaN and Infinity are errors.

    Raises
    ------
    InvalidInput
        As the subclass `refuse`, when there is no such file or it is not JSON; the message has the line.
    """
    def refuse_constant(name: str) -> None:
        raise refuse(f"not valid JSON: {name} is not a number", source=os.fspath(path))

    try:
        return json.loads(_read_text(path, refuse), parse_constant=refuse_constant)
    except InvalidInput:
        raise
    except json.JSONDecodeError as error:
        raise refuse(f"line {error.lineno}, column {error.colno}: not valid JSON: {error.msg}",
                     source=os.fspath(path)) from error
    except _UNREADABLE as error:
        raise refuse(f"not valid JSON: {error}", source=os.fspath(path)) from error


class _StrictLoader(yaml.SafeLoader):
    """Safe YAML in which a mapping may hold a key only once."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> Any:
        seen = set()
        for key_node, _ in node.value:
            key = key_node.value if isinstance(key_node, yaml.ScalarNode) else None
            if key is not None and key in seen and key != "<<":
                raise yaml.constructor.ConstructorError(None, None, f"the key {key!r} is there twice",
                                                        key_node.start_mark)
            seen.add(key)
        return super().construct_mapping(node, deep=deep)


def _read_text(path: PathLike, refuse: Type[InvalidInput]) -> str:
    source = os.fspath(path)
    try:
        with open(source, encoding="utf-8") as stream:
            return stream.read()
    except FileNotFoundError as error:
        raise refuse("there is no such file", source=source) from error
    except IsADirectoryError as error:
        raise refuse("is a folder, not a file", source=source) from error
    except OSError as error:
        raise refuse(f"cannot be read: {error.strerror}", source=source) from error
    except UnicodeDecodeError as error:
        raise refuse("is not a text file in UTF-8", source=source) from error


def write_json(path: PathLike, value: Any) -> None:
    """Write `value` as JSON, whole or not at all; NumPy values become plain ones.

    Raises
    ------
    InvalidInput
        When the file cannot be created.
    """
    text = dump_json(value)
    with atomic_write(path) as stream:
        stream.write(text + "\n")


def dump_json(value: Any) -> str:
    """`value` as strict JSON text; NumPy values become plain ones, a float that is not finite null."""
    return _layout(plain(value), "\n")


def _layout(value: Any, newline: str) -> str:
    """JSON with a line per key and per record, and lists of plain values on one line."""
    deeper = newline + "  "
    if isinstance(value, dict) and value:
        items = [f"{json.dumps(key, ensure_ascii=False)}: {_layout(item, deeper)}" for key, item in value.items()]
        return "{" + deeper + ("," + deeper).join(items) + newline + "}"
    if isinstance(value, list) and any(isinstance(item, dict) for item in value):
        return "[" + deeper + ("," + deeper).join(_layout(item, deeper) for item in value) + newline + "]"
    return json.dumps(value, allow_nan=False, ensure_ascii=False)


def plain(value: Any) -> Any:
    """`value` made of dict, list, str, int, float, bool and None only, as JSON and YAML hold it."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def is_special(target: str) -> bool:
    """Whether something stands at `target` that is neither file nor folder."""
    try:
        kind = os.stat(target).st_mode
    except OSError:
        return False
    return not (stat.S_ISREG(kind) or stat.S_ISDIR(kind))
