"""What is wrong in a file is said by line; output appears whole or not at all."""

import json
import os
import stat
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from social_fleet.errors import InvalidInput, InvalidScenario
from social_fleet.files import atomic_write, check_writable, dump_json, read_json, read_yaml, write_json


def test_a_written_file_replaces_the_old_one_and_keeps_its_permissions(tmp_path: Path) -> None:
    target = tmp_path / "a.txt"
    target.write_text("old")
    target.chmod(0o640)
    with atomic_write(target) as stream:
        stream.write("née")
        assert target.read_text() == "old"
    assert target.read_text(encoding="utf-8") == "née"
    assert stat.S_IMODE(target.stat().st_mode) == 0o640


def test_a_new_file_has_the_permissions_that_open_gives(tmp_path: Path) -> None:
    (tmp_path / "plain").write_text("")
    with atomic_write(tmp_path / "new", "wb") as stream:
        stream.write(b"\x00")
    assert (tmp_path / "new").stat().st_mode == (tmp_path / "plain").stat().st_mode


@pytest.mark.parametrize("trouble", [ValueError, KeyboardInterrupt])
def test_nothing_half_written_stays_behind(tmp_path: Path, trouble: Any) -> None:
    target = tmp_path / "a.txt"
    target.write_text("old")
    with pytest.raises(trouble):
        with atomic_write(target) as stream:
            stream.write("half")
            raise trouble()
    assert os.listdir(tmp_path) == ["a.txt"]
    assert target.read_text() == "old"


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to("real")
    with atomic_write(tmp_path / "link") as stream:
        stream.write("new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "new"


def test_a_device_is_written_directly() -> None:
    with atomic_write("/dev/null") as stream:
        stream.write("gone")
    assert not os.path.isfile("/dev/null")


@pytest.mark.parametrize("name, message", [
    ("missing/a.json", "does not exist; create it first"),
    ("", "is a folder; name a file in it"),
    ("results/", "is a folder; name a file in it"),
])
def test_an_impossible_place_is_refused_by_name(tmp_path: Path, name: Any, message: Any) -> None:
    path = os.path.join(str(tmp_path), name)
    with pytest.raises(InvalidInput, match=message) as caught:
        check_writable(path)
    assert caught.value.source == path
    with pytest.raises(InvalidInput):
        write_json(path, {})


def test_an_empty_name_is_refused() -> None:
    with pytest.raises(InvalidInput, match="name a file"):
        check_writable("")


def test_checking_leaves_no_trace(tmp_path: Path) -> None:
    check_writable(tmp_path / "a.json")
    assert os.listdir(tmp_path) == []


def test_json_holds_plain_strict_values(tmp_path: Path) -> None:
    value = {"a": np.float32(0.5), "b": np.arange(4).reshape(2, 2), "c": (True, None, np.bool_(False)),
             "d": float("inf"), "e": [{"f": "é"}, {}], "g": {}, "h": []}
    write_json(tmp_path / "v.json", value)
    assert json.loads((tmp_path / "v.json").read_text(encoding="utf-8")) == {
        "a": 0.5, "b": [[0, 1], [2, 3]], "c": [True, None, False], "d": None, "e": [{"f": "é"}, {}], "g": {}, "h": []}


def test_json_keeps_a_path_on_one_line() -> None:
    assert dump_json({"points": [[0.0, 1.0], [2.0, 3.0]]}) == '{\n  "points": [[0.0, 1.0], [2.0, 3.0]]\n}'


@pytest.mark.parametrize("read, content, message", [
    (read_yaml, b"a: 1\nb: [1, 2\nc: 3\n", "line 3, column 2: not valid YAML"),
    (read_yaml, b"a: 1\n\tb: 2\n", "line 2, column 1: not valid YAML"),
    (read_yaml, b"a: 1\nb: 2\na: 3\n", "line 3, column 1: not valid YAML: the key 'a' is there twice"),
    (read_yaml, b"\xff\xfe\x00", "is not a text file in UTF-8"),
    (read_yaml, b"a: !!python/name:os.system x\n", "not valid YAML: could not determine a constructor"),
    (read_json, b'{"a": 1,\n "b"}', "line 2, column 5: not valid JSON"),
    (read_yaml, b"a: 2001-13-45\n", "not valid YAML: month must be"),
    (read_yaml, b"[" * 10000, "not valid YAML"),
    (read_json, b"[NaN]", "not valid JSON: NaN is not a number"),
    (read_json, b"[" * 100000, "not valid JSON"),
])
def test_a_broken_file_is_refused_by_line(tmp_path: Path, read: Any, content: Any, message: Any) -> None:
    path = tmp_path / "broken"
    path.write_bytes(content)
    with pytest.raises(InvalidScenario, match=message) as caught:
        read(path, InvalidScenario)
    assert caught.value.source == str(path)


@pytest.mark.parametrize("read", [read_yaml, read_json])
def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path, read: Any) -> None:
    with pytest.raises(InvalidScenario, match="there is no such file"):
        read(tmp_path / "none", InvalidScenario)
    with pytest.raises(InvalidScenario, match="is a folder"):
        read(tmp_path, InvalidScenario)


def test_files_are_read_back(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("a: [1, 2.5, x]\n")
    assert read_yaml(tmp_path / "a.yaml") == {"a": [1, 2.5, "x"]}
    write_json(tmp_path / "a.json", {"a": [1, 2.5, "x"]})
    assert read_json(tmp_path / "a.json") == {"a": [1, 2.5, "x"]}
