"""Ctrl-C ends the program wherever it is, and leaves nothing half-written.

Python's own answer, KeyboardInterrupt, is raised between any two instructions. Where compiled code has called back into
Python, or a module is just being imported, that exception gets lost, turns into another one, or takes the process down.
So the handler here raises nothing: it clears away and ends the process.
"""

import os
import signal
import sys
from types import FrameType
from typing import Optional


def end_when_interrupted() -> None:
    """From now on SIGINT and SIGTERM end the process, with exit codes 130 and 143; for the main thread.

    A signal that whoever started the process has it ignore, as a shell does in the background, stays ignored.
    """
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _end)


def _end(number: int, _: Optional[FrameType]) -> None:
    # Looked up, not imported: an import may be what was interrupted.
    files, workers = sys.modules.get("social_fleet.files"), sys.modules.get("multiprocessing.process")
    try:
        for worker in getattr(workers, "active_children", list)():
            worker.kill()  # one that has just been forked would lose a signal that it has a handler for
        getattr(files, "discard_unfinished", list)()
        if os.isatty(2):
            os.write(2, b"\n")  # so that a prompt does not follow a progress bar
    finally:
        os._exit(128 + number)
