"""The real AMCL on simulated lidars and noisy odometry: how far it is off, and whether fleets arrive without contact.

Runs where `rospack find amcl` finds it; a workspace that it was built in can be named in SOCIAL_FLEET_EXTRA_WORKSPACE.
"""

import os
import subprocess
import tempfile
from contextlib import contextmanager
from dataclasses import replace
from typing import Callable, Dict, Iterator, Tuple

import numpy as np

from social_fleet.mapping.files import load_map, save_map
from social_fleet.mapping.grid import FREE, UNKNOWN

from .navigation import Localisation, Trackers, apart, launched, tour
from .processes import running
from .worlds import ROOT, map_files

DRIVES = 5
LENGTHS = (55.0, 65.0)  # [m] of a drive
FACTOR = 2.0  # simulated over wall time
CONVERGED = 3.0  # [m] of driving after which AMCL has to know where the robot is
WANTED = 0.15  # [m]
NOISE = os.path.join(ROOT, "tools", "benchmarks", "simulation_noise.yaml")
FLEET = ("gold", "blue", "green")
RADIUS = 0.25  # [m]


def run(say: Callable[[str], None]) -> bool:
    """Whether AMCL keeps within the bound and no robots touch; True where it is not there."""
    if subprocess.run(("rospack", "find", "amcl"), capture_output=True).returncode:
        say("skipped: rospack does not find amcl")
        return True
    name = "willow" if "willow" in map_files() else "office_floor"
    lengths = LENGTHS if name == "willow" else (30.0, 60.0)
    return all([apart(lambda: _drives(name, lengths, say)), apart(lambda: _fleet(name, say))])


def _drives(name: str, lengths: Tuple[float, float], say: Callable[[str], None]) -> bool:
    """One robot, drive after drive."""
    stops = tour(name, DRIVES, *lengths)
    with launched("robot.launch", robot="gold", map=map_files()[name], localization="amcl", navigation="tracker",
                  simulated=True, x=stops[0][0], y=stops[0][1], real_time_factor=FACTOR, simulation_overrides=NOISE,
                  true_map="/true_map"), _walls_alone(name):
        trackers, localisation = Trackers(("gold",)), Localisation(("gold",))
        arrived = 0
        for goal in stops[1:]:
            state = trackers.send({"gold": goal})
            arrived += state == "arrived"
            errors = localisation.errors("gold", CONVERGED)
            say(f"drive to {goal}: {state}; error so far at most {errors.max():.3f} m, after "
                f"{localisation.largest_after:.0f} m; 95 %: {np.percentile(errors, 95):.3f} m")
        errors, driven = localisation.errors("gold", CONVERGED), localisation.driven("gold")
    say(f"{name}: {arrived} of {DRIVES} drives arrived, {driven:.0f} m; AMCL's position error after {CONVERGED:g} m: "
        f"mean {errors.mean():.3f} m, 95 % {np.percentile(errors, 95):.3f} m, largest {errors.max():.3f} m, "
        f"wanted <= {WANTED}")
    return arrived == DRIVES and bool(errors.max() <= WANTED)


@contextmanager
def _walls_alone(name: str) -> Iterator[None]:
    """The map that lidars see: that which is wall on the map, since AMCL knows no edge of unknown space."""
    grid = load_map(map_files()[name])
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "walls.yaml")
        save_map(replace(grid, values=np.where(grid.values == UNKNOWN, FREE, grid.values)), file)
        with running("rosrun", "social_fleet", "map_publisher", file, "map:=/true_map", "__name:=true_map"):
            yield


def _fleet(name: str, say: Callable[[str], None]) -> bool:
    """Two robots that change places and one that drives there, too, on one schedule."""
    stops = tour(name, len(FLEET), 15.0, 40.0)
    goals = dict(zip(FLEET, (stops[1], stops[0], stops[3])))
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "fleet.yaml")
        with open(file, "w", encoding="utf-8") as stream:
            stream.write(_fleet_file(name, dict(zip(FLEET, stops))))
        with launched("fleet.launch", fleet=file, simulated=True, real_time_factor=1.0, simulation_overrides=NOISE,
                      true_map="/true_map"), _walls_alone(name):
            trackers, localisation = Trackers(FLEET), Localisation(FLEET)
            state = trackers.send(goals)
            gap = localisation.smallest_gap() - 2.0 * RADIUS
            errors = max(localisation.errors(robot, CONVERGED).max() for robot in FLEET)
    say(f"{name}: a fleet of {len(FLEET)} with AMCL each: {state}, smallest clearance {gap:.2f} m, "
        f"largest position error {errors:.3f} m")
    return state == "arrived" and gap > 0.0


def _fleet_file(name: str, starts: Dict[str, Tuple[float, float]]) -> str:
    lines = [f"map: {map_files()[name]}", "defaults: {navigation: tracker}", "robots:"]
    lines += [f"  {robot}: {{start: [{x}, {y}, 0.0]}}" for robot, (x, y) in starts.items()]
    return "\n".join(lines) + "\n"
