"""Searching in shares, as Table 3 and Figure 12 measure it: the same windows, and who is done when."""

from typing import Any, Dict, List

import pytest
from fleets import street_fleet
from worlds import grid_from_text

from social_fleet.coordination.encounters import EncounterFinder
from social_fleet.coordination.work_sharing import share_pairs
from social_fleet.experiments import experiment_named, fig12, sharing
from social_fleet.experiments.fig12 import growth_of
from social_fleet.experiments.frame import World
from social_fleet.experiments.sharing import Search, fleet_cells, measure, rows_of

HALL = grid_from_text("\n".join(["#" * 40, *["#" + "." * 38 + "#"] * 28, "#" * 40]), 0.5)


@pytest.mark.parametrize("robots", [2, 3, 6, 7])
def test_the_shares_find_what_one_robot_finds(robots: int) -> None:
    fleet = street_fleet(robots, 5)
    found = measure(fleet)
    assert found["windows"] == found["windows_of_shares"] == len(EncounterFinder(sharing.TOLERANCE).find(fleet))
    assert found["pairs"] == robots * (robots - 1) // 2 and found["largest_share"] == robots // 2


def test_the_fleet_waits_for_its_slowest_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    fleet = street_fleet(4, 5)
    costs = {pair: 1.0 + place for place, pair in enumerate(
        pair for share in share_pairs([body.name for body in fleet]).values() for pair in share)}
    monkeypatch.setattr(sharing, "search", lambda robots, pairs: Search(sum(costs[pair] for pair in pairs), 0))
    found = measure(fleet)
    # Loads 2, 2, 1, 1, as Figure 4 has it for even fleets.
    assert found["central_time"] == 21.0 and found["shared_time"] == 3.0 + 4.0 and found["robot_time"] == 21.0 / 4.0
    row, = rows_of(["hall"], [4], 1, [found])
    assert row["time_improvement_mean"] == pytest.approx(1.0 - 7.0 / 21.0)
    assert row["work_time_improvement_mean"] == pytest.approx(0.75)
    assert row["pairs_improvement"] == pytest.approx(1.0 - 2.0 / 6.0)


def test_values_find_their_rows() -> None:
    def value(size: int, time: float) -> Dict[str, Any]:
        return {"robots": size, "pairs": 1, "largest_share": 1, "windows": 0, "central_time": time,
                "shared_time": time, "robot_time": time}
    values = [value(2, 1.0), value(3, 10.0), value(2, 3.0), value(3, 30.0),
              value(2, 5.0), value(3, 50.0), value(2, 7.0), value(3, 70.0)]
    rows = rows_of(["one", "other"], [2, 3], 2, values)
    assert [(row["map"], row["robots"], row["central_time_mean"]) for row in rows] == [
        ("one", 2, 2.0), ("one", 3, 20.0), ("other", 2, 6.0), ("other", 3, 60.0)]


def test_fleets_differ_from_trial_to_trial_and_small_ones_are_part_of_large_ones() -> None:
    cells = fleet_cells([HALL], [3, 5], 3, 0)
    assert len({str(cell.key) for cell in cells}) == 6
    windows = [cell.compute()["windows"] for cell in cells]
    assert all(few <= many for few, many in zip(windows[::2], windows[1::2])) and len(set(windows[1::2])) > 1
    assert [cell.compute()["windows"] for cell in fleet_cells([HALL], [3, 5], 3, 0)] == windows


def test_growth_is_a_power_of_the_size() -> None:
    rows: List[Dict[str, Any]] = [{"robots": size, "time": 0.5 * size ** 2} for size in (2, 4, 8, 16)]
    rows[0]["time"] = 100.0
    assert growth_of(rows, "time") == pytest.approx(2.0) and growth_of(rows[:2], "time") is None


def test_two_maps_are_two_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fig12, "SIZES", (4, 5))
    result = experiment_named("fig12").run([World("one", HALL), World("other", HALL)], trials=1, seed=0)
    labels = [text.get_text() for text in result.figure.axes[0].get_legend().get_texts()]
    assert labels == ["one, one robot", "one, shared", "other, one robot", "other, shared"]
    assert list(result.details["growth"]) == ["one", "other"]
