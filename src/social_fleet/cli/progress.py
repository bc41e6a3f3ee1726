"""A progress bar for long work on a terminal, and nothing in a pipe or for short work."""

import sys
import time
from contextlib import contextmanager
from typing import Any, Callable, Iterator

PATIENCE = 2.0  # [s] before a bar appears


@contextmanager
def progress(total: float, label: str, unit: str, *, initial: float = 0) -> Iterator[Callable[[float], None]]:
    """Yield a function to be called with how much of `total` is done so far; `initial` was done before."""
    bar: Any = None
    begun = time.monotonic()

    def update(done: float) -> None:
        nonlocal bar
        if bar is None and sys.stderr.isatty() and time.monotonic() - begun >= PATIENCE:
            bar = _make_bar(total, label, unit, initial)
        if bar is not None:
            bar.update(done - bar.n)

    try:
        yield update
    finally:
        if bar is not None:
            bar.close()


def _make_bar(total: float, label: str, unit: str, initial: float) -> Any:
    from tqdm import tqdm
    bar = tqdm(total=total, desc=label, unit=unit, initial=initial, leave=False, file=sys.stderr, dynamic_ncols=True,
               bar_format="{desc}: {percentage:3.0f}%|{bar}| {n:.0f}/{total:.0f} {unit} [{elapsed}<{remaining}]")
    bar.start_t -= PATIENCE  # it counts from the beginning of the work, not from its own
    return bar
