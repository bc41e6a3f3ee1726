"""Each verb does what it says, on tiny worlds, and refuses what is wrong before it starts."""

import json
import os
from pathlib import Path
from typing import Any, List

import pytest
from PIL import Image
from worlds import grid_from_text

from social_fleet.cli.coordinate import summary
from social_fleet.cli.main import main
from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.mapping.files import save_map

HALL = "\n".join(["#" * 14, *["#" + "." * 12 + "#"] * 8, "#" * 14])
ROOMS = "\n".join(["#" * 9, *["#...#...#"] * 5, "#" * 9])
SCENARIO = """\
map: hall.yaml
robots:
  - {name: gold, start: [1.5, 4.5, 0.0], goal: [12.5, 4.5], max_speed: 0.5}
  - {name: blue, start: [7.0, 1.5, 1.57], goal: [7.0, 8.5]}
"""


@pytest.fixture(name="folder", autouse=True)
def make_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    save_map(grid_from_text(HALL), str(tmp_path / "hall.yaml"))
    save_map(grid_from_text(ROOMS), str(tmp_path / "rooms.yaml"))
    (tmp_path / "s.yaml").write_text(SCENARIO)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run_json(capsys: pytest.CaptureFixture, *arguments: str, code: int = 0) -> Any:
    assert main([*arguments, "--json"]) == code
    return json.loads(capsys.readouterr().out)


def refused(capsys: pytest.CaptureFixture, *arguments: str) -> str:
    before = sorted(os.listdir("."))
    assert main(list(arguments)) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and captured.err.count("\n") == 1 and sorted(os.listdir(".")) == before
    return captured.err.strip()


def test_plan_writes_what_the_contract_names(capsys: pytest.CaptureFixture) -> None:
    shown = run_json(capsys, "plan", "--map", "hall.yaml", "--start", "2", "2", "0", "--goal", "11", "7",
                     "--out", "plan.json", "--plot", "plan.png")
    with open("plan.json") as stream:
        assert json.load(stream) == shown
    assert list(shown) == ["map", "planner", "robot_radius", "points", "length", "social_cost", "cost", "expanded",
                           "search_time", "status"]
    assert (shown["map"], shown["planner"], shown["status"]) == ("hall.yaml", "social", "ok")
    assert shown["points"][0] == [2.0, 2.0] and shown["points"][-1] == [11.0, 7.0]
    assert Image.open("plan.png").format == "PNG"


@pytest.mark.parametrize("planner", ["social", "shortest"])
def test_plan_sums_up_in_words(capsys: pytest.CaptureFixture, planner: str) -> None:
    assert main(["plan", "--map", "hall.yaml", "--start", "2", "2", "--goal", "11", "7", "--planner", planner]) == 0
    assert capsys.readouterr().out.startswith(f"{planner} path on hall.yaml: ")


def test_no_path_is_a_negative_answer(capsys: pytest.CaptureFixture) -> None:
    shown = run_json(capsys, "plan", "--map", "rooms.yaml", "--start", "2", "2", "--goal", "6", "2", "--out", "p.json",
                     code=1)
    assert (shown["status"], shown["points"]) == ("no_path_found", []) and "no path" in shown["message"]
    assert os.path.exists("p.json")


@pytest.mark.parametrize("start, goal, message", [
    (["20", "2"], ["6", "2"], "error: hall.yaml: --start: (20.00, 2.00) is off the map"),
    (["2", "2"], ["0.5", "2"], "error: hall.yaml: --goal: (0.50, 2.00) lies in a wall"),
    (["1.1", "2"], ["6", "2"], "error: hall.yaml: --start: (1.10, 2.00) is 0.10 m from the nearest wall"),
    (["nan", "2"], ["6", "2"], "error: hall.yaml: --start: (nan, 2.00) is not finite"),
    (["2", "2", "inf"], ["6", "2"], "error: hall.yaml: --start: the yaw inf is not finite"),
])
def test_plan_refuses_unusable_poses(capsys: pytest.CaptureFixture, start: List[str], goal: List[str],
                                     message: str) -> None:
    assert refused(capsys, "plan", "--map", "hall.yaml", "--start", *start, "--goal", *goal, "--out",
                   "p.json").startswith(message)


OVERLAYS = """\
- {center: [6.5, 2.0], radius: 0.5}
- {name: pallet, shape: rectangle, center: [6.5, 5.0], size: [1.0, 2.0], yaw: 0.3}
- {shape: polygon, points: [[9, 1], [10, 1], [9.5, 2]]}
"""


def test_plan_goes_round_obstacles(capsys: pytest.CaptureFixture) -> None:
    Path("o.yaml").write_text(OVERLAYS)
    command = ["plan", "--map", "hall.yaml", "--start", "2", "5", "--goal", "11", "5"]
    straight = run_json(capsys, *command)
    shown = run_json(capsys, *command, "--overlays", "o.yaml", "--plot", "p.png")
    assert shown["temporary"] is True and "temporary" not in straight
    assert shown["points"] != straight["points"] and Image.open("p.png").format == "PNG"
    far = run_json(capsys, *command[:3], "--start", "2", "7", "--goal", "2", "8", "--overlays", "o.yaml")
    assert far["temporary"] is False


@pytest.mark.parametrize("text, message", [
    ("shape: circle", "o.yaml: must be a list of obstacles"), ("- 3", "o.yaml: [0]: must be a mapping"),
    ("- {center: [6.0, 2.0]}", "o.yaml: [0].radius: is missing"),
    ("- {center: [6.0, 2.0], radius: 0}", "o.yaml: [0].radius: must be greater than 0"),
    ("- {center: [6.0], radius: 1}", "o.yaml: [0].center: must be a list [x, y]"),
    ("- {center: [60.0, 2.0], radius: 1}", "o.yaml: [0]: the obstacle lies off the map"),
    ("- {shape: star, center: [6.0, 2.0], radius: 1}", "o.yaml: [0].shape: must be circle or rectangle or polygon"),
    ("- {shape: rectangle, center: [6.0, 2.0], size: [1, -1]}", "o.yaml: [0].size[1]: must be positive"),
    ("- {shape: polygon, points: [[1, 1], [2, 2]]}", "o.yaml: [0].points: must be a list of three corners"),
    ("- {shape: polygon, points: [[1, 1], [2, 2], [3, x]]}", "o.yaml: [0].points[2]: must be two finite numbers"),
    ("- {shape: polygon, points: [[1, 1], [2, 2], [2, 1], [1, 2]]}", "o.yaml: [0].points: the sides"),
    ("- {center: [6.0, 2.0], radius: 1, appears: 3}", "o.yaml: [0].appears: is not known here"),
    ("- {name: a, center: [6, 2], radius: 1}\n- {name: a, center: [6, 5], radius: 1}", "o.yaml: [1].name: there is"),
    ("- {name: cart, center: [2.0, 2.0], radius: 1}", "hall.yaml: --start: (2.00, 2.00) lies in the obstacle 'cart'"),
])
def test_plan_refuses_what_is_no_obstacle(capsys: pytest.CaptureFixture, text: str, message: str) -> None:
    Path("o.yaml").write_text(text)
    assert refused(capsys, "plan", "--map", "hall.yaml", "--start", "2", "2", "--goal", "11", "5", "--overlays",
                   "o.yaml", "--out", "p.json").startswith(f"error: {message}")


def test_learn_merges_what_others_learnt(capsys: pytest.CaptureFixture) -> None:
    Path("c.yaml").write_text("min_component: 2")
    learn = ["learn", "--map", "hall.yaml", "--config", "c.yaml"]
    for seed in "12":
        run_json(capsys, *learn, "--paths", "20", "--seed", seed, "--out", f"g{seed}")
    both = run_json(capsys, *learn, "--merge", "g1", "g2", "--out", "a", "--graphml", "a.graphml")
    again = run_json(capsys, *learn, "--merge", "g2", "--paths", "20", "--seed", "1", "--out", "b")
    assert both["edges"] == again["edges"] > 0 and both["merged"] == ["g1", "g2"]
    assert Path("a.graphml").read_text().count("<edge ") == both["edges"]
    assert main([*learn, "--merge", "g1", "g2", "--paths", "5", "--out", "c"]) == 0
    assert "from 5 paths and 2 other graphs" in capsys.readouterr().out


def test_learn_refuses_what_cannot_be_merged(capsys: pytest.CaptureFixture) -> None:
    shown = refused(capsys, "learn", "--map", "hall.yaml", "--out", "g")
    assert shown.startswith("error: command line: --paths: is missing")
    run_json(capsys, "learn", "--map", "rooms.yaml", "--paths", "5", "--out", "rooms.graph")
    for file, message in (("rooms.graph", "map: was learnt on another map, and none of its edges holds"),
                          ("hall.yaml", "is no social graph"), ("none", "cannot be read")):
        shown = refused(capsys, "learn", "--map", "hall.yaml", "--merge", file, "--out", "g")
        assert shown.startswith(f"error: {file}: {message}")
    save_map(grid_from_text(HALL, 0.5), "fine.yaml")
    shown = refused(capsys, "learn", "--map", "fine.yaml", "--merge", "rooms.graph", "--out", "g")
    assert shown.startswith("error: rooms.graph: resolution: was learnt on cells of 1 m")


def test_learn_follows_a_map_that_changed(capsys: pytest.CaptureFixture) -> None:
    Path("c.yaml").write_text("{min_component: 2, heatmap_threshold: 0}")
    run_json(capsys, "learn", "--map", "hall.yaml", "--paths", "20", "--config", "c.yaml", "--out", "old")
    save_map(grid_from_text(HALL.replace("." * 12, "." * 10 + "##")), "changed.yaml")
    command = ["plan", "--map", "changed.yaml", "--graph", "old", "--start", "2", "2", "--goal", "9", "5"]
    assert refused(capsys, *command).startswith("error: old: map: was learnt on another map; learn it again")
    assert main(["learn", "--map", "changed.yaml", "--merge", "old", "--config", "c.yaml", "--out", "new"]) == 0
    warned = capsys.readouterr().err
    assert "old was learnt on another map" in warned and " 0 are dropped" not in warned
    command[4] = "new"
    assert main(command) == 0


def test_plan_takes_many_pairs(capsys: pytest.CaptureFixture) -> None:
    pairs = [[[1.5, 1.5], [3.0, 4.0]], [[1.5, 1.5], [6.0, 2.0]], [[6.0, 2.0, 0.5], [7.0, 4.0]]]
    Path("pairs.json").write_text(json.dumps(pairs))
    shown = run_json(capsys, "plan", "--map", "rooms.yaml", "--batch", "pairs.json", "--plot", "p.png", code=1)
    assert [record["status"] for record in shown] == ["ok", "no_path_found", "ok"]


@pytest.mark.parametrize("content, message", [
    ("[", "error: pairs.json: line 1, column 2: not valid JSON"),
    ("{}", "error: pairs.json: must be a list of pairs"),
    ("[]", "error: pairs.json: must be a list of pairs"),
    ("[[[1, 1], [2]]]", "error: pairs.json: [0]: must be a pair [[x, y], [x, y]], not [[1, 1], [2]]"),
    ('[[[2, 2], [2, "a"]]]', "error: pairs.json: [0]: must be a pair"),
    (f"[[[2, 2], [2, 1{'0' * 400}]]]", "error: pairs.json: [0]: must be a pair"),
    ("[[[2, 2], [3, 3]], [[2, 2], [0.5, 3]]]", "error: pairs.json: [1][1]: (0.50, 3.00) lies in a wall"),
    ("[[[NaN, 2], [3, 3]]]", "error: pairs.json: not valid JSON: NaN is not a number"),
])
def test_a_wrong_batch_is_refused_before_any_plan(capsys: pytest.CaptureFixture, content: str, message: str) -> None:
    Path("pairs.json").write_text(content)
    assert refused(capsys, "plan", "--map", "hall.yaml", "--batch", "pairs.json", "--out", "o.json").startswith(message)


@pytest.mark.parametrize("content, message", [
    ("side: up\n", "error: c.yaml: side: must be one of right, left, none"),
    ("robot_radius: -1\n", "error: c.yaml: robot_radius: must be "),
    ("speed: 1\n", "error: c.yaml: speed: "),
    ("- 1\n", "error: c.yaml: must be a mapping"),
    ("side: [\n", "error: c.yaml: line 2, column 1: not valid YAML"),
])
def test_a_wrong_configuration_is_refused(capsys: pytest.CaptureFixture, content: str, message: str) -> None:
    Path("c.yaml").write_text(content)
    assert refused(capsys, "plan", "--map", "hall.yaml", "--start", "2", "2", "--goal", "6", "2", "--config",
                   "c.yaml").startswith(message)


def test_the_configuration_is_used(capsys: pytest.CaptureFixture) -> None:
    Path("c.yaml").write_text("{side: left, robot_radius: 0.4}\n")
    shown = run_json(capsys, "plan", "--map", "hall.yaml", "--start", "2", "2", "--goal", "6", "2", "--config",
                     "c.yaml")
    assert shown["robot_radius"] == 0.4


@pytest.mark.parametrize("content, message", [
    (None, "error: m.yaml: there is no such file"),
    ("image: none.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n",
     "error: "),
    ("resolution: 0.1\n", "error: m.yaml: "),
    ("image: hall.pgm\nresolution: -1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n",
     "error: m.yaml: resolution: "),
])
def test_a_wrong_map_is_refused(capsys: pytest.CaptureFixture, content: Any, message: str) -> None:
    if content is not None:
        Path("m.yaml").write_text(content)
    assert refused(capsys, "plan", "--map", "m.yaml", "--start", "2", "2", "--goal", "6", "2").startswith(message)


def test_an_output_that_cannot_be_written_is_refused_first(capsys: pytest.CaptureFixture) -> None:
    for arguments in (["plan", "--map", "none.yaml", "--start", "2", "2", "--goal", "6", "2", "--out", "no/p.json"],
                      ["learn", "--map", "none.yaml", "--paths", "5", "--out", "no/g"],
                      ["coordinate", "none.yaml", "--plot", "no/p.png"],
                      ["simulate", "none.yaml", "--animate", "no/p.gif"],
                      ["random-scenario", "--map", "none.yaml", "--robots", "2", "--out", "no/s.yaml"]):
        message = refused(capsys, *arguments)
        assert message.startswith("error: no/") and "does not exist; create it first" in message


def test_a_learnt_graph_is_used(capsys: pytest.CaptureFixture) -> None:
    shown = run_json(capsys, "learn", "--map", "hall.yaml", "--paths", "60", "--seed", "1", "--out", "g")
    assert shown["nodes"] > 0 and shown["edges"] > 0
    plan = ["plan", "--start", "2", "2", "--goal", "11", "7", "--graph", "g"]
    assert run_json(capsys, *plan, "--map", "hall.yaml")["status"] == "ok"
    assert refused(capsys, *plan, "--map", "rooms.yaml").startswith("error: g: ")
    Path("g").write_bytes(Path("g").read_bytes()[:100])
    assert refused(capsys, *plan, "--map", "hall.yaml").startswith("error: g: ")


def test_coordinate_then_verify(capsys: pytest.CaptureFixture) -> None:
    schedule = run_json(capsys, "coordinate", "s.yaml", "--out", "schedule.json", "--plot", "schedule.png")
    assert [robot["name"] for robot in schedule["robots"]] == ["gold", "blue"]
    assert {"map", "status", "formulation", "objective", "gap", "windows"} <= set(schedule)
    with open("schedule.json") as stream:
        assert json.load(stream) == schedule
    verdict = run_json(capsys, "verify", "schedule.json")
    assert verdict["safe"] and verdict["min_clearance"] > 0.0 and len(verdict["pairs"]) == 1
    assert main(["verify", "schedule.json"]) == 0
    assert "safe: no two robots ever come closer than" in capsys.readouterr().out


def test_where_nobody_can_be_served_no_file_is_written(folder: Path, capsys: pytest.CaptureFixture) -> None:
    save_map(grid_from_text("\n".join(["#" * 12, "#" + "." * 10 + "#", "#" * 12])), str(folder / "lane.yaml"))
    (folder / "lane_s.yaml").write_text("map: lane.yaml\nrobots:\n"
                                        "  - {name: gold, start: [1.5, 1.5], goal: [10.4, 1.5]}\n"
                                        "  - {name: blue, start: [10.5, 1.5], goal: [1.6, 1.5]}\n")
    assert main(["coordinate", "lane_s.yaml", "--partial", "--out", "none.json", "--plot", "none.png"]) == 1
    told = capsys.readouterr().out
    assert "left out: blue" in told and "left out: gold" in told and "nobody is served" in told
    assert not (folder / "none.json").exists() and not (folder / "none.png").exists()


def test_options_override_the_file(capsys: pytest.CaptureFixture) -> None:
    schedule = run_json(capsys, "coordinate", "s.yaml", "--mode", "sequential", "--formulation", "paper",
                        "--time-limit", "5")
    assert schedule["formulation"] == "paper"


def test_verify_finds_a_collision(capsys: pytest.CaptureFixture) -> None:
    schedule = run_json(capsys, "coordinate", "s.yaml")
    for robot in schedule["robots"]:
        robot.update(arc_lengths=[0.0, 20.0], times=[0.0, 20.0], path=[[0.0, 5.0], [20.0, 5.0]], precedences=[])
    Path("bad.json").write_text(json.dumps(schedule))
    verdict = run_json(capsys, "verify", "bad.json", code=1)
    assert not verdict["safe"] and verdict["min_clearance"] == -0.5
    assert main(["verify", "bad.json"]) == 1
    assert "not safe: 1 of 1 pairs collide, the worst by 0.500 m" in capsys.readouterr().out


def test_verify_of_one_robot(capsys: pytest.CaptureFixture) -> None:
    schedule = run_json(capsys, "coordinate", "s.yaml")
    Path("one.json").write_text(json.dumps(dict(schedule, robots=schedule["robots"][:1], windows=[])))
    assert run_json(capsys, "verify", "one.json")["min_clearance"] is None
    assert main(["verify", "one.json"]) == 0


@pytest.mark.parametrize("verb", ["coordinate", "simulate"])
@pytest.mark.parametrize("old, new, message", [
    ("hall.yaml", "none.yaml", "error: bad.yaml: map: there is no file"),
    ("name: blue", "name: gold", "error: bad.yaml: robots[1].name: robots[0] has the name gold too"),
    ("max_speed: 0.5", "max_speed: -0.5", "error: bad.yaml: robots[0].max_speed: must be greater than 0"),
    ("[7.0, 1.5, 1.57]", "[7.0, 0.5]", "error: bad.yaml: robots[1].start: robot blue: (7.00, 0.50) lies in a wall"),
    ("goal: [7.0, 8.5]", "goal: [70.0, 8.5]", "error: bad.yaml: robots[1].goal: robot blue: (70.00, 8.50) is off"),
    ("[7.0, 1.5, 1.57]", "[1.5, 4.0]", "error: bad.yaml: robots[1].start: robot blue would stand 0.50 m from"),
])
def test_a_wrong_scenario_is_refused(capsys: pytest.CaptureFixture, verb: str, old: str, new: str,
                                     message: str) -> None:
    Path("bad.yaml").write_text(SCENARIO.replace(old, new))
    assert refused(capsys, verb, "bad.yaml", "--out", "out.json").startswith(message)


def test_simulate_writes_report_and_pictures(capsys: pytest.CaptureFixture) -> None:
    report = run_json(capsys, "simulate", "s.yaml", "--out", "report.json", "--animate", "fleet.gif", "--plot", "run")
    with open("report.json") as stream:
        assert json.load(stream) == report
    assert report["passed"] and report["collisions"] == [] and report["min_clearance"] > 0.0
    assert [robot["arrived"] for robot in report["robots"]] == [True, True]
    assert Image.open("fleet.gif").n_frames > 10
    assert os.path.exists("run_map.png") and os.path.exists("run_time.png")


def test_a_run_that_fails_is_a_negative_answer(capsys: pytest.CaptureFixture) -> None:
    Path("f.yaml").write_text(SCENARIO + "expect: {max_lateness: 1.0}\n"
                              "faults: [{robot: gold, kind: pause, at: 3.0, duration: 20.0}]\n")
    assert main(["simulate", "f.yaml"]) == 1
    assert "FAILED" in capsys.readouterr().out


def test_a_random_scenario_runs(capsys: pytest.CaptureFixture, folder: Path) -> None:
    (folder / "scenarios").mkdir()
    arguments = ["random-scenario", "--map", "hall.yaml", "--robots", "3", "--seed", "5", "--mixed"]
    shown = run_json(capsys, *arguments, "--out", "scenarios/r.yaml")
    assert shown["map"] == "../hall.yaml" and len(shown["robots"]) == 3
    assert run_json(capsys, *arguments, "--out", "scenarios/again.yaml") == shown
    assert Path("scenarios/r.yaml").read_text() == Path("scenarios/again.yaml").read_text()
    assert main(["simulate", "scenarios/r.yaml"]) == 0


def test_too_many_random_robots_are_refused(capsys: pytest.CaptureFixture) -> None:
    assert "no room for 500 robots" in refused(capsys, "random-scenario", "--map", "hall.yaml", "--robots", "500",
                                               "--out", "r.yaml")


ZONES = "zones: [{name: hall, polygon: [[0, 0], [14, 0], [14, 10], [0, 10]], side: none}]"
TRIP = ("plan", "--map", "hall.yaml", "--start", "2", "5", "--goal", "12", "5")


def test_zones_beside_the_map_count_unless_none_are_wanted(capsys: pytest.CaptureFixture) -> None:
    config = ["--config", "c.yaml"]
    Path("c.yaml").write_text("exemption_radius: 0.0\n")
    assert run_json(capsys, *TRIP, *config)["social_cost"] > 0.0
    Path("hall.zones.yaml").write_text(ZONES)
    assert run_json(capsys, *TRIP, *config)["social_cost"] == 0.0
    assert run_json(capsys, *TRIP, *config, "--zones", "none")["social_cost"] > 0.0
    os.rename("hall.zones.yaml", "other.yaml")
    assert run_json(capsys, *TRIP, *config, "--zones", "other.yaml")["social_cost"] == 0.0


def test_two_outputs_need_two_files(capsys: pytest.CaptureFixture) -> None:
    for other in ("o.json", "./o.json"):
        message = refused(capsys, *TRIP, "--out", "o.json", "--plot", other)
        assert message.startswith("error: o.json: is named for two outputs")
    assert not Path("o.json").exists()


def test_what_plan_precomputes_is_there_for_the_next_one(capsys: pytest.CaptureFixture, tmp_path: Path,
                                                         monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOCIAL_FLEET_CACHE", str(tmp_path / "cache"))
    first = run_json(capsys, *TRIP)
    (path,) = (tmp_path / "cache").glob("costs-*")
    written = path.stat().st_ino
    assert run_json(capsys, *TRIP)["points"] == first["points"]
    assert [path.stat().st_ino for path in (tmp_path / "cache").iterdir()] == [written]


def test_a_zone_or_norm_that_is_wrong_is_named_with_its_file(capsys: pytest.CaptureFixture) -> None:
    Path("hall.zones.yaml").write_text(ZONES.replace("[14, 10], [0, 10]", "[0, 10], [14, 10]"))
    assert refused(capsys, *TRIP).startswith("error: hall.zones.yaml: zones[0].polygon: ")
    Path("c.yaml").write_text("norm: own_norms.Missing\n")
    assert refused(capsys, *TRIP, "--config", "c.yaml", "--zones", "none").startswith("error: c.yaml: norm: ")


def test_a_gap_that_is_rounding_is_none() -> None:
    assert any("gap 0 %" in line for line in summary(FleetSchedule((), gap=2.2e-16)))
    assert any("gap 0.05 %" in line for line in summary(FleetSchedule((), gap=5e-4)))
