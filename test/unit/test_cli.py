"""The command line as a whole: exit codes, one line for each mistake, nothing half-written, and a quick start."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, List

import pytest
from repository import ROOT
from worlds import grid_from_text

import social_fleet
from social_fleet.cli import main as program
from social_fleet.cli.main import main
from social_fleet.cli.parser import VERBS
from social_fleet.errors import Infeasible, InvalidMap, NoPath, SolverFailed, TimedOut
from social_fleet.mapping.files import save_map

HALL = "\n".join(["#" * 14, *["#" + "." * 12 + "#"] * 8, "#" * 14])
SCRIPT = str(ROOT / "scripts" / "social_fleet")


@pytest.fixture(name="hall")
def make_hall(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    save_map(grid_from_text(HALL), str(tmp_path / "hall.yaml"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def start(*arguments: str, **options: Any) -> "subprocess.Popen[str]":
    environment = dict(os.environ, PYTHONPATH=str(ROOT / "src"))
    return subprocess.Popen([sys.executable, SCRIPT, *arguments], env=environment, text=True, stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, **options)


@pytest.mark.parametrize("arguments, message", [
    ([], "error: command line: the following arguments are required: VERB"),
    (["fly"], "error: command line: VERB: invalid choice: 'fly'"),
    (["plan"], "error: command line: the following arguments are required: --map"),
    (["plan", "--map", "hall.yaml"], "error: command line: --start: is missing; give --start and --goal, or --batch"),
    (["plan", "--map", "hall.yaml", "--start", "1", "--goal", "2", "2"],
     "error: command line: --start: expects X Y [YAW] in metres and radians, not 1 number"),
    (["plan", "--map", "hall.yaml", "--start", "1", "b", "--goal", "2", "2"],
     "error: command line: --start: must be a number, not 'b'"),
    (["plan", "--map", "hall.yaml", "--planner", "magic"], "error: command line: --planner: invalid choice: 'magic'"),
    (["verify", "a.json", "b.json"], "error: command line: unrecognized arguments: b.json"),
    (["learn", "--map", "hall.yaml", "--paths", "-3", "--out", "g"],
     "error: command line: --paths: must be a whole number from 1 on, not '-3'"),
    (["random-scenario", "--map", "hall.yaml", "--robots", "2", "--radius", "0", "--out", "s"],
     "error: command line: --radius: must be a positive number, not '0'"),
    (["coordinate", "s.yaml", "--time-limit", "nan"],
     "error: command line: --time-limit: must be a positive number, not 'nan'"),
])
def test_a_wrong_command_line_is_one_line_and_exit_2(hall: Path, capsys: pytest.CaptureFixture, arguments: List[str],
                                                     message: str) -> None:
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith(message) and captured.err.count("\n") == 1 and captured.out == ""


@pytest.mark.parametrize("error, code, message", [
    (InvalidMap("must be positive", source="m.yaml", field="resolution"), 2,
     "error: m.yaml: resolution: must be positive"),
    (NoPath("nothing joins them"), 1, "no path: nothing joins them"),
    (Infeasible("a and b\nblock each other"), 1, "no schedule: a and b block each other"),
    (TimedOut("after 3 s"), 1, "timed out: after 3 s"),
    (SolverFailed("odd"), 1, "solver failed: odd"),
    (PermissionError(13, "Permission denied", "x.png"), 2, "error: x.png: Permission denied"),
    (KeyboardInterrupt(), 130, ""),
])
def test_what_is_raised_decides_the_exit_code(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture,
                                              error: BaseException, code: int, message: str) -> None:
    def fail(_: Any) -> int:
        raise error
    monkeypatch.setattr(VERBS["verify"], "run", fail)
    assert main(["verify", "x.json"]) == code
    assert capsys.readouterr().err.strip() == message


def test_a_mistake_of_the_program_is_told_apart(monkeypatch: pytest.MonkeyPatch,
                                                capsys: pytest.CaptureFixture) -> None:
    monkeypatch.setattr(VERBS["verify"], "run", lambda _: 1 // 0)
    assert main(["verify", "x.json"]) == program.INTERNAL
    assert "this is a mistake in social_fleet" in capsys.readouterr().err


@pytest.mark.parametrize("verb", list(VERBS))
def test_every_verb_has_help_with_an_example(verb: str, capsys: pytest.CaptureFixture) -> None:
    with pytest.raises(SystemExit) as caught:
        main([verb, "--help"])
    assert caught.value.code == 0
    shown = capsys.readouterr().out
    assert f"example:\n  social_fleet {verb} " in shown and "--json" in shown


def test_only_what_works_is_listed(capsys: pytest.CaptureFixture) -> None:
    with pytest.raises(SystemExit):
        main(["--help"])
    shown = capsys.readouterr().out
    assert all(verb in shown for verb in VERBS)


def test_version(capsys: pytest.CaptureFixture) -> None:
    with pytest.raises(SystemExit):
        main(["--version"])
    assert capsys.readouterr().out.strip() == f"social_fleet {social_fleet.__version__}"


def test_the_start_is_quick_and_needs_no_heavy_import() -> None:
    code = ("import sys; from social_fleet.cli.parser import build_parser; build_parser().format_help();"
            "print(sorted({'numba', 'scipy', 'matplotlib', 'pulp', 'networkx', 'PIL', 'rospy'} & set(sys.modules)))")
    environment = dict(os.environ, PYTHONPATH=str(ROOT / "src"))
    shown = subprocess.run([sys.executable, "-c", code], env=environment, stdout=subprocess.PIPE, text=True, check=True)
    assert shown.stdout.strip() == "[]"


def test_in_a_pipe_there_is_json_and_nothing_else(hall: Path) -> None:
    process = start("plan", "--map", "hall.yaml", "--start", "2", "2", "--goal", "-1e0", "7", "--json", cwd=hall)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out) == (2, "") and err.startswith("error: hall.yaml: --goal: (-1.00, 7.00) is off")
    process = start("plan", "--map", "hall.yaml", "--start", "2", "2", "--goal", "11", "7", "--json", cwd=hall)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (0, "") and json.loads(out)["status"] == "ok"


def test_a_reader_that_leaves_is_no_error(hall: Path) -> None:
    process = start("plan", "--map", "hall.yaml", "--start", "2", "2", "--goal", "11", "7", "--json", cwd=hall)
    assert process.stdout is not None and process.stderr is not None
    process.stdout.close()
    assert process.stderr.read() == ""
    assert process.wait(timeout=60) == program.BROKEN_PIPE


def test_interrupting_leaves_nothing_behind(hall: Path) -> None:
    before = sorted(os.listdir(hall))
    process = start("learn", "--map", "hall.yaml", "--paths", "1000000", "--out", "g", cwd=hall, start_new_session=True)
    deadline = time.monotonic() + 60.0
    while "llvmlite" not in Path(f"/proc/{process.pid}/maps").read_text() and time.monotonic() < deadline:
        time.sleep(0.05)  # until the verb itself is running
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out) == (program.INTERRUPTED, "")
    assert "Traceback" not in err and sorted(os.listdir(hall)) == before
