"""Many random runs with faults: each can be had again from its seed, and those that fail are written down."""

import json
import logging
import os
import random
from typing import Any, Callable, Dict, List, Optional, Tuple

import numpy as np

from social_fleet.errors import Infeasible, InvalidInput, NoPath, TimedOut
from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.files import write_json
from social_fleet.mapping.files import load_map
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario.faulty import FaultyRun, drive_scenario
from social_fleet.scenario.files import save_scenario
from social_fleet.scenario.fleet import FleetPlanner, coordinate_scenario
from social_fleet.scenario.locations import PACKAGE, resolve
from social_fleet.scenario.random_faults import WALL_MARGIN, random_faulty_scenario
from social_fleet.scenario.scenario import Scenario

log = logging.getLogger(__name__)

MAPS = {"alcove": (2, 1), "doorway": (4, 2), "corridor": (6, 2), "crossing": (6, 3), "office_floor": (16, 4),
        "environment_1": (16, 1)}
"""Maps that runs are drawn on: the most robots that fit, and how often each is drawn."""

_TRIES = 20  # draws of a fleet until one has a schedule
_DRAW = 1_000_003  # between the seeds of two draws


class Campaign:
    """Runs drawn from a seed, written to a folder; what is there already is not run again.

    Parameters
    ----------
    folder : str
        ``runs.jsonl``, ``summary.json``, and ``failed_SEED.yaml`` with a picture for every run that fails.
    seed : int
        Run number k is drawn from ``seed + k``.
    robots : (int, int)
        Fewest and most robots.
    """

    def __init__(self, folder: str, *, seed: int, robots: Tuple[int, int] = (2, 16)) -> None:
        self.folder = folder
        self.seed = seed
        self.robots = robots
        self._grids: Dict[str, OccupancyGrid] = {}
        self._planners: Dict[str, FleetPlanner] = {}
        os.makedirs(folder, exist_ok=True)

    def run(self, count: int, progress: Optional[Callable[[int], None]] = None) -> Dict[str, Any]:
        """`count` runs; the summary of all, which is written, too."""
        done = {entry["seed"]: entry for entry in self._written()
                if entry["robots_range"] == list(self.robots) and self.seed <= entry["seed"] < self.seed + count}
        with open(self._path("runs.jsonl"), "a", encoding="utf-8") as stream:
            for seed in range(self.seed, self.seed + count):
                if seed not in done:
                    done[seed] = self._entry(seed)
                    stream.write(json.dumps(done[seed]) + "\n")
                    stream.flush()
                if progress is not None:
                    progress(len(done))
        summary = summarised([done[seed] for seed in sorted(done)], self.seed, self.robots)
        write_json(self._path("summary.json"), summary)
        return summary

    def draw(self, seed: int) -> Tuple[Scenario, FleetSchedule]:
        """The scenario of a seed, and what its robots set out with.

        Raises
        ------
        InvalidInput
            When no fleet of the range has a schedule on any map.
        """
        chance = random.Random(seed)
        for attempt in range(_TRIES):
            robots = chance.randint(*self.robots)
            names = [name for name, (most, _) in MAPS.items() if most >= robots]
            if not names:
                raise InvalidInput(f"no map of the package holds {robots} robots; the most are "
                                   f"{max(most for most, _ in MAPS.values())}", field="robots")
            name = chance.choices(names, [MAPS[name][1] for name in names])[0]
            try:
                scenario = random_faulty_scenario(self._grid(name), robots, seed=seed + attempt * _DRAW,
                                                  map_name=f"{PACKAGE}maps/{name}.yaml", map_path=_map_path(name))
                return scenario, coordinate_scenario(scenario, self._grid(name), planners=self._planners[name])
            except (InvalidInput, NoPath, Infeasible, TimedOut) as error:
                log.info("seed %d, draw %d: %s", seed, attempt, error)
        raise InvalidInput(f"no fleet that was drawn from seed {seed} has a schedule", field="seed")

    def _entry(self, seed: int) -> Dict[str, Any]:
        scenario, fleet = self.draw(seed)
        name = os.path.splitext(os.path.basename(scenario.map_path))[0]
        run = drive_scenario(scenario, fleet, self._grid(name), planners=self._planners[name])
        if not run.verdict.passed:
            self._write_down(seed, scenario, fleet, run, self._grid(name))
        return {**entry_of(scenario, fleet, run), "seed": seed, "map": name, "robots_range": list(self.robots)}

    def _write_down(self, seed: int, scenario: Scenario, fleet: FleetSchedule, run: FaultyRun,
                    grid: OccupancyGrid) -> None:
        from social_fleet.scenario.pictures.map_picture import map_picture
        save_scenario(scenario, self._path(f"failed_{seed}.yaml"))
        with open(self._path(f"failed_{seed}.txt"), "w", encoding="utf-8") as stream:
            stream.write("\n".join([*run.verdict.failures, "", *run.decisions]) + "\n")
        map_picture(grid, fleet, self._path(f"failed_{seed}.png"), recording=run.recording,
                    title=f"seed {seed}: {run.verdict.failures[0]}"[:110])

    def _grid(self, name: str) -> OccupancyGrid:
        if name not in self._grids:
            self._grids[name] = load_map(_map_path(name))
            self._planners[name] = FleetPlanner(self._grids[name], {"wall_margin": WALL_MARGIN})
        return self._grids[name]

    def _path(self, name: str) -> str:
        return os.path.join(self.folder, name)

    def _written(self) -> List[Dict[str, Any]]:
        try:
            with open(self._path("runs.jsonl"), encoding="utf-8") as stream:
                return [json.loads(line) for line in stream if line.endswith("\n")]
        except FileNotFoundError:
            return []


def entry_of(scenario: Scenario, fleet: FleetSchedule, run: FaultyRun) -> Dict[str, Any]:
    """One run in a line."""
    verdict = run.verdict
    delays = [verdict.arrivals[name] - fleet[name].arrival_time for name in verdict.arrivals]
    return {"robots": len(scenario.robots), "passed": verdict.passed, "failures": list(verdict.failures),
            "contacts": len(verdict.contacts), "arrived": len(verdict.arrived), "excused": len(verdict.excused),
            "stranded": len(verdict.stranded), "exceeded": len(verdict.exceeded),
            "min_clearance": verdict.min_clearance, "mean_delay": float(np.mean(delays)) if delays else None,
            "exchanges": len(run.decisions), "simulated_time": round(verdict.duration, 2),
            "wall_time": round(run.wall_time, 3),
            "faults": sorted({fault.kind for fault in scenario.faults})}


def summarised(entries: List[Dict[str, Any]], seed: int, robots: Tuple[int, int]) -> Dict[str, Any]:
    """What summary.json holds."""
    total = {name: sum(entry[name] for entry in entries)
             for name in ("robots", "contacts", "arrived", "excused", "stranded", "exceeded", "exchanges")}
    clearances = [entry["min_clearance"] for entry in entries if entry["min_clearance"] is not None]
    simulated, wall = (sum(entry[name] for entry in entries) for name in ("simulated_time", "wall_time"))
    return {"seed": seed, "robots_range": list(robots), "runs": len(entries),
            "passed": sum(entry["passed"] for entry in entries), **total,
            "min_clearance": min(clearances, default=None), "simulated_time": simulated, "wall_time": wall,
            "failed": [{"seed": entry["seed"], "map": entry["map"], "failures": entry["failures"]}
                       for entry in entries if not entry["passed"]]}


def _map_path(name: str) -> str:
    return resolve(f"{PACKAGE}maps/{name}.yaml", ".")
