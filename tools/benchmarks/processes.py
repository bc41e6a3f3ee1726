"""Programs that a benchmark starts, and ends whatever happens."""

import os
import signal
import subprocess
import time
from contextlib import contextmanager
from typing import Callable, Iterator

LIMIT = 120.0  # [s] that anything is waited for


@contextmanager
def running(*command: str) -> "Iterator[subprocess.Popen[bytes]]":
    """A program in a process group of its own, which is ended with the block."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    try:
        yield process
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGINT)
        try:
            process.wait(10.0)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@contextmanager
def ros_master() -> Iterator[None]:
    """A ROS master on the port that the environment names."""
    import rosgraph
    with running("roscore", "-p", os.environ["ROS_MASTER_URI"].rsplit(":", 1)[1]):
        wait_for(rosgraph.is_master_online)
        yield


def wait_for(condition: Callable[[], bool]) -> None:
    """Return when the condition holds; TimeoutError past the limit."""
    deadline = time.monotonic() + LIMIT
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(f"nothing within {LIMIT:.0f} s")
        time.sleep(0.02)
