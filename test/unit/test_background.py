"""Work in a thread of its own."""

import threading
import time
from typing import Any, Callable, List

from social_fleet.ros.background import BackgroundWork


def until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def test_requests_that_come_meanwhile_are_one() -> None:
    begun, go_on, done = threading.Event(), threading.Event(), []

    def work() -> None:
        begun.set()
        go_on.wait(20.0)
        done.append(threading.current_thread().name)

    background = BackgroundWork(work, "learning")
    background.request()
    assert begun.wait(20.0)
    for _ in range(5):
        background.request()
    assert done == []
    go_on.set()
    until(lambda: len(done) == 2)
    background.stop()
    assert done == ["learning"] * 2


def test_a_fault_is_logged_and_the_next_request_is_served(caplog: Any) -> None:
    done: List[int] = []

    def work() -> None:
        done.append(1)
        if len(done) == 1:
            raise ZeroDivisionError("once")

    background = BackgroundWork(work, "learning")
    background.request()
    until(lambda: "a fault of the thread 'learning'" in caplog.text)
    background.request()
    until(lambda: len(done) == 2)
    background.stop()


def test_stopping_ends_the_thread() -> None:
    background = BackgroundWork(lambda: None, "stops")
    background.stop()
    assert "stops" not in [thread.name for thread in threading.enumerate()]
