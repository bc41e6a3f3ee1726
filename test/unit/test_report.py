"""Reports: the fields of report.json, and when a run passes."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from driving import schedule_of
from worlds import grid_from_text

from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.errors import InvalidScenario
from social_fleet.scenario.recording import Recording
from social_fleet.scenario.report import judge, write_report
from social_fleet.scenario.scenario import Expect

FLEET = FleetSchedule((schedule_of([(1.5, 1.5), (5.5, 1.5)], name="gold"),
                       schedule_of([(1.5, 2.5), (5.5, 2.5)], name="green")))
HALL = grid_from_text("""
    ########
    #......#
    #......#
    ########
""")


def recording(gold: list, green: list) -> Recording:
    poses = np.zeros((len(gold), 2, 3))
    poses[:, 0, :2], poses[:, 1, :2] = gold, green
    return Recording(("gold", "green"), np.arange(float(len(gold))), poses)


GOOD = recording([(1.5, 1.5), (5.5, 1.5), (5.5, 1.5)], [(1.5, 2.5), (3.0, 2.5), (5.5, 2.5)])


def test_a_good_run_passes() -> None:
    report = judge(GOOD, FLEET, grid=HALL, scenario="hall", wall_time=0.5)
    assert report.passed and report.failures == () and report.collisions == ()
    assert (report.makespan, report.sum_of_completion, report.simulated_time) == (2.0, 3.0, 2.0)
    assert report.min_clearance == pytest.approx(0.5) and report.min_wall_clearance == pytest.approx(0.25)


def test_the_file_has_the_fields_of_the_contract(tmp_path: Path) -> None:
    write_report(judge(GOOD, FLEET, scenario="hall"), tmp_path / "report.json")
    values = json.loads((tmp_path / "report.json").read_text())
    assert {"scenario", "passed", "makespan", "sum_of_completion", "collisions", "min_clearance", "robots", "wall_time",
            "simulated_time"} <= set(values)
    assert {"name", "arrived", "arrival_time", "scheduled_time", "path_length", "max_tracking_error",
            "replans"} <= set(values["robots"][0])


def test_a_planted_collision_fails() -> None:
    report = judge(recording([(1.5, 1.5), (3.0, 2.2), (5.5, 1.5)], [(1.5, 2.5), (3.0, 2.5), (5.5, 2.5)]), FLEET)
    assert not report.passed and [contact.kind for contact in report.collisions] == ["robots"]
    assert report.min_clearance is not None and report.min_clearance < 0.0
    assert "gold and green touched" in report.failures[0]


def test_a_planted_wall_contact_fails() -> None:
    report = judge(recording([(1.5, 1.5), (3.0, 1.1), (5.5, 1.5)], [(1.5, 2.5), (3.0, 2.5), (5.5, 2.5)]), FLEET,
                   grid=HALL)
    assert [contact.kind for contact in report.collisions] == ["wall"] and "gold touched a wall" in report.failures[0]


def test_who_does_not_arrive_fails_unless_that_is_expected() -> None:
    late = recording([(1.5, 1.5), (5.5, 1.5)], [(1.5, 2.5), (3.0, 2.5)])
    report = judge(late, FLEET)
    assert report.failures == ("robot green did not arrive",)
    assert report.makespan is None and report.sum_of_completion is None
    assert judge(late, FLEET, Expect(arrived=("gold",))).passed


def test_a_robot_alone_has_no_clearance() -> None:
    alone = Recording(("gold",), GOOD.times, GOOD.poses[:, :1])
    assert judge(alone, FleetSchedule(FLEET.schedules[:1])).min_clearance is None


def test_lateness_and_tracking_error_can_be_expected() -> None:
    assert not judge(GOOD, FLEET, Expect(max_lateness=-math.inf)).passed
    assert not judge(GOOD, FLEET, Expect(max_tracking_error=-1.0)).passed


def test_arriving_too_early_fails_like_arriving_too_late() -> None:
    scheduled = FLEET["gold"].arrival_time
    early = Recording(GOOD.names, GOOD.times / GOOD.duration * 0.5 * scheduled, GOOD.poses)
    failures = judge(early, FLEET, Expect(max_lateness=0.3 * scheduled)).failures
    assert any("gold" in failure and "early" in failure for failure in failures)


def test_unknown_robots_are_refused() -> None:
    with pytest.raises(InvalidScenario, match="no robot blue"):
        judge(GOOD, FLEET, Expect(arrived=("blue",)))
    with pytest.raises(InvalidScenario, match="lacks robot green"):
        judge(Recording(("gold",), GOOD.times, GOOD.poses[:, :1]), FLEET)
