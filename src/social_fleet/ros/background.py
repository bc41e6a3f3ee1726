"""Work that must not keep services waiting: one thread, woken up when there is something to do."""

import logging
import threading
from typing import Callable

log = logging.getLogger(__name__)


class BackgroundWork:
    """Does `work` in a thread of its own, once for any number of requests that came meanwhile.

    Parameters
    ----------
    work : callable
        What to do. An exception is logged, and does not end the thread.
    name : str
        Of the thread.
    """

    def __init__(self, work: Callable[[], None], name: str) -> None:
        self._work = work
        self._wanted = threading.Event()
        self._stopped = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def request(self) -> None:
        """Have the work done soon; returns at once."""
        self._wanted.set()

    def stop(self, patience: float = 5.0) -> None:
        """End the thread after what it is doing; waits up to `patience` [s]."""
        self._stopped = True
        self._wanted.set()
        self._thread.join(patience)

    def _run(self) -> None:
        while True:
            self._wanted.wait()
            self._wanted.clear()
            if self._stopped:
                return
            try:
                self._work()
            except Exception:
                log.exception("a fault of the thread '%s'", self._thread.name)
