"""The judge of runs with faults: contacts, arrivals, waits without end and limits, from what was recorded alone."""

import math
from dataclasses import asdict, dataclass
from itertools import combinations
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
from scipy import ndimage

from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario import judge as judging
from social_fleet.scenario.judge import Contact
from social_fleet.scenario.recording import Recording
from social_fleet.scenario.scenario import RobotSpec, Scenario
from social_fleet.simulation.faults import CircleObstacle

_ROOM = 0.35  # what robots keep from others that stand for good, beyond both discs: less may be no way [m]
_SPARE = 0.05  # and beyond the wall margin [m]
_WALL_MARGIN = 0.03  # of planners, where the scenario says nothing [m]
_ROUNDING = 1e-6
_DEFAULTS = {"max_acceleration": 1.0, "max_turn_rate": 1.5, "max_turn_acceleration": 3.0}


@dataclass(frozen=True)
class Verdict:
    """What became of a run.

    Attributes
    ----------
    passed : bool
        No failure.
    failures : tuple of str
        As sentences.
    contacts : tuple of Contact
        Of robots with each other, with walls, and of moving robots with obstacles.
    arrived, excused, stranded : tuple of str
        Robots at their last goals; those that are dead or have no way there; and all others.
    arrivals : dict of str to float
        When [s].
    exceeded : tuple of str
        Limits that commands or motion went beyond, as sentences.
    min_clearance : float, optional
        Of two robots' surfaces [m].
    duration : float
        Of the run [s].
    """

    passed: bool
    failures: Tuple[str, ...]
    contacts: Tuple[Contact, ...]
    arrived: Tuple[str, ...]
    excused: Tuple[str, ...]
    stranded: Tuple[str, ...]
    arrivals: Dict[str, float]
    exceeded: Tuple[str, ...]
    min_clearance: Optional[float]
    duration: float

    def to_dict(self) -> Dict[str, Any]:
        """As plain values."""
        return {**asdict(self), "contacts": [contact._asdict() for contact in self.contacts]}


def judge_faulty_run(scenario: Scenario, recording: Recording, commands: np.ndarray, grid: OccupancyGrid,
                     gave_up: Mapping[str, str]) -> Verdict:
    """Judge a run.

    Parameters
    ----------
    scenario : Scenario
        What was to be done, and what went wrong.
    recording : Recording
        True poses.
    commands : (T, R, 2) array
        Speed and turn rate commanded in each period [m/s], [rad/s]; NaN where nobody commanded.
    grid : OccupancyGrid
        The map.
    gave_up : mapping of str to str
        Robots that gave their errands up, and why.
    """
    specs = {spec.name: spec for spec in scenario.robots}
    found, clearance = _contacts(recording, specs, grid, scenario.obstacles)
    goals = {spec.name: spec.goal for spec in scenario.robots}
    for fault in sorted(scenario.faults, key=lambda fault: fault.at):
        if fault.kind == "errand":
            goals[fault.robot] = fault.goal
    arrivals = {name: when for name in specs for when in [_arrival(recording, name, goals[name])] if when is not None}
    dead = {fault.robot for fault in scenario.faults if fault.kind == "dead"}
    open_ = [name for name in specs if name not in arrivals and name not in dead]
    cut_off = [name for name in open_ if not _has_way(recording, scenario, name, goals[name], grid)]
    stranded = tuple(name for name in open_ if name not in cut_off or name not in gave_up)
    exceeded = tuple(_exceeded(recording, commands, specs))
    failures = [_sentence(contact) for contact in found] + list(exceeded)
    for name in stranded:
        failures.append(f"robot {name} gave up though there is a way: {gave_up[name]}" if name in gave_up else
                        f"robot {name} waits without end")
    return Verdict(not failures, tuple(failures), tuple(found), tuple(arrivals),
                   tuple(name for name in specs if name not in arrivals and name not in stranded), stranded, arrivals,
                   exceeded, clearance, recording.duration)


def _contacts(recording: Recording, specs: Mapping[str, RobotSpec], grid: OccupancyGrid,
              obstacles: Sequence[CircleObstacle]) -> Tuple[List[Contact], Optional[float]]:
    found: List[Contact] = []
    smallest: Optional[float] = None
    for one, other in combinations(specs.values(), 2):
        gaps = judging.pair_clearance(recording, recording.index(one.name), recording.index(other.name),
                                      one.radius + other.radius)
        smallest = float(gaps.min()) if smallest is None else min(smallest, float(gaps.min()))
        found += judging.contacts(recording, gaps, "robots", (one.name, other.name))
    for spec in specs.values():
        index = recording.index(spec.name)
        gaps = judging.wall_clearance(recording, index, spec.radius, grid)
        found += judging.contacts(recording, gaps, "wall", (spec.name,))
        for obstacle in obstacles:
            gaps = _driven_into(recording, index, spec.radius, obstacle)
            found += judging.contacts(recording, gaps, "obstacle", (spec.name,))
    return sorted(found, key=lambda contact: (contact.time, contact.robots)), smallest


def _driven_into(recording: Recording, index: int, radius: float, obstacle: CircleObstacle) -> np.ndarray:
    """Clearance to an obstacle [m]; infinite while the robot cannot help it: the obstacle came where it could not stop.
    """
    gaps = judging.obstacle_clearance(recording, index, radius, obstacle)
    began = int(np.searchsorted(recording.times, obstacle.appears))
    if began < len(gaps) and obstacle.appears > 0.0:
        x, y = recording.poses[began, index, :2]
        step = recording.poses[min(began + 1, len(recording.times) - 1), index, :2] - (x, y)
        speed = float(np.hypot(*step)) / float(np.diff(recording.times[:2])[0])
        room = speed * 0.3 + speed * speed / (2.0 * _DEFAULTS["max_acceleration"])
        if math.hypot(x - obstacle.x, y - obstacle.y) - radius - obstacle.radius < room + 0.05:
            gaps = np.full_like(gaps, np.inf)
    return gaps


def _arrival(recording: Recording, name: str, goal: Sequence[float]) -> Optional[float]:
    poses = recording.poses[:, recording.index(name)]
    there = np.hypot(poses[:, 0] - goal[0], poses[:, 1] - goal[1]) <= 0.12
    if len(goal) > 2:
        turn = (poses[:, 2] - goal[2] + math.pi) % (2.0 * math.pi) - math.pi
        there &= np.abs(turn) <= 0.15
    if not there[-1]:
        return None
    absent = np.flatnonzero(~there)
    return float(recording.times[absent[-1] + 1 if len(absent) else 0])


def _has_way(recording: Recording, scenario: Scenario, name: str, goal: Sequence[float], grid: OccupancyGrid) -> bool:
    """Whether a robot could still drive from where it ended to its goal, with all others standing where they ended.

    It keeps the scenario's wall margin from everything, `_SPARE` more from walls, and `_ROOM` more from what stands.
    """
    specs = {spec.name: spec for spec in scenario.robots}
    margin = float(scenario.planner.get("wall_margin", _WALL_MARGIN))
    radius = specs[name].radius + margin
    discs = [(*recording.poses[-1, recording.index(other), :2], spec.radius) for other, spec in specs.items()
             if other != name]
    discs += [(obstacle.x, obstacle.y, obstacle.radius) for obstacle in scenario.obstacles
              if obstacle.present(float(recording.times[-1]))]
    rows, columns = np.indices(grid.shape)
    centres = grid.centres(np.stack((rows.ravel(), columns.ravel()), axis=1))
    clear = ndimage.distance_transform_edt(np.pad(~grid.blocked, 1, mode="constant"))[1:-1, 1:-1] * grid.resolution
    free = (clear - 0.5 * grid.resolution > radius + _SPARE).ravel()
    for x, y, size in discs:
        free &= np.hypot(centres[:, 0] - x, centres[:, 1] - y) > radius + size + _ROOM
    places = (tuple(recording.poses[-1, recording.index(name), :2]), tuple(goal[:2]))
    labels, _ = ndimage.label(free.reshape(grid.shape))
    near = []
    for place in places:
        gaps = np.hypot(centres[:, 0] - place[0], centres[:, 1] - place[1])
        within = 0.3 if place is places[0] else 0.75 * grid.resolution
        near.append(set(labels.ravel()[gaps <= within].tolist()) - {0})
    return bool(near[0] & near[1])


def _exceeded(recording: Recording, commands: np.ndarray, specs: Mapping[str, RobotSpec]) -> List[str]:
    """Limits that commands, or true motion, went beyond."""
    found: List[str] = []
    period = float(np.diff(recording.times[:2])[0]) if len(recording.times) > 1 else 1.0
    for name, spec in specs.items():
        index = recording.index(name)
        limits = {key: getattr(spec, key) or default for key, default in _DEFAULTS.items()}
        most = (spec.max_speed, limits["max_turn_rate"])
        changes = (limits["max_acceleration"] * period, limits["max_turn_acceleration"] * period)
        steps = np.diff(recording.poses[:, index], axis=0)
        turns = (steps[:, 2] + math.pi) % (2.0 * math.pi) - math.pi
        half = 0.5 * turns
        arcs = np.hypot(steps[:, 0], steps[:, 1]) * np.where(np.abs(half) > 1e-9, half / np.where(
            np.abs(half) > 1e-9, np.sin(half), 1.0), 1.0)
        motion = np.stack((arcs, turns), axis=1) / period
        for source, values in (("commands", commands[:, index]), ("motion", motion)):
            for axis, what in ((0, "speed"), (1, "turn rate")):
                column = values[:, axis]
                if _most(np.abs(column)) > most[axis] + _ROUNDING:
                    found.append(f"robot {name}: {source} exceed the {what}")
                if _most(np.abs(np.diff(column))) > changes[axis] + 1e-5:
                    found.append(f"robot {name}: {source} exceed the acceleration of {what}")
        if _most(-commands[:, index, 0]) > 0.0:
            found.append(f"robot {name} is commanded backwards")
    return found


def _most(values: np.ndarray) -> float:
    """The greatest of the values that are known, 0 at least."""
    return float(values[~np.isnan(values)].max(initial=0.0))


def _sentence(contact: Contact) -> str:
    whom = {"robots": " and ".join(contact.robots), "wall": f"{contact.robots[0]} and a wall",
            "obstacle": f"{contact.robots[0]} and an obstacle"}[contact.kind]
    x, y = contact.position
    return f"{whom} touch at {contact.time:.2f} s near ({x:.2f}, {y:.2f}), {-contact.clearance:.3f} m deep"
