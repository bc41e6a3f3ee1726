"""The cache on disk: hits, misses, and files that cannot be used."""

import os
import threading
import time

import numpy as np
import pytest

from social_fleet.planning import cache

ARRAYS = {"a": np.arange(7, dtype=np.int32), "b": np.linspace(0.0, 1.0, 6).reshape(2, 3), "none": np.zeros(0, np.uint8)}


class Counter:
    """Works out ARRAYS and counts how often."""

    def __init__(self):
        self.calls = 0

    def __call__(self):
        self.calls += 1
        return ARRAYS


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(cache.FOLDER, str(tmp_path / "cache"))
    return tmp_path / "cache"


def check(arrays):
    assert list(arrays) == list(ARRAYS)
    for name, array in ARRAYS.items():
        np.testing.assert_array_equal(arrays[name], array)
        assert arrays[name].dtype == array.dtype and arrays[name].flags.writeable


def only_file(folder):
    (path,) = folder.iterdir()
    return path


def test_the_second_time_nothing_is_worked_out(folder):
    compute = Counter()
    for _ in range(3):
        check(cache.cached("costs", "0123", compute))
    assert compute.calls == 1
    assert only_file(folder).name == "costs-0123.arrays"
    check(cache.cached("costs", "4567", compute))
    assert compute.calls == 2


@pytest.mark.parametrize("keep, reason", [(0, "no cache file"), (20, "no cache file"), (-1, "cut short")])
def test_a_file_that_was_cut_short_is_made_anew(folder, caplog, keep, reason):
    compute = Counter()
    cache.cached("costs", "0123", compute)
    path = only_file(folder)
    path.write_bytes(path.read_bytes()[:keep])
    check(cache.cached("costs", "0123", compute))
    assert compute.calls == 2
    assert str(path) in caplog.text and reason in caplog.text
    check(cache.cached("costs", "0123", compute))
    assert compute.calls == 2


def test_a_file_of_another_version_is_made_anew(folder, caplog):
    cache.cached("costs", "0123", Counter())
    path = only_file(folder)
    path.write_bytes(path.read_bytes().replace(b'"version": 1', b'"version": 9'))
    check(cache.cached("costs", "0123", Counter()))
    assert "version 9" in caplog.text


def test_a_folder_that_cannot_be_written_costs_a_warning(tmp_path, monkeypatch, caplog):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(cache.FOLDER, str(tmp_path / "file" / "cache"))
    check(cache.cached("costs", "0123", Counter()))
    assert "nothing is cached" in caplog.text


def test_no_folder_no_cache(monkeypatch):
    monkeypatch.setenv(cache.FOLDER, "")
    compute = Counter()
    for _ in range(2):
        check(cache.cached("costs", "0123", compute))
    assert compute.calls == 2


def test_writers_at_once_do_no_harm(folder):
    failures = []

    def work():
        for number in range(10):
            try:
                check(cache.cached("costs", str(number), Counter()))
            except AssertionError as error:
                failures.append(error)

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=60.0)
    assert not failures
    assert len(list(folder.iterdir())) == 10


def test_the_oldest_go_when_all_together_are_too_large(folder, monkeypatch):
    for number in range(3):
        cache.cached("costs", str(number), Counter())
        used = time.time() - 10.0 + number
        os.utime(folder / f"costs-{number}.arrays", (used, used))
    monkeypatch.setattr(cache, "LARGEST", 2 * only_size(folder))
    cache.cached("costs", "3", Counter())
    assert sorted(path.name for path in folder.iterdir()) == ["costs-2.arrays", "costs-3.arrays"]


def test_files_that_nobody_has_used_for_long_go(folder):
    long_ago = time.time() - cache.UNUSED - 100.0
    for name in ("stale", "used"):
        cache.cached("costs", name, Counter())
        os.utime(folder / f"costs-{name}.arrays", (long_ago, long_ago))
    for name, age in ((".0.part", 0.0), (".1.part", long_ago)):  # one is being written, one was left by a crash
        (folder / name).write_bytes(b"half")
        if age:
            os.utime(folder / name, (age, age))
    compute = Counter()
    cache.cached("costs", "used", compute)
    cache.cached("costs", "new", Counter())
    assert sorted(path.name for path in folder.iterdir()) == [".0.part", "costs-new.arrays", "costs-used.arrays"]
    assert compute.calls == 0


@pytest.mark.parametrize("old, new", [(b'"arrays"', b'"barrays'), (b'"<i4"', b'"<z4"'), (b'"offset"', b'"offsid"'),
                                      (b'"size"', b'"seiz"'), (b'"shape": [7]', b'"shape": [x]')])
def test_a_damaged_header_is_made_anew(folder, caplog, old, new):
    cache.cached("costs", "0123", Counter())
    path = only_file(folder)
    path.write_bytes(path.read_bytes().replace(old, new, 1))
    check(cache.cached("costs", "0123", Counter()))
    assert "is made anew" in caplog.text


def only_size(folder):
    return next(folder.iterdir()).stat().st_size


def test_digests_tell_contents_apart():
    one = cache.digest_of(np.arange(3), {"a": 1, "b": 2})
    assert one == cache.digest_of(np.arange(3), {"b": 2, "a": 1})
    others = [cache.digest_of(np.arange(3)), cache.digest_of(np.arange(4), {"a": 1, "b": 2}),
              cache.digest_of(np.arange(3, dtype=np.int32), {"a": 1, "b": 2}), cache.digest_of()]
    assert len({one, *others}) == 5
