"""Experiments with a few robots: what becomes of a fleet, and Figures 9, 11, 14 and 15 on their own maps."""

import json
from typing import Dict

import numpy as np
import pytest

from social_fleet.coordination.robot import Robot
from social_fleet.experiments import experiment_named, fig9, fig11, fig14, fig15
from social_fleet.experiments.fleets import Outcome, coordinated, seed_of
from social_fleet.experiments.frame import World

EAST = np.array([(0.0, 0.0), (10.0, 0.0)])
NORTH = np.array([(5.0, -5.0), (5.0, 5.0)])


def test_robots_that_never_meet_are_unhindered() -> None:
    found = coordinated([Robot("a", EAST), Robot("b", EAST + (0.0, 3.0))])
    assert found.feasible and found.unhindered and found.contested == 0.0
    assert found.delays == pytest.approx([0.0, 0.0]) and found.min_clearance == pytest.approx(2.5)


def test_one_waits_at_a_crossing() -> None:
    found = coordinated([Robot("a", EAST), Robot("b", NORTH)])
    assert found.feasible and not found.unhindered and max(found.delays) > 0.5
    assert 1.0 < found.contested < 2.0 and fig15.together(found) == 0.0
    moments = fig15.moments_of(found)
    assert len(moments) == 2 and "waits" in moments[0][1] and "waits" not in moments[1][1]


def test_without_a_schedule_there_is_a_reason_and_a_picture_of_it() -> None:
    found = coordinated([Robot("a", EAST), Robot("b", EAST[::-1])])
    assert not found.feasible and not found.unhindered and "no schedule" in found.reason
    assert found.min_clearance is None and [window.first for window in found.fleet.windows] == [""]
    assert found.contested == pytest.approx(10.0, abs=0.01) and found.delays == [0.0, 0.0]
    assert fig14.story(found) == "no schedule, for each stands in the other's way"


def test_an_outcome_is_the_same_from_the_disk() -> None:
    for robots in ([Robot("a", EAST), Robot("b", NORTH)], [Robot("a", EAST), Robot("b", EAST[::-1])]):
        found = coordinated(robots)
        again = Outcome.from_value(json.loads(json.dumps(found.to_value())))
        assert again.to_value() == found.to_value() and again.contested == found.contested


def test_every_trial_has_a_seed_of_its_own() -> None:
    seeds = [seed_of(seed, trial) for seed in range(10) for trial in range(10)]
    assert len(set(seeds)) == 100 and seed_of(3, 4) == seed_of(3, 4)


def test_the_four_robots_of_figure_9() -> None:
    result = experiment_named("fig9").run([World.of_package("environment_1")], trials=2, seed=0)
    assert [row["robot"] for row in result.rows] == ["blue", "purple", "gold", "green"]
    by_name = {row["robot"]: row for row in result.rows}
    assert by_name["gold"]["first_in"] == by_name["gold"]["windows"] >= 1  # as in the paper
    orders = [window["first"] for window in result.details["windows"]
              if {window["robot_r"], window["robot_s"]} == {"blue", "purple"}]
    assert len(set(orders)) == 1 and result.details["min_clearance"] >= 0.2 - 1e-6
    assert "0.7 m/s over 1, 1.2, 3.2 and 3" in result.caption and "gold" in result.caption


def test_on_another_map_figure_9_draws_robots_of_the_same_speeds() -> None:
    world = World("crossing_copy", World.of_package("crossing").grid)
    first, again, other = (fig9.robots_on(world, seed) for seed in (1, 1, 2))
    assert first == again != other
    assert [spec.max_speed for spec in first] == [spec.max_speed for spec in fig9.ROBOTS]


def test_figure_14_as_in_the_paper() -> None:
    rows = experiment_named("fig14").run([World.of_package("office_floor")], trials=2, seed=0).rows
    cases: Dict[str, Dict[str, Dict]] = {}
    for row in rows:
        cases.setdefault(row["case"], {})[row["method"]] = row
    waiting, swap = cases["from room to room"], cases["changing places"]
    assert waiting["shortest"]["delay"] > 10.0 and waiting["shortest"]["without_schedule"] == 0
    assert waiting["social"]["unhindered"] == 1 and waiting["social"]["makespan"] < waiting["shortest"]["makespan"]
    assert swap["shortest"]["without_schedule"] == 1 and swap["social"]["unhindered"] == 1
    assert cases["random pairs"]["social"]["pairs"] == 2


def test_figure_15_as_in_the_paper() -> None:
    rows = experiment_named("fig15").run([World.of_package("crossing")], trials=3, seed=0).rows
    assert [row["robots"] for row in rows] == [2, 3] and [row["without_schedule"] for row in rows] == [0, 0]
    assert all(row["together_max"] < 1.0 and row["min_clearance"] >= 0.2 - 1e-6 for row in rows)


def test_figure_11_counts_more_in_larger_fleets(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fig11, "SIZES", (2, 4))
    monkeypatch.setattr(fig11, "SHOWN", 2)
    monkeypatch.setattr("social_fleet.planning.planner.RRT_SAMPLES", 300)
    result = experiment_named("fig11").run([World.of_package("environment_1")], trials=3, seed=0)
    means = {(row["method"], row["robots"]): row["segments_mean"] for row in result.rows}
    assert len(means) == 6 and all(means[method, 2] <= means[method, 4] for method in ("shortest", "social"))
    assert len(result.details["example"]["social"]["paths"]) == 2


def test_smaller_fleets_are_the_first_robots_of_larger_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    grid = World.of_package("crossing").grid
    monkeypatch.setattr("social_fleet.planning.planner.RRT_SAMPLES", 300)
    values = []
    for sizes in ((2,), (2, 3)):
        monkeypatch.setattr(fig11, "SIZES", sizes)
        values.append(fig11.cells_of(grid, 1, 5)[0].compute()["social"][0])
    assert values[0] == values[1]
