"""A time limit that compiled searches honour in the middle of their loops."""

import threading
import time
from types import TracebackType
from typing import Optional, Type

import numpy as np

from social_fleet.errors import InvalidParameter, TimedOut


class Deadline:
    """A context that raises `stop[0]` from 0 to 1 when its time has passed.

    Compiled code cannot ask for the time. It runs without the interpreter's lock and looks at `stop` instead, which a
    timer's thread sets.

    Parameters
    ----------
    limit : float
        Wall time from now on [s].

    Attributes
    ----------
    stop : (1,) uint8 array
        1 once the time has passed.

    Raises
    ------
    InvalidParameter
        When the limit is not positive.
    """

    def __init__(self, limit: float) -> None:
        if not limit > 0.0:
            raise InvalidParameter(f"must be a positive number of seconds, not {limit!r}", field="time_limit")
        self.limit = limit
        self.stop = np.zeros(1, dtype=np.uint8)
        self._end = time.monotonic() + limit
        self._timer = threading.Timer(min(limit, threading.TIMEOUT_MAX), self._ring)
        self._timer.daemon = True

    def __enter__(self) -> "Deadline":
        self._timer.start()
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        self._timer.cancel()

    def check(self, what: str) -> None:
        """Go on only while there is time.

        Raises
        ------
        TimedOut
            `what` is the beginning of the message.
        """
        if self.stop[0] or time.monotonic() > self._end:
            raise TimedOut(f"{what} found no schedule within {self.limit:g} s; allow more time or send fewer robots")

    def _ring(self) -> None:
        self.stop[0] = 1
