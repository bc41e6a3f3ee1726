"""What users hand to coordination that is wrong or hardly anything, through the library and on the command line."""

import json
import math
from pathlib import Path
from typing import Any, Callable, Dict, List

import numpy as np
import pytest
from fleets import robot

from social_fleet.cli.main import main
from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import Schedule
from social_fleet.coordination.verification import verify
from social_fleet.errors import Infeasible, InvalidScenario, InvalidSchedule

EAST = [(0.0, 0.0), (10.0, 0.0)]
NORTH = [(5.0, -5.0), (5.0, 5.0)]
WAYS = [{}, {"mode": "sequential"}, {"formulation": "paper"}]
WAY_NAMES = ["simultaneous", "sequential", "as printed"]
ONE = "{name: a, start: [1.5, 8.0], goal: [14.5, 8.0]}"
TWO = "{name: b, start: [8.0, 1.5], goal: [8.0, 14.5]}"


def driven(name: str, points: List, arcs: List[float], times: List[float]) -> Schedule:
    return Schedule(robot(name, *points), np.array(arcs), np.array(times))


@pytest.mark.parametrize("way", WAYS, ids=WAY_NAMES)
def test_no_robot_is_refused(way: Dict[str, Any]) -> None:
    with pytest.raises(InvalidScenario, match="there is no robot to coordinate"):
        coordinate([], **way)
    with pytest.raises(InvalidScenario, match="there is no robot to coordinate"):
        coordinate([], fixed=[driven("x", EAST, [0.0, 10.0], [0.0, 20.0])], **way)


@pytest.mark.parametrize("way", WAYS, ids=WAY_NAMES)
def test_one_robot_is_a_fleet(way: Dict[str, Any]) -> None:
    fleet = coordinate([robot("a", *EAST)], **way)
    assert fleet["a"].arc_lengths[-1] == 10.0 and fleet.windows == () and verify(fleet).safe


@pytest.mark.parametrize("way", WAYS, ids=WAY_NAMES)
@pytest.mark.parametrize("points", [[(0.0, 0.0)], [(0.0, 0.0), (0.0, 0.0)], [(0.0, 0.0), (1e-12, 0.0)]])
def test_a_robot_that_stays_where_it_is(points: List, way: Dict[str, Any]) -> None:
    fleet = coordinate([robot("a", *points), robot("b", *NORTH)], **way)
    assert fleet["a"].robot.path.length == 0.0 and fleet["b"].arc_lengths[-1] == 10.0 and verify(fleet).safe


def test_one_that_stays_in_another_s_way_is_named() -> None:
    with pytest.raises(Infeasible, match=r"a starts in the way of b and a ends in the way of b near \(5\.0, 0\.0\)"):
        coordinate([robot("a", (5.0, 0.0)), robot("b", *NORTH)])


@pytest.mark.parametrize("way", WAYS, ids=WAY_NAMES)
def test_repeated_points_change_nothing(way: Dict[str, Any]) -> None:
    twice = [point for point in EAST[:1] + [(5.0, 0.0)] + EAST[1:] for _ in (0, 1)]
    once, again = (coordinate([robot("a", *path), robot("b", *NORTH)], **way)
                   for path in (twice[::2], twice))
    assert again.objective == pytest.approx(once.objective)


@pytest.mark.parametrize("points", [[(0.0, 0.0), (math.nan, 0.0)], [(0.0, math.inf), (1.0, 0.0)], np.zeros((0, 2))])
def test_a_path_that_is_none_names_robot_and_field(points: Any) -> None:
    with pytest.raises(InvalidScenario, match="path: robot amr_7: a path "):
        Robot("amr_7", points)


@pytest.mark.parametrize("arcs, times, reason", [
    ([0.0, 10.0], [20.0, 0.0], "times: robot x: must rise"), ([0.0, 10.0], [5.0, 5.0], "times: robot x: must rise"),
    ([10.0, 0.0], [0.0, 20.0], "arc_lengths: robot x: must not fall"), ([0.0, 10.0], [0.0, math.nan], "x: a knot is"),
    ([], [], "robot x: arc_lengths and times")])
def test_a_schedule_that_makes_no_sense_is_named(arcs: List[float], times: List[float], reason: str) -> None:
    with pytest.raises(InvalidSchedule, match=reason):
        driven("x", EAST, arcs, times)


@pytest.mark.parametrize("way", WAYS, ids=WAY_NAMES)
def test_names_must_differ(way: Dict[str, Any]) -> None:
    fixed = [driven("a", EAST, [0.0, 10.0], [0.0, 20.0])]
    for fleet, given in (([robot("a", *EAST), robot("a", *NORTH)], []), ([robot("a", *NORTH)], fixed),
                         ([robot("b", *NORTH)], fixed * 2)):
        with pytest.raises(InvalidScenario, match="robots: two robots are named a; names must differ"):
            coordinate(fleet, fixed=given, **way)


@pytest.mark.parametrize("way", WAYS, ids=WAY_NAMES)
@pytest.mark.parametrize("place, what", [((10.0, 0.0), "goals"), ((0.0, 0.0), "starts")])
def test_one_place_for_two_names_both(place: Any, what: str, way: Dict[str, Any]) -> None:
    ends = [(5.0, 5.0), place] if what == "goals" else [place, (5.0, 5.0)]
    with pytest.raises(InvalidScenario, match=f"a and b have {what} 0.00 m apart"):
        coordinate([robot("a", *EAST), robot("b", *ends)], **way)


def test_the_start_of_a_robot_under_way_is_taken() -> None:
    with pytest.raises(Infeasible, match="b starts in the way of a and a starts in the way of b"):
        coordinate([robot("b", (0.0, 0.0), (5.0, 5.0))], fixed=[driven("a", EAST, [0.0, 10.0], [0.0, 20.0])])


@pytest.mark.parametrize("way", WAYS, ids=WAY_NAMES)
@pytest.mark.parametrize("limit", [0.0, -1.0, math.nan])
def test_no_time_is_refused(limit: float, way: Dict[str, Any]) -> None:
    with pytest.raises(InvalidScenario, match="time_limit: must be positive"):
        coordinate([robot("a", *EAST), robot("b", *NORTH)], time_limit=limit, **way)


@pytest.fixture(name="told")
def make_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> Callable[..., Any]:
    """Runs `coordinate` on a scenario of these robots; its exit code and what it says on stderr."""
    monkeypatch.chdir(tmp_path)

    def told(robots: List[str], options: str = "", *arguments: str) -> Any:
        Path("x.yaml").write_text(f"map: package://social_fleet/maps/crossing.yaml\nrobots: [{', '.join(robots)}]\n"
                                  f"coordination: {{{options}}}\n")
        code = main(["coordinate", "x.yaml", *arguments])
        message = capsys.readouterr().err
        assert message.count("\n") <= 1
        return code, message.strip()

    return told


@pytest.mark.parametrize("robots, options, message", [
    ([], "", "robots: must list at least one robot"),
    ([ONE, ONE], "", "robots[1].name: robots[0] has the name a too; names must differ"),
    ([ONE, TWO.replace("14.5]", "8.0]").replace("goal: [8.0", "goal: [14.5")], "",
     "robots[1].goal: robot b would stand 0.00 m from the goal of robot a; their centres need 0.70 m (both radii and "
     "tracking tolerances)"),
    ([ONE.replace("1.5", ".nan"), TWO], "", "robots[0].start[0]: must be a finite number, not nan"),
    ([ONE.replace("}", ", max_speed: .nan}"), TWO], "", "robots[0].max_speed: must be a finite number, not nan"),
    ([ONE.replace("}", ", depart: .inf}"), TWO], "", "robots[0].depart: must be a finite number, not inf"),
    ([ONE, TWO], "time_margin: .nan", "coordination.time_margin: must be a finite number, not nan"),
    ([ONE, TWO], "time_limit: 0", "coordination.time_limit: must be greater than 0, not 0"),
    ([ONE, TWO], "time_limit: soon", "coordination.time_limit: must be a number, not the text 'soon'")])
def test_a_wrong_scenario_is_told_in_a_line(told: Callable[..., Any], robots: List[str], options: str,
                                            message: str) -> None:
    assert told(robots, options) == (2, f"error: x.yaml: {message}")


@pytest.mark.parametrize("limit", ["0", "-1", "nan", "inf", "soon"])
def test_a_wrong_limit_is_told_in_a_line(told: Callable[..., Any], limit: str) -> None:
    code, message = told([ONE, TWO], "", "--time-limit", limit)
    assert code == 2 and message.startswith("error: command line: --time-limit: must be a ")


def test_a_limit_too_small_is_a_negative_answer(told: Callable[..., Any]) -> None:
    code, message = told([ONE, TWO], "", "--time-limit", "1e-9")
    assert code == 1 and message.startswith("timed out: no schedule within the time limit")


def test_little_is_enough(told: Callable[..., Any]) -> None:
    assert told([ONE]) == (0, "")
    assert told([TWO, "{name: a, start: [1.5, 8.0], goal: [1.5, 8.0]}"]) == (0, "")


@pytest.mark.parametrize("change, code, message", [
    ({"times": [3.0, 2.0, 1.0]}, 2, "error: s.json: robots[0].times: robot a: must rise from knot to knot"),
    ({"times": [0.0, math.nan, 9.0]}, 2, "error: s.json: not valid JSON: NaN is not a number"),
    ({"name": "b"}, 2, "error: s.json: robots: two robots are named b; names must differ"),
    ({"path": [[0.0, 0.0], [0.0, 0.0]], "arc_lengths": [0.0, 0.0, 0.0]}, 0, ""),
    ({"path": NORTH}, 1, "")])
def test_schedules_are_judged_or_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, change: Dict[str, Any],
                                         code: int, message: str, capsys: pytest.CaptureFixture) -> None:
    monkeypatch.chdir(tmp_path)
    common = {"radius": 0.25, "max_speed": 0.7, "arc_lengths": [0.0, 5.0, 10.0], "times": [0.0, 10.0, 20.0]}
    Path("s.json").write_text(json.dumps({"robots": [
        {**common, "name": "a", "path": [[0.0, 9.0], [10.0, 9.0]], **change}, {**common, "name": "b", "path": NORTH}]}))
    assert main(["verify", "s.json"]) == code
    assert capsys.readouterr().err.strip() == message
