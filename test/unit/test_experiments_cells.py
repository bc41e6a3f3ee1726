"""Cells of experiments: what is taken from the disk, what is done anew, and what a torn file costs."""

import json
import math
import multiprocessing
import sys
from pathlib import Path
from types import ModuleType
from typing import Any, Dict, List, Tuple

import numpy as np
import pytest

from social_fleet.errors import InvalidInput
from social_fleet.experiments import cells as module
from social_fleet.experiments import table2
from social_fleet.experiments.cells import Cell, Work, cells_file, code_of, finished

MODULE = table2.__name__


def squares(numbers: List[int], done: List[int], **options: Any) -> List[Cell]:
    """A cell per number; each says that it is worked out by adding to `done`."""
    def square(number: int) -> int:
        done.append(number)
        return number * number

    return [Cell({"number": number, **options}, lambda number=number: square(number)) for number in numbers]


def test_what_is_finished_is_not_done_again(tmp_path: Path) -> None:
    done: List[int] = []
    assert Work("x", MODULE, folder=tmp_path).values(squares([1, 2], done)) == [1, 4]
    told: List[Tuple[int, int]] = []
    work = Work("x", MODULE, folder=tmp_path, progress=lambda *share: told.append(share))
    assert work.values(squares([3, 2, 1], done)) == [9, 4, 1]
    assert done == [1, 2, 3] and told == [(2, 3), (3, 3)]


def test_what_fails_keeps_those_before(tmp_path: Path) -> None:
    done: List[int] = []
    broken = Cell({"number": 9}, lambda: 1 // 0)
    with pytest.raises(ZeroDivisionError):
        Work("x", MODULE, folder=tmp_path).values([*squares([1], done), broken, *squares([2], done)])
    assert [value for _, value in finished(cells_file("x", tmp_path))] == [1]


@pytest.mark.parametrize("name, options", [("x", {"seed": 2}), ("y", {"seed": 1})])
def test_other_keys_and_experiments_do_not_mix(tmp_path: Path, name: str, options: Dict[str, Any]) -> None:
    done: List[int] = []
    Work("x", MODULE, folder=tmp_path).values(squares([1], done, seed=1))
    Work(name, MODULE, folder=tmp_path).values(squares([1], done, **options))
    assert done == [1, 1]


def test_other_code_does_not_mix(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done: List[int] = []
    for code in ("old", "new", "old"):
        monkeypatch.setattr(module, "code_of", lambda _, code=code: code)
        assert Work("x", MODULE, folder=tmp_path).values(squares([3], done)) == [9]
    assert done == [3, 3]


def test_the_code_is_all_that_is_imported_but_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    read: List[str] = []
    real = module._read
    monkeypatch.setattr(module, "_read", lambda name: read.append(name) or real(name))
    code_of.cache_clear()
    before = code_of(MODULE)
    assert "social_fleet.planning.search" in read and "social_fleet.experiments.metrics" in read
    assert "social_fleet.errors" in read and "social_fleet.scenario.pictures.colours" not in read

    def edited(name: str) -> Any:
        tree, text = real(name)
        return tree, text + ("# edited" if name == changed else "")

    monkeypatch.setattr(module, "_read", edited)
    for changed, same in (("social_fleet.planning.routes.heatmaps", False), ("social_fleet.experiments.charts", True),
                          ("social_fleet.coordination.program", True)):
        code_of.cache_clear()
        assert (code_of(MODULE) == before) == same
    code_of.cache_clear()


def test_an_experiment_from_elsewhere_has_code_too(monkeypatch: pytest.MonkeyPatch) -> None:
    assert code_of(__name__) != code_of(MODULE)
    monkeypatch.setitem(sys.modules, "typed_in", ModuleType("typed_in"))
    with pytest.raises((OSError, TypeError)):
        code_of("typed_in")


def test_values_are_the_same_from_the_disk(tmp_path: Path) -> None:
    value = {"pair": (1, 2.5), "none": math.nan, "array": np.arange(2.0), "third": 1.0 / 3.0}
    first, second = (Work("x", MODULE, folder=tmp_path).values([Cell({}, lambda: value)]) for _ in range(2))
    assert first == second == [{"pair": [1, 2.5], "none": None, "array": [0.0, 1.0], "third": 1.0 / 3.0}]


def test_without_a_folder_nothing_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    done: List[int] = []
    for _ in range(2):
        assert Work("x", MODULE).values(squares([2], done)) == [4]
    assert done == [2, 2] and not list(tmp_path.iterdir())


@pytest.mark.parametrize("tear", [b"", b"{\"cell\": \"12", b"\x00\xff\x00", b"[1]\n7\n"])
def test_a_torn_line_costs_itself_only(tmp_path: Path, tear: bytes) -> None:
    done: List[int] = []
    Work("x", MODULE, folder=tmp_path).values(squares([1, 2], done))
    path = Path(cells_file("x", tmp_path))
    path.write_bytes(path.read_bytes()[:-1 if tear == b"" else None] + tear)
    for _ in range(2):
        assert Work("x", MODULE, folder=tmp_path).values(squares([1, 2, 3, 4], done)) == [1, 4, 9, 16]
    assert done == [1, 2, 3, 4]


def _write_many(folder: str, own: int) -> None:
    cells = [Cell({"number": number, "own": own}, lambda number=number: [own, number, "x" * 5000])
             for number in range(40)]
    Work("x", MODULE, folder=folder).values(cells)


def test_two_at_once_do_no_harm(tmp_path: Path) -> None:
    processes = [multiprocessing.get_context("fork").Process(target=_write_many, args=(str(tmp_path), own))
                 for own in (0, 1)]
    for process in processes:
        process.start()
    for process in processes:
        process.join()
        assert process.exitcode == 0
    lines = Path(cells_file("x", tmp_path)).read_text().splitlines()
    values = [json.loads(line)["value"] for line in lines]
    assert sorted((own, number) for own, number, _ in values) == [(own, n) for own in (0, 1) for n in range(40)]


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "x.cells").mkdir()
    with pytest.raises(InvalidInput, match="x.cells: a finished cell could not be written: Is a directory"):
        module._keep(cells_file("x", tmp_path), {"cell": "", "value": 1})


def test_ctrl_c_within_compiled_code_is_an_interruption() -> None:
    def struck() -> None:
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as error:
            raise SystemError("returned a result with an exception set") from error

    def broken() -> None:
        raise SystemError("something else")

    with pytest.raises(KeyboardInterrupt):
        Work("cells", __name__).values([Cell({"k": 0}, struck)])
    with pytest.raises(SystemError, match="something else"):
        Work("cells", __name__).values([Cell({"k": 1}, broken)])


def test_of_a_part_of_the_cells_the_progress_is_that_of_all() -> None:
    told: List[Any] = []
    work = Work("cells", __name__, progress=lambda done, total: told.append((done, total)))
    assert work.values([Cell({"k": 2}, lambda: 5)], before=3, total=6) == [5]
    assert told == [(3, 6), (4, 6)]
