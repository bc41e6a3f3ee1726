"""Random faulty runs through the nodes, one roslaunch each, on a ROS master of their own; summed up like a campaign."""

import argparse
import json
import os
import subprocess
import sys
import time
from typing import Any, Dict, List

import numpy as np

from social_fleet.cli.campaign import lines, robot_range
from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.files import write_json
from social_fleet.mapping.files import load_map
from social_fleet.scenario.campaign import Campaign, summarised
from social_fleet.scenario.files import save_scenario
from social_fleet.scenario.recording import Recording
from social_fleet.scenario.scenario import Scenario

LIMIT = 600.0  # for one run [s, wall time]


def main() -> int:
    """Exit code 0 when every run passed."""
    parser = argparse.ArgumentParser(prog="tools/campaign_nodes", description=__doc__)
    parser.add_argument("--runs", type=int, default=30)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--robots", type=robot_range, default=(4, 4))
    parser.add_argument("--factor", type=float, default=3.0, help="simulated over wall time")
    parser.add_argument("--out", default="campaign_nodes")
    args = parser.parse_args()
    campaign, entries = Campaign(args.out, seed=args.seed, robots=args.robots), []
    for seed in range(args.seed, args.seed + args.runs):
        folder = os.path.abspath(os.path.join(args.out, f"run_{seed}"))
        entry_file = os.path.join(folder, "entry.json")
        if not os.path.exists(entry_file):
            scenario, fleet = campaign.draw(seed)
            os.makedirs(folder, exist_ok=True)
            write_json(entry_file, _run(seed, scenario, fleet, folder, args.factor))
        with open(entry_file, encoding="utf-8") as stream:
            entries.append(json.load(stream))
        entry = entries[-1]
        print(_line(entry), flush=True)
    summary = summarised(entries, args.seed, args.robots)
    write_json(os.path.join(args.out, "summary.json"), summary)
    print("\n".join(lines(summary, args.out)))
    return 0 if summary["passed"] == summary["runs"] else 1


def _line(entry: Dict[str, Any]) -> str:
    clearance = "" if entry["min_clearance"] is None else f", smallest clearance {entry['min_clearance']:.3f} m"
    counts = ", ".join(f"{entry[name]} {name}" for name in ("arrived", "excused", "contacts"))
    return (f"seed {entry['seed']}: {'passed' if entry['passed'] else 'FAILED'}, {entry['map']}, "
            f"{', '.join(entry['faults']) or 'no fault'}: {counts}{clearance}; load {os.getloadavg()[0]:.1f}"
            + "".join(f"\n  {failure}" for failure in entry["failures"]))


def _run(seed: int, scenario: Scenario, fleet: FleetSchedule, folder: str, factor: float) -> Dict[str, Any]:
    """One run, as a campaign has it in a line."""
    name = os.path.splitext(os.path.basename(scenario.map_path))[0]
    file = os.path.join(folder, "scenario.yaml")
    save_scenario(scenario, file)
    begun = time.monotonic()
    result = _launch(file, folder, factor)
    verdict = result or {"passed": False, "failures": ["the run broke off, see log"], "contacts": [], "arrived": [],
                         "excused": [], "stranded": [], "exceeded": [], "arrivals": {}, "min_clearance": None,
                         "duration": 0.0}
    if not verdict["passed"] and result:
        _draw(scenario, fleet, folder, f"seed {seed}: {verdict['failures'][0]}"[:110])
    delays = [when - fleet[robot].arrival_time for robot, when in verdict["arrivals"].items()]
    counts = {key: len(verdict[key]) for key in ("contacts", "arrived", "excused", "stranded", "exceeded")}
    return {"robots": len(scenario.robots), "passed": verdict["passed"], "failures": verdict["failures"], **counts,
            "min_clearance": verdict["min_clearance"], "mean_delay": float(np.mean(delays)) if delays else None,
            "exchanges": _exchanges(folder), "simulated_time": verdict["duration"],
            "wall_time": time.monotonic() - begun, "faults": sorted({fault.kind for fault in scenario.faults}),
            "seed": seed, "map": name}


def _launch(scenario: str, folder: str, factor: float) -> Dict[str, Any]:
    """What the run says of itself; empty when it broke off."""
    port = os.environ["ROS_MASTER_URI"].rsplit(":", 1)[1]
    command = ["roslaunch", "-p", port, "social_fleet", "faulty_fleet.launch", f"scenario:={scenario}",
               f"out:={folder}", f"real_time_factor:={factor:g}"]
    with open(os.path.join(folder, "log"), "w", encoding="utf-8") as log:
        process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT)
        try:
            process.wait(LIMIT)
        except subprocess.TimeoutExpired:
            process.send_signal(2)
            process.wait(60.0)
    try:
        with open(os.path.join(folder, "run.json"), encoding="utf-8") as stream:
            result: Dict[str, Any] = json.load(stream)
    except FileNotFoundError:
        return {}
    return result


def _exchanges(folder: str) -> int:
    with open(os.path.join(folder, "log"), encoding="utf-8", errors="replace") as stream:
        decisions: List[str] = [line for line in stream if ": exchange " in line]
    return len(decisions)


def _draw(scenario: Scenario, fleet: FleetSchedule, folder: str, title: str) -> None:
    from social_fleet.scenario.pictures.map_picture import map_picture
    data = np.load(os.path.join(folder, "recording.npz"))
    recording = Recording(tuple(spec.name for spec in scenario.robots), data["times"], data["poses"])
    map_picture(load_map(scenario.map_path), fleet, os.path.join(folder, "failed.png"), recording=recording,
                title=title)


if __name__ == "__main__":
    sys.exit(main())
