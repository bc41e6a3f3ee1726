"""Ctrl-C: it ends the program even where an exception would be lost, and what was being written is gone."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from repository import ROOT

# What is interrupted loses every exception, as a callback of compiled code does.
DEAF = """
import os, sys, time
from social_fleet.cli.interruption import end_when_interrupted
from social_fleet.files import atomic_write
end_when_interrupted()
with atomic_write(sys.argv[1]) as stream:
    stream.write("half")
    stream.flush()
    {preparation}
    print("ready", flush=True)
    while True:
        try:
            time.sleep(60.0)
        except BaseException:
            pass
"""


def start(path: Path, preparation: str = "", **options: Any) -> "subprocess.Popen[str]":
    environment = dict(os.environ, PYTHONPATH=str(ROOT / "src"))
    process = subprocess.Popen([sys.executable, "-c", DEAF.format(preparation=preparation), str(path)], text=True,
                               env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)
    assert process.stdout is not None and process.stdout.readline() == "ready\n"
    return process


@pytest.mark.parametrize("number, code", [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_the_process_and_what_it_was_writing(tmp_path: Path, number: int, code: int) -> None:
    process = start(tmp_path / "plan.json")
    assert len(os.listdir(tmp_path)) == 1
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out, err) == (code, "", "")
    assert os.listdir(tmp_path) == []


def test_worker_processes_end_with_it(tmp_path: Path) -> None:
    workers = ("import multiprocessing; worker = multiprocessing.Process(target=time.sleep, args=(600.0,)); "
               "worker.start(); print(worker.pid, flush=True)")
    environment = dict(os.environ, PYTHONPATH=str(ROOT / "src"))
    process = subprocess.Popen([sys.executable, "-c", DEAF.format(preparation=workers), str(tmp_path / "plan.json")],
                               text=True, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None and process.stdout.readline().strip().isdigit()
    assert process.stdout.readline() == "ready\n"
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)  # which waits for the worker to end, too: it has the same pipes
    assert process.returncode == 130
    assert os.listdir(tmp_path) == []


def test_what_is_ignored_stays_ignored(tmp_path: Path) -> None:
    process = start(tmp_path / "plan.json", preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN))
    process.send_signal(signal.SIGINT)
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(timeout=0.5)
    process.terminate()
    process.communicate(timeout=60)
    assert process.returncode == 143
