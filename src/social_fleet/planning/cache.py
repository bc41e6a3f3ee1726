"""A cache on disk for arrays that take long to work out: what a planner precomputes for a map.

Every file is named by a digest of all that its content depends on, so it is right or not there. It appears whole by a
rename, so two processes that write it at once do no harm; one that was cut short later is found out by its size.
"""

import functools
import hashlib
import inspect
import json
import logging
import math
import mmap
import os
import time
from contextlib import suppress
from types import ModuleType
from typing import IO, Any, Callable, Dict, Mapping, Tuple

import numpy as np

from social_fleet.errors import InvalidInput
from social_fleet.files import PART, atomic_write

log = logging.getLogger(__name__)

FOLDER = "SOCIAL_FLEET_CACHE"  # the environment variable that names the folder; empty: no cache
FORMAT, VERSION = "social_fleet arrays", 1
LARGEST = 1 << 30  # [bytes] of all files together; those that were used longest ago go first
UNUSED = 30.0 * 86400.0  # [s] without use after which a file goes: those of maps and code that are no more
ALIGNMENT = 64  # [bytes]
SUFFIX = ".arrays"


def cache_folder() -> str:
    """Where the files lie: $SOCIAL_FLEET_CACHE, else social_fleet in the user's cache folder; empty for nowhere."""
    default = os.path.join(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "social_fleet")
    return os.environ.get(FOLDER, default)


def digest_of(*parts: Any) -> str:
    """A digest (hex) of arrays, and of other values by their JSON."""
    digest = hashlib.blake2b(digest_size=16)
    for part in parts:
        if isinstance(part, np.ndarray):
            header: Any = [part.dtype.str, part.shape]
            content = np.ascontiguousarray(part).data.cast("B") if part.size else b""
        else:
            header, content = part, b""
        digest.update(json.dumps(header, sort_keys=True).encode() + b"\0")
        digest.update(content)
    return digest.hexdigest()


@functools.lru_cache(maxsize=None)
def source_of(*modules: ModuleType) -> str:
    """A digest of the modules' text: what they compute may change when it does."""
    return digest_of(*(inspect.getsource(module) for module in modules))


def cached(kind: str, digest: str, compute: Callable[[], Mapping[str, np.ndarray]]) -> Dict[str, np.ndarray]:
    """Arrays by name from the cache, or worked out and put there.

    A file that cannot be used is worked out anew, and one that cannot be written is done without; the log says which.

    Parameters
    ----------
    kind : str
        What it is, the first part of the file's name.
    digest : str
        Of all that the arrays depend on.
    compute : callable
        Works them out.
    """
    folder = cache_folder()
    if not folder:
        return dict(compute())
    path = os.path.join(folder, f"{kind}-{digest}{SUFFIX}")
    try:
        arrays = _read(path)
        with suppress(OSError):  # a folder that others keep may be closed
            os.utime(path)  # when it was used
        return arrays
    except FileNotFoundError:
        pass
    except (OSError, ValueError) as error:
        log.warning("the cache file %s is made anew: %s", path, error)
    arrays = dict(compute())
    try:
        os.makedirs(folder, exist_ok=True)
        with atomic_write(path, "wb") as stream:
            _write(stream, arrays)
        _tidy(folder, path)
        return _read(path)  # whose memory the system may take back, unlike that of `arrays`
    except (OSError, ValueError, InvalidInput) as error:
        log.warning("nothing is cached on disk: %s", error)
    return arrays


def _write(stream: IO[bytes], arrays: Mapping[str, np.ndarray]) -> None:
    """A line of JSON that tells what follows, then the arrays."""
    entries, offset = [], 0
    for name, array in arrays.items():
        entries.append({"name": name, "dtype": array.dtype.str, "shape": list(array.shape), "offset": offset})
        offset += _aligned(array.nbytes)
    header = json.dumps({"format": FORMAT, "version": VERSION, "size": offset, "arrays": entries}).encode()
    stream.write(header + b" " * (_aligned(len(header) + 1) - len(header) - 1) + b"\n")
    for array in arrays.values():
        stream.write(np.ascontiguousarray(array).data)
        stream.write(b"\0" * (_aligned(array.nbytes) - array.nbytes))


def _aligned(size: int) -> int:
    return -(-size // ALIGNMENT) * ALIGNMENT


def _read(path: str) -> Dict[str, np.ndarray]:
    """The arrays of a file, mapped into memory; ValueError says what is wrong with it."""
    with open(path, "rb") as stream:
        header, start = _read_header(stream)
        if os.fstat(stream.fileno()).st_size != start + header.get("size", 0):
            raise ValueError("it was cut short")
        # Private, so that the arrays may be written to like any other; kernels are compiled for such ones.
        content = mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_COPY)
    try:
        return {entry["name"]: _array(content, entry, start) for entry in header["arrays"]}
    except (KeyError, TypeError) as error:
        raise ValueError(f"its header is damaged: {error}") from error


def _array(content: mmap.mmap, entry: Mapping[str, Any], start: int) -> np.ndarray:
    dtype, count = np.dtype(entry["dtype"]), math.prod(entry["shape"])
    place = start + entry["offset"] if count else 0  # an empty array may lie behind the end
    return np.frombuffer(content, dtype, count, place).reshape(entry["shape"])


def _read_header(stream: IO[bytes]) -> Tuple[Dict[str, Any], int]:
    """The header, and where the arrays begin."""
    line = stream.readline(1 << 16)
    try:
        header = json.loads(line)
        known = header["format"], header["version"]
    except (ValueError, TypeError, KeyError):
        raise ValueError("it is no cache file, or was cut short") from None
    if known != (FORMAT, VERSION):
        raise ValueError(f"it is of {known[0]!r}, version {known[1]}")
    return header, len(line)


def _tidy(folder: str, newest: str) -> None:
    """Delete the files that nobody has used for long, and of the others the oldest until they are not too large."""
    files = []
    for entry in os.scandir(folder):
        if entry.name.endswith((SUFFIX, PART)) and entry.path != newest:
            with suppress(FileNotFoundError):  # other processes tidy up, too
                files.append((entry.stat().st_mtime, entry.stat().st_size, entry.path))
    total = sum(size for _, size, _ in files) + os.path.getsize(newest)
    for used, size, path in sorted(files):
        if used > time.time() - UNUSED and (total <= LARGEST or path.endswith(PART)):
            continue
        with suppress(FileNotFoundError):
            os.unlink(path)
        total -= size
