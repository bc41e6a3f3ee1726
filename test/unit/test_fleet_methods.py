"""Figure 10: the methods get the same fleets, their failures are values, and hopeless sizes are not run."""

from typing import Any, Dict, List, Sequence

import numpy as np
import pytest
from test_experiments import RING, WORLD

from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.errors import TimedOut
from social_fleet.experiments import fig10
from social_fleet.experiments.cells import Work
from social_fleet.experiments.fleet_methods import METHODS, FleetMethods
from social_fleet.experiments.fleets import random_specs
from social_fleet.scenario.scenario import RobotSpec


@pytest.fixture(name="methods", scope="module")
def make_methods() -> FleetMethods:
    return FleetMethods(RING)


@pytest.mark.parametrize("method", list(METHODS))
def test_every_method_brings_the_fleet_to_its_goals_without_contact(methods: FleetMethods, method: str) -> None:
    specs = random_specs(RING, ["a", "b", "c"], 5)
    value = methods.attempt(method, specs, 30.0)
    alone = methods.alone(specs)
    assert value["failure"] is None and value["min_clearance"] >= 0.0
    assert value["makespan"] >= 0.95 * max(alone) and value["sum_of_completion"] >= 0.95 * sum(alone)
    assert 0.0 < value["planning_time"] + value["windows_time"] + value["solving_time"] <= value["time"]


def test_a_failure_is_a_value(methods: FleetMethods, monkeypatch: pytest.MonkeyPatch) -> None:
    def late(specs: Sequence[RobotSpec], limit: float) -> FleetSchedule:
        raise TimedOut(f"{len(specs)} robots took longer than {limit} s")

    monkeypatch.setitem(methods._solvers, "cbs", late)
    value = methods.attempt("cbs", random_specs(RING, ["a", "b"], 0), 3.0)
    assert value["failure"] == "TimedOut" and value["reason"] == "2 robots took longer than 3.0 s"
    assert value["time"] >= 0.0 and "makespan" not in value


class Pretended:
    """Methods that note what they are asked: CBS solves fleets of two only, PP nothing in its first trial."""

    asked: List[Any] = []

    def __init__(self, grid: Any) -> None:
        self.seen = 0

    def attempt(self, method: str, specs: Sequence[RobotSpec], limit: float) -> Dict[str, Any]:
        self.asked.append((method, len(specs), specs[0].start, limit))
        if method == "cbs" and len(specs) > 2:
            return {"failure": "TimedOut", "reason": "late", "time": limit}
        return {"failure": None, "reason": "", "time": 1.0, "planning_time": 0.5, "windows_time": 0.0,
                "solving_time": 0.5, "makespan": 30.0, "sum_of_completion": 10.0 * len(specs), "gap": 0.0,
                "min_clearance": 0.1}

    def alone(self, specs: Sequence[RobotSpec]) -> List[float]:
        return [5.0] * (len(specs) - 1) + [20.0]


@pytest.fixture(name="pretended")
def make_pretended(monkeypatch: pytest.MonkeyPatch) -> List[Any]:
    monkeypatch.setattr(fig10, "FleetMethods", Pretended)
    monkeypatch.setattr(fig10, "SIZES", (2, 3, 4))
    monkeypatch.setattr(Pretended, "asked", [])
    return Pretended.asked


def test_a_method_that_solved_no_fleet_of_a_size_is_not_run_on_larger_ones(pretended: List[Any]) -> None:
    values = fig10.measure(RING, 2, 7, 60.0, Work("fig10", fig10.__name__))
    assert [size for method, size, *_ in pretended if method == "cbs"] == [2, 2, 3, 3]
    assert [size for method, size, *_ in pretended if method == "pp"] == [2, 2, 3, 3, 4, 4]
    assert len({start for _, _, start, _ in pretended}) == 2  # the same fleets for all, the smaller ones within larger
    rows = fig10.rows_of(WORLD, values)
    cbs = [row for row in rows if row["method"] == "cbs"]
    assert [(row["robots"], row["success_rate"], row["not_run"]) for row in cbs] == [
        (2, 1.0, False), (3, 0.0, False), (4, 0.0, True)]
    assert cbs[1]["makespan_mean"] is None
    assert cbs[0]["makespan_ratio_mean"] == pytest.approx(1.5) and cbs[0]["sum_ratio_mean"] == pytest.approx(0.8)


def test_an_interrupted_run_goes_on_where_it_was(pretended: List[Any], tmp_path: Any) -> None:
    shares: List[float] = []
    work = Work("fig10", fig10.__name__, folder=tmp_path, progress=lambda done, total: shares.append(done / total))
    first = fig10.measure(RING, 2, 7, 60.0, work)
    assert np.all(np.diff(shares) >= 0.0) and shares[-1] == 1.0
    pretended.clear()
    assert fig10.measure(RING, 2, 7, 60.0, work) == first and pretended == []
    fig10.measure(RING, 2, 7, 30.0, work)
    assert {limit for *_, limit in pretended} == {30.0}
