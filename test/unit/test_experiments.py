"""Experiments on tiny maps: what they count, what they write, and what they refuse."""

import csv
import json
import math
import os
from pathlib import Path
from typing import Any, Dict, List

import numpy as np
import pytest
from PIL import Image
from worlds import grid_from_text

from social_fleet.cli.main import main
from social_fleet.errors import InvalidInput, InvalidParameter
from social_fleet.experiments import EXPERIMENTS, experiment_named, fig8, fig10, fig11, fig12, fig15, routes, table3
from social_fleet.experiments.fig7 import busiest_place, member_counts
from social_fleet.experiments.frame import Result, World, csv_text, write_result
from social_fleet.experiments.metrics import heading_change_per_metre, right_distance
from social_fleet.experiments.table2 import measure, rows_of
from social_fleet.experiments.trials import METHODS, Attempt, attempt, mean_and_std, solve, three_methods
from social_fleet.mapping.files import save_map
from social_fleet.planning.overlays.overlay_set import OverlaySet
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.routes.fleet_routes import FleetRoutes
from social_fleet.scenario.pictures.style import new_figure

# A ring of corridors 3 m wide about a block of 10 m by 4 m, in cells of half a metre.
RING = grid_from_text("\n".join(["#" * 34, *["#" + "." * 32 + "#"] * 6, *["#" + "." * 6 + "#" * 20 + "." * 6 + "#"] * 8,
                                 *["#" + "." * 32 + "#"] * 6, "#" * 34]), 0.5)
WORLD = World("ring", RING)


@pytest.fixture(name="few", autouse=True)
def make_few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few paths to learn from, so that a run takes no time."""
    monkeypatch.setattr(fig8, "PATHS", (0, 10))
    monkeypatch.setattr(fig8, "REPEATS", 1)
    monkeypatch.setattr(routes, "LEARNT", 10)
    monkeypatch.setattr(fig10, "SIZES", (2, 3))
    monkeypatch.setattr(fig11, "SIZES", (2, 3))
    monkeypatch.setattr(fig11, "SHOWN", 3)
    monkeypatch.setattr(fig15, "DRAWS", 3)
    monkeypatch.setattr(table3, "SIZES", (2, 3))
    monkeypatch.setattr(fig12, "SIZES", (2, 4, 5))
    monkeypatch.setattr("social_fleet.planning.planner.RRT_SAMPLES", 300)


@pytest.mark.parametrize("name", list(EXPERIMENTS))
def test_each_writes_a_document_a_table_and_a_picture(name: str, tmp_path: Path) -> None:
    shares: List[float] = []
    result = experiment_named(name).run([WORLD], trials=4, seed=1,
                                        progress=lambda done, total: shares.append(done / total))
    assert shares == sorted(shares) and shares[-1] == 1.0
    paths = write_result(result, tmp_path / "new")
    assert paths == [str(tmp_path / "new" / (name + ending)) for ending in (".json", ".csv", ".png")]
    document = json.loads(Path(paths[0]).read_text())
    assert document["experiment"] == name and document["settings"]["seed"] == 1 and document["caption"]
    with open(paths[1], newline="") as stream:
        table = list(csv.DictReader(stream))
    assert table and len(table) == len(document["rows"]) and list(table[0]) == list(document["rows"][0])
    assert Image.open(paths[2]).format == "PNG"


@pytest.mark.parametrize("name", list(EXPERIMENTS))
def test_the_seed_decides_all_but_times(name: str) -> None:
    def timeless(seed: int) -> List[Dict[str, Any]]:
        rows = experiment_named(name).run([WORLD], trials=3, seed=seed).rows
        return [{key: value for key, value in row.items() if "time" not in key} for row in rows]

    assert timeless(2) == timeless(2)


def test_methods_are_judged_on_the_pairs_that_all_solved() -> None:
    methods = three_methods(RING)
    pairs = [((2.0, 2.0), (14.0, 2.0)), ((2.0, 9.0), (14.0, 9.0)), ((2.0, 2.0), (14.0, 2.5))]
    solved = [solve(methods, pair) for pair in pairs]
    assert [row["failed"] for row in rows_of("ring", [measure(RING, pairs[0], each) for each in solved])] == [0, 0, 0]
    solved[1]["rrt_star"] = Attempt(None, 0.1)
    rows = rows_of("ring", [measure(RING, pairs[0], each) for each in solved])
    assert [row["failed"] for row in rows] == [0, 1, 0] and {row["solved_by_all"] for row in rows} == {2}
    for row in rows:
        kept = [solved[0][row["method"]], solved[2][row["method"]]]
        plans = [found.plan for found in kept if found.plan is not None]
        assert row["length_mean"] == pytest.approx(np.mean([plan.length for plan in plans]))
        assert row["right_distance_mean"] == pytest.approx(np.mean([right_distance(RING, p.points) for p in plans]))
        assert row["heading_change_per_metre"] == pytest.approx(heading_change_per_metre([p.points for p in plans]))
        assert row["time_mean"] == pytest.approx(np.mean([found.time for found in kept]))


def test_without_any_path_there_are_no_means() -> None:
    nothing = measure(RING, ((2.0, 2.0), (14.0, 2.0)), {method: Attempt(None, 0.1) for method in METHODS})
    rows = rows_of("ring", [nothing])
    assert [row["failed"] for row in rows] == [1, 1, 1]
    assert all(row["length_mean"] is None and row["time_median"] is None for row in rows)
    assert mean_and_std([]) == (None, None) and mean_and_std([1.0, 3.0]) == (2.0, 1.0)


def test_what_finds_no_path_is_a_failure_not_an_error() -> None:
    rooms = grid_from_text("\n".join(["#" * 9, *["#...#...#"] * 5, "#" * 9]))
    plan, taken = attempt(SocialPlanner(rooms), ((2.5, 2.5), (6.5, 2.5)), "rrt_star")
    assert plan is None and taken > 0.0


def test_the_obstacle_of_figure_7_teaches_nothing() -> None:
    rows = experiment_named("fig7").run([WORLD], trials=20, seed=1).rows
    assert [row["paths"] for row in rows[:2]] == [12, 20] and [row["obstacle"] for row in rows] == [False, False, True]
    assert rows[2]["temporary_paths"] > 0 and rows[2]["temporary_edges"] > 0
    assert rows[2]["paths"] + rows[2]["temporary_paths"] + rows[2]["refused"] == 40


def test_the_busiest_place_is_on_most_paths() -> None:
    planner = SocialPlanner(RING)
    routes_ = FleetRoutes(planner, OverlaySet(RING))
    for goal in ((8.0, 1.6), (14.0, 1.6)):
        for _ in range(2):
            routes_.add(planner.plan((2.0, 1.6), goal))
    routes_.learn()
    x, y = busiest_place(planner, routes_)
    assert routes_.graph is not None and 2.0 < x < 8.0 and y < 3.5
    assert member_counts(routes_.graph).counts.max() == 4


def test_figure_8_is_relative_to_plain_a_star_of_the_same_run() -> None:
    rows = experiment_named("fig8").run([WORLD], trials=3, seed=1).rows
    assert [row["paths"] for row in rows] == [0, 10] and rows[0]["edges"] == 0 < rows[1]["edges"]
    for row in rows:
        assert row["time_ratio"] == pytest.approx(row["social_time"] / row["shortest_time"])


def test_a_table_leaves_empty_what_has_no_value() -> None:
    assert csv_text([{"a": 1, "b": None}, {"a": 2.5, "b": "x, y"}]) == 'a,b\n1,\n2.5,"x, y"\n'
    assert csv_text([]).strip() == ""


def test_values_that_are_not_finite_are_null(tmp_path: Path) -> None:
    result = Result("odd", "caption", [{"value": math.nan}], {}, new_figure(1.0, 1.0))
    write_result(result, tmp_path)
    assert json.loads((tmp_path / "odd.json").read_text())["rows"] == [{"value": None}]


@pytest.mark.parametrize("options, message", [
    ({"trials": 0, "seed": 1}, "trials: must be at least 1, not 0"),
    ({"trials": 1, "seed": -1}, "seed: must be at least 0, not -1"),
])
def test_wrong_numbers_are_refused(options: Dict[str, int], message: str) -> None:
    with pytest.raises(InvalidParameter, match=message):
        experiment_named("fig6").run([WORLD], **options)


def test_which_maps_it_runs_on(tmp_path: Path) -> None:
    save_map(RING, tmp_path / "ring.yaml")
    own = [tmp_path / "ring.yaml"]
    table2, fig6 = experiment_named("table2"), experiment_named("fig6")
    assert [world.name for world in table2.worlds()] == ["environment_1", "environment_2", "office_floor"]
    assert [world.name for world in table2.worlds(own)] == ["environment_1", "environment_2", "office_floor", "ring"]
    assert [world.name for world in table2.worlds(own, only=True)] == ["ring"]
    assert [world.name for world in fig6.worlds()] == ["environment_1"]
    assert [world.name for world in fig6.worlds(own)] == ["ring"]
    with pytest.raises(InvalidInput, match="--map: ring comes twice"):
        table2.worlds(own * 2)
    with pytest.raises(InvalidInput, match="fig6 draws one map, not 2"):
        fig6.worlds([*own, _renamed(tmp_path)])
    with pytest.raises(InvalidInput, match="--only: leaves no map"):
        table2.worlds(only=True)
    with pytest.raises(InvalidParameter, match="must be one of table2, .* not 'fig99'"):
        experiment_named("fig99")


def _renamed(folder: Path) -> Path:
    save_map(RING, folder / "other.yaml")
    return folder / "other.yaml"


@pytest.fixture(name="folder")
def make_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    save_map(RING, tmp_path / "ring.yaml")
    (tmp_path / "file").write_text("")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_on_the_command_line(folder: Path, capsys: pytest.CaptureFixture) -> None:
    own = ["--map", "ring.yaml", "--only"]
    assert main(["experiment", "table2", *own, "--trials", "2", "--out", "out", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown == json.loads(Path("out/table2.json").read_text())
    assert sorted(os.listdir("out")) == ["table2.cells", "table2.csv", "table2.json", "table2.png"]
    assert main(["experiment", "fig6", "--map", "ring.yaml", "--trials", "1", "--out", "out"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("map") and lines[-1] == f"wrote {os.path.join('out', 'fig6.png')}"


@pytest.mark.parametrize("arguments, message", [
    (["fig99", "--out", "out"], "error: command line: NAME: invalid choice: 'fig99'"),
    (["fig6"], "error: command line: the following arguments are required: --out"),
    (["fig6", "--trials", "0", "--out", "out"],
     "error: command line: --trials: must be a whole number from 1 on, not '0'"),
    (["fig6", "--seed", "-1", "--out", "out"], "error: command line: --seed: must be a whole number from 0 on"),
    (["fig6", "--map", "missing.yaml", "--out", "out"], "error: missing.yaml: there is no such file"),
    (["fig6", "--only", "--out", "out"], "error: --only: leaves no map to run on"),
    (["fig6", "--limit", "5", "--out", "out"], "error: --limit: fig6 has no limit for its solves"),
    (["fig10", "--limit", "0", "--out", "out"], "error: command line: --limit: must be a positive number, not '0'"),
    (["fig6", "--out", "file"], "error: file: is a file; name a folder"),
    (["fig6", "--out", "no/such/folder"], "error: "),
])
def test_a_wrong_command_line_leaves_nothing(folder: Path, capsys: pytest.CaptureFixture, arguments: List[str],
                                             message: str) -> None:
    before = sorted(os.listdir("."))
    assert main(["experiment", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith(message) and captured.err.count("\n") == 1 and captured.out == ""
    assert sorted(os.listdir(".")) == before


def test_interrupting_leaves_no_half_result(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("social_fleet.experiments.frame.save_figure", interrupted)
    assert main(["experiment", "fig6", "--map", "ring.yaml", "--trials", "1", "--out", "out"]) == 130
    assert os.listdir("out") == ["fig6.cells"]


def test_the_same_command_goes_on_after_an_interruption(folder: Path, monkeypatch: pytest.MonkeyPatch,
                                                        capsys: pytest.CaptureFixture) -> None:
    command = ["experiment", "table2", "--map", "ring.yaml", "--only", "--trials", "4", "--out", "out"]
    assert main([*command[:-1], "whole"]) == 0
    capsys.readouterr()
    planned: List[Any] = []

    def count(_: Any, pair: Any) -> Any:
        planned.append(pair)
        if len(planned) == 4:
            raise KeyboardInterrupt
        return solve(_, pair)

    monkeypatch.setattr("social_fleet.experiments.trials.solve", count)
    assert main(command) == 130
    captured = capsys.readouterr()
    kept = f"finished cells are kept in {os.path.join('out', 'table2.cells')}"
    assert captured.err == f"interrupted: {kept}; the same command goes on from there\n" and captured.out == ""
    assert main(command) == 0
    assert len(planned) - 4 == 1 + 2  # one to warm up, then the third, in which it was stopped, and the fourth
    rows = [json.loads((Path(out) / "table2.json").read_text())["rows"] for out in ("out", "whole")]
    for ours, whole in zip(*rows):
        assert {key: ours[key] for key in ours if "time" not in key} == {
            key: whole[key] for key in whole if "time" not in key}


def test_before_the_first_cell_nothing_is_kept(folder: Path, monkeypatch: pytest.MonkeyPatch,
                                               capsys: pytest.CaptureFixture) -> None:
    def interrupted(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("social_fleet.experiments.trials.solve", interrupted)
    assert main(["experiment", "fig6", "--map", "ring.yaml", "--trials", "1", "--out", "out"]) == 130
    assert capsys.readouterr().err == "interrupted: nothing was finished\n" and not os.path.exists("out")
