"""A progress bar for long work on a terminal, and nothing in a pipe or for short work."""

import sys
import threading
from contextlib import contextmanager
from typing import Any, Callable, Iterator

PATIENCE = 2.0  # [s] before a bar appears
FORMAT = "{desc}: {percentage:3.0f}%|{bar}| {n:.0f}/{total:.0f} {unit} [{elapsed}<{remaining}]"


@contextmanager
def progress(total: float, label: str, unit: str, *, initial: float = 0) -> Iterator[Callable[[float], None]]:
    """Yield a function to be called with how much of `total` is done so far; `initial` was done before."""
    if not sys.stderr.isatty():
        yield lambda done: None
        return
    bar = _Bar(total, label, unit, initial)
    # A timer, as it may take long to come to the first call: all is compiled when the program runs for the first time.
    timer = threading.Timer(PATIENCE, bar.appear)
    timer.daemon = True
    timer.start()
    try:
        yield bar.update
    finally:
        timer.cancel()
        bar.close()


class _Bar:
    """A bar that appears late, from another thread than it is updated from."""

    def __init__(self, total: float, label: str, unit: str, initial: float) -> None:
        self._options = {"total": total, "desc": label, "unit": unit}
        self._initial = self._done = initial
        self._bar: Any = None
        self._closed = False
        self._lock = threading.Lock()

    def appear(self) -> None:
        """Show the bar as it stands now, unless the work has ended."""
        from tqdm import tqdm
        with self._lock:
            if self._closed:
                return
            self._bar = tqdm(leave=False, file=sys.stderr, dynamic_ncols=True, initial=self._done, bar_format=FORMAT,
                             **self._options)
            self._bar.initial = self._initial  # what was done before says nothing of how fast it goes
            self._bar.start_t -= PATIENCE  # it counts from the beginning of the work, not from its own

    def update(self, done: float) -> None:
        """Take in how much is done."""
        with self._lock:
            self._done = done
            if self._bar is not None:
                self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """Take the bar down for good."""
        with self._lock:
            self._closed = True
            if self._bar is not None:
                self._bar.close()
