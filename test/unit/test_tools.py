"""The shell library of tools/: what is started ends, with all that it started, and says how."""

import os
import signal
import subprocess
import time
from pathlib import Path
from typing import List

import pytest

from repository import ROOT

ORPHAN = "setsid sleep 60 & echo $! > orphan; sleep 60"


def bounded(folder: Path, seconds: int, command: str) -> List[str]:
    """A command line that runs `command` in a shell, bounded."""
    script = f'source "{ROOT}/tools/environment.sh"; cd "{folder}"; run_bounded {seconds} bash -c "$1"'
    return ["bash", "-c", script, "bash", command]


def is_alive(folder: Path) -> bool:
    """Whether the process still runs whose id the command left behind."""
    pid = int((folder / "orphan").read_text(encoding="ascii"))
    return os.path.exists(f"/proc/{pid}") and "Z" not in Path(f"/proc/{pid}/stat").read_text().split()[2]


@pytest.mark.parametrize("command, code", [("exit 0", 0), ("exit 3", 3)])
def test_the_exit_code_is_handed_on(tmp_path: Path, command: str, code: int) -> None:
    assert subprocess.run(bounded(tmp_path, 20, command), timeout=30).returncode == code


def test_nothing_outlives_the_deadline(tmp_path: Path) -> None:
    assert subprocess.run(bounded(tmp_path, 1, ORPHAN), timeout=30).returncode == 124
    assert not is_alive(tmp_path)


def test_nothing_outlives_the_command(tmp_path: Path) -> None:
    subprocess.run(bounded(tmp_path, 20, "setsid sleep 60 & echo $! > orphan"), timeout=30)
    assert not is_alive(tmp_path)


def test_nothing_outlives_ctrl_c(tmp_path: Path) -> None:
    process = subprocess.Popen(bounded(tmp_path, 60, ORPHAN), start_new_session=True)
    until = time.monotonic() + 10.0
    while not (tmp_path / "orphan").exists() and time.monotonic() < until:
        time.sleep(0.05)
    time.sleep(0.2)
    os.killpg(process.pid, signal.SIGINT)
    assert process.wait(timeout=30) == 130
    assert not is_alive(tmp_path)


@pytest.mark.parametrize("arguments, complaint", [
    (["tools/test", "test/unit/test_nothing.py"], "no such test"),
    (["tools/demo", "scenario:=nothing.yaml"], "there is no file nothing.yaml"),
    (["tools/demo", "--fast"], "not an argument of the demo"),
])
def test_a_wrong_argument_is_one_line_and_code_2(arguments: List[str], complaint: str) -> None:
    result = subprocess.run(["bash", *arguments], cwd=ROOT, stderr=subprocess.PIPE, timeout=30)
    lines = result.stderr.decode().splitlines()
    assert result.returncode == 2
    assert len(lines) == 1 and lines[0].startswith("error: ") and complaint in lines[0]
