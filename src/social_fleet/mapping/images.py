"""Map images: PGM read and written here, bit for bit the same everywhere; every other format through Pillow."""

import io
import os
import re
import struct
import zlib
from typing import List, Tuple

import numpy as np
from PIL import Image

from social_fleet.errors import InvalidMap
from social_fleet.files import PathLike, atomic_write

# Pillow before 8 neither reads plain PGM nor scales by maxval, so the two PGM kinds are parsed here.
_HEADER = re.compile(rb"(P[25])" + rb"(?:\s|#[^\n]*\n)+(\d+)" * 2 + rb"(?:\s|#[^\n]*\n)+(\d+)(?:\s|#[^\n]*\n)")
_BROKEN = (OSError, SyntaxError, ValueError, EOFError, IndexError, struct.error, zlib.error,
           Image.DecompressionBombError)


def read_image(path: PathLike) -> np.ndarray:
    """The pixels of an image file, the top row first.

    Returns
    -------
    (rows, columns, channels) uint8
        Channels are grey (1), red, green, blue (3), or these and alpha (4). Deeper images are cut to 8 bits.

    Raises
    ------
    InvalidMap
        When the file is missing, no image, cut short or of zero size; `source` is the path.
    """
    source = os.fspath(path)
    try:
        with open(source, "rb") as stream:
            data = stream.read()
    except FileNotFoundError:
        raise InvalidMap("there is no such file", source=source) from None
    except OSError as error:
        raise InvalidMap(f"cannot be read: {error.strerror}", source=source) from error
    try:
        return _parse_pgm(data) if data[:2] in (b"P2", b"P5") else _parse_other(data)
    except Image.UnidentifiedImageError:
        raise InvalidMap("is not an image that can be read; use PGM or PNG", source=source) from None
    except _BROKEN as error:
        raise InvalidMap(f"is a damaged image: {error}", source=source) from error


def write_image(path: PathLike, pixels: np.ndarray) -> None:
    """Write grey pixels (rows, columns) uint8, the top row first, whole or not at all; PNG if `path` ends so, or PGM.

    Raises
    ------
    InvalidInput
        When the file cannot be created.
    """
    if os.fspath(path).endswith(".png"):
        buffer = io.BytesIO()
        Image.fromarray(pixels).save(buffer, format="PNG", optimize=True)
        data = buffer.getvalue()
    else:
        data = b"P5\n%d %d\n255\n" % pixels.shape[::-1] + pixels.tobytes()
    with atomic_write(path, "wb") as stream:
        stream.write(data)


def _parse_pgm(data: bytes) -> np.ndarray:
    """The image in a plain (P2) or binary (P5) PGM file; see the pgm(5) page of Netpbm."""
    header = _HEADER.match(data)
    if header is None:
        raise ValueError("the PGM header lacks width, height or the largest value")
    columns, rows, largest = (int(header.group(index)) for index in (2, 3, 4))
    if not (columns and rows):
        raise ValueError(f"its size is {columns} x {rows}")
    if not 0 < largest < 65536:
        raise ValueError(f"its largest value is {largest}, not within 1 to 65535")
    body, count = data[header.end():], rows * columns
    values = _plain_values(body, count) if header.group(1) == b"P2" else _binary_values(body, count, largest)
    if len(values) < count:
        raise ValueError(f"cut short: {count} pixels announced, {len(values)} there")
    if values.max() > largest:
        raise ValueError(f"a value of {values.max()} exceeds the largest, {largest}")
    # truncated as SDL_image does, through which map_server reads
    return (values.astype(np.uint32) * 255 // largest).astype(np.uint8).reshape(rows, columns, 1)


def _plain_values(body: bytes, count: int) -> np.ndarray:
    words: List[bytes] = re.sub(rb"#[^\n]*", b"", body).split()[:count]
    values = np.array([int(word) for word in words], dtype=np.int64)
    if len(values) and values.min() < 0:
        raise ValueError(f"a value of {values.min()} is negative")
    return values


def _binary_values(body: bytes, count: int, largest: int) -> np.ndarray:
    kind = np.dtype("u1" if largest < 256 else ">u2")
    return np.frombuffer(body, dtype=kind, count=min(count, len(body) // kind.itemsize))


def _parse_other(data: bytes) -> np.ndarray:
    Image.open(io.BytesIO(data)).verify()  # finds a missing end and wrong checksums, and spoils the object
    image = Image.open(io.BytesIO(data))
    image.load()
    if image.mode.startswith("I"):
        pixels = (np.asarray(image).astype(np.int64) >> 8).astype(np.uint8)  # 16-bit grey: the high byte, as SDL_image
    else:
        pixels = np.asarray(image.convert(_target_mode(image)))
    if pixels.size == 0:
        raise ValueError(f"its size is {image.size[0]} x {image.size[1]}")
    return pixels.reshape(_three(pixels.shape))


def _target_mode(image: Image.Image) -> str:
    if image.mode in ("RGBA", "LA", "PA") or "transparency" in image.info:
        return "RGBA"
    return "L" if image.mode in ("L", "1") else "RGB"


def _three(shape: Tuple[int, ...]) -> Tuple[int, ...]:
    return shape if len(shape) == 3 else shape + (1,)
