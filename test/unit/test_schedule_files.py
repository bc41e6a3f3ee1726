"""schedule.json: what goes out comes back, and what does not fit is refused by file and field."""

import json
from pathlib import Path
from typing import Any, Callable, Dict

import numpy as np
import pytest
from fleets import robot

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.files import read_schedule, schedule_to_dict, write_schedule
from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.coordination.verification import verify
from social_fleet.errors import InvalidInput, InvalidSchedule


@pytest.fixture(scope="module", name="fleet")
def crossing() -> FleetSchedule:
    return coordinate([robot("a", (-4, 0), (4, 0), max_acceleration=0.5),
                       robot("b", (0, -4), (0, 4), goal_yaw=1.0, weight=2.0)])


def test_what_goes_out_comes_back(fleet: FleetSchedule, tmp_path: Path) -> None:
    write_schedule(fleet, tmp_path / "schedule.json")
    again = read_schedule(tmp_path / "schedule.json")
    assert schedule_to_dict(again) == schedule_to_dict(fleet)
    for before, after in zip(fleet.schedules, again.schedules):
        assert np.array_equal(before.times, after.times) and np.array_equal(before.arc_lengths, after.arc_lengths)
        assert before.precedences == after.precedences
        assert before.robot.weight == after.robot.weight
        assert before.robot.limits == after.robot.limits and before.robot.goal == after.robot.goal
    assert again.windows == fleet.windows
    assert verify(again) == verify(fleet)


def test_the_file_has_the_names_that_others_rely_on(fleet: FleetSchedule) -> None:
    data = schedule_to_dict(fleet)
    assert set(data) >= {"map", "status", "message", "formulation", "objective", "gap", "planning_time",
                         "encounter_time", "solve_time", "robots", "windows"}
    assert set(data["robots"][0]) >= {"name", "radius", "max_speed", "depart", "path", "arc_lengths", "times",
                                      "precedences"}
    waits = [rule for one in data["robots"] for rule in one["precedences"]]
    assert waits and all(set(rule) >= {"at", "other", "other_at"} for rule in waits)
    assert set(data["windows"][0]) == {"robot_r", "robot_s", "kind", "r_enter", "r_exit", "s_enter", "s_exit", "first"}
    json.dumps(data, allow_nan=False)


def test_the_contract_s_fields_are_enough(tmp_path: Path) -> None:
    (tmp_path / "bare.json").write_text(json.dumps({"robots": [
        {"name": "a", "radius": 0.3, "max_speed": 0.5, "path": [[0, 0], [4, 0]], "arc_lengths": [0, 4],
         "times": [0, 8]}]}))
    read = read_schedule(tmp_path / "bare.json")
    assert read["a"].robot.body_radius == 0.3 and read["a"].arrival_time == 8.0
    assert read.windows == () and read.formulation == "exact"


def put(*keys: Any) -> Callable[[Dict], None]:
    """Sets the value named by all keys but the last to the last; removes it when that is `...`."""
    def change(data: Dict) -> None:
        item: Any = data
        for key in keys[:-2]:
            item = item[key]
        if keys[-1] is ...:
            del item[keys[-2]]
        else:
            item[keys[-2]] = keys[-1]
    return change


@pytest.mark.parametrize("change, field", [
    (put("unserved", [5]), r"unserved\[0\]"), (put("unserved", [{"name": "c"}]), r"unserved\[0\].reason"),
    (put("robots", 0, "weight", 0.0), r"robots\[0\].weight"),
    (put("robots", ...), "robots"), (put("robots", {}), "robots"), (put("robots", 0, "amr_1"), r"robots\[0\]"),
    (put("robots", 0, "name", ...), r"robots\[0\].name"), (put("robots", 0, "name", ""), r"robots\[0\].name"),
    (put("robots", 1, "name", "a"), "robots"), (put("robots", 0, "radius", "big"), r"robots\[0\].radius"),
    (put("robots", 0, "radius", -1.0), r"robots\[0\].radius"),
    (put("robots", 0, "radius", True), r"robots\[0\].radius"),
    (put("robots", 0, "max_speed", 0), r"robots\[0\].max_speed"),
    (put("robots", 0, "depart", None), r"robots\[0\].depart"), (put("robots", 0, "path", []), r"robots\[0\]"),
    (put("robots", 0, "path", [[0, "x"]]), r"robots\[0\]"), (put("robots", 0, "times", 3.0), r"robots\[0\].times"),
    (put("robots", 0, "times", ["a"]), r"robots\[0\]"), (put("robots", 0, "times", [5.0, 4.0]), r"robots\[0\]"),
    (put("robots", 0, "arc_lengths", [0.0]), r"robots\[0\]"),
    (put("robots", 0, "precedences", 0, "other_at", ...), r"robots\[0\].precedences\[0\].other_at"),
    (put("robots", 0, "precedences", 0, "other", 3), r"robots\[0\].precedences\[0\].other"),
    (put("windows", 0, "r_enter", "0"), r"windows\[0\].r_enter"), (put("windows", {}), "windows"),
    (put("gap", "small"), "gap"), (put("message", 3), "message")])
def test_what_does_not_fit_is_refused_by_name(fleet: FleetSchedule, tmp_path: Path,
                                              change: Callable[[Dict], None], field: str) -> None:
    data = json.loads(json.dumps(schedule_to_dict(fleet)))
    change(data)
    (tmp_path / "wrong.json").write_text(json.dumps(data))
    with pytest.raises(InvalidSchedule, match=rf"wrong\.json: {field}"):
        read_schedule(tmp_path / "wrong.json")


@pytest.mark.parametrize("text", ["", "{", "[]", "3", '{"robots": [{"times": NaN}]}'])
def test_what_is_no_schedule_at_all(tmp_path: Path, text: str) -> None:
    (tmp_path / "wrong.json").write_text(text)
    with pytest.raises(InvalidSchedule, match="wrong.json"):
        read_schedule(tmp_path / "wrong.json")


def test_missing_files_and_folders(fleet: FleetSchedule, tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="absent.json"):
        read_schedule(tmp_path / "absent.json")
    with pytest.raises(InvalidInput):
        write_schedule(fleet, tmp_path / "absent" / "schedule.json")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("text", ["{}", '{"robots": []}'])
def test_a_file_without_robots_proves_nothing(tmp_path: Path, text: str) -> None:
    path = tmp_path / "schedule.json"
    path.write_text(text)
    with pytest.raises(InvalidSchedule, match="robots"):
        read_schedule(path)
