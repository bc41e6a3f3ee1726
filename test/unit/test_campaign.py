"""Campaigns: each run from its seed alone, resumed where they ended, and written down when it fails."""

import json
from pathlib import Path

import pytest

from social_fleet.cli.campaign import robot_range
from social_fleet.cli.main import main
from social_fleet.errors import InvalidInput
from social_fleet.scenario import campaign as campaigns
from social_fleet.scenario.campaign import Campaign
from social_fleet.scenario.files import load_scenario


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(campaigns, "MAPS", {"crossing": (4, 1)})


def test_a_campaign_is_written_and_resumed(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    arguments = ["campaign", "--seed", "3", "--robots", "2..3", "--out", str(tmp_path), "--json"]
    assert main([*arguments, "--runs", "2"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary == json.loads((tmp_path / "summary.json").read_text())
    assert summary["runs"] == summary["passed"] == 2 and summary["contacts"] == 0 and summary["failed"] == []
    lines = (tmp_path / "runs.jsonl").read_text().splitlines()
    assert main([*arguments, "--runs", "3"]) == 0
    again = (tmp_path / "runs.jsonl").read_text().splitlines()
    assert again[:2] == lines and len(again) == 3 and json.loads(again[2])["seed"] == 5


def test_a_run_depends_on_its_seed_alone(tmp_path: Path) -> None:
    one, other = Campaign(str(tmp_path), seed=0, robots=(2, 4)), Campaign(str(tmp_path), seed=7, robots=(2, 4))
    assert one.draw(7)[0] == other.draw(7)[0] and one.draw(7)[0] != one.draw(8)[0]


def test_a_failing_run_is_written_down(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is written can be driven again."""
    from dataclasses import replace
    judge = campaigns.drive_scenario

    def failing(*arguments, **options):  # type: ignore[no-untyped-def]
        run = judge(*arguments, **options)
        return replace(run, verdict=replace(run.verdict, passed=False, failures=("made to fail",)))

    monkeypatch.setattr(campaigns, "drive_scenario", failing)
    campaign = Campaign(str(tmp_path), seed=3, robots=(2, 2))
    summary = campaign.run(1)
    assert summary["failed"] == [{"seed": 3, "map": "crossing", "failures": ["made to fail"]}]
    assert {"failed_3.yaml", "failed_3.png", "failed_3.txt"} <= {path.name for path in tmp_path.iterdir()}
    written, drawn = load_scenario(tmp_path / "failed_3.yaml"), campaign.draw(3)[0]
    assert written.faults == drawn.faults and written.robots == drawn.robots and written.network == drawn.network
    assert dict(written.simulation) == dict(drawn.simulation)


def test_too_many_robots_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="no map of the package holds 9 robots"):
        Campaign(str(tmp_path), seed=0, robots=(9, 9)).run(1)


@pytest.mark.parametrize("text, wanted", [("2..16", (2, 16)), ("5", (5, 5))])
def test_ranges(text: str, wanted: tuple) -> None:
    assert robot_range(text) == wanted


@pytest.mark.parametrize("text", ["5..2", "0..3", "two", "1..2..3"])
def test_what_is_no_range_is_refused(text: str, capsys: pytest.CaptureFixture) -> None:
    assert main(["campaign", "--runs", "1", "--seed", "0", "--out", "nowhere", "--robots", text]) == 2
    assert "must be A..B" in capsys.readouterr().err
