"""A bar for long work on a terminal, and nothing otherwise."""

import io
import sys
import time

import pytest

from social_fleet.cli import progress as module


class Terminal(io.StringIO):
    """Text that a terminal would show."""

    def isatty(self) -> bool:
        """As terminals do."""
        return True


def wait_for_the_bar(stream: io.StringIO) -> None:
    deadline = time.monotonic() + 60.0
    while "learning" not in stream.getvalue() and time.monotonic() < deadline:
        time.sleep(0.01)


@pytest.mark.parametrize("stream, patience, shown", [(Terminal(), 0.0, True), (Terminal(), 60.0, False),
                                                     (io.StringIO(), 0.0, False)])
def test_a_bar_is_shown_on_a_terminal_after_a_while(monkeypatch: pytest.MonkeyPatch, stream: io.StringIO,
                                                    patience: float, shown: bool) -> None:
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(module, "PATIENCE", patience)
    with module.progress(4, "learning", "paths") as update:
        if shown:
            wait_for_the_bar(stream)  # even before anything is done
        for done in range(5):
            update(done)
    assert ("learning" in stream.getvalue()) == shown


def test_a_late_bar_begins_where_the_work_is(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(module, "PATIENCE", 0.2)
    with module.progress(4, "learning", "paths") as update:
        update(3)
        wait_for_the_bar(stream)
        assert "75%" in stream.getvalue() and "3/4 paths" in stream.getvalue()


def test_the_bar_is_taken_down_when_the_work_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(module, "PATIENCE", 0.0)
    with pytest.raises(ValueError):
        with module.progress(4, "learning", "paths") as update:
            wait_for_the_bar(stream)
            update(1)
            raise ValueError
    assert stream.getvalue().endswith("\r")
