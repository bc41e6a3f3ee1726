"""What a schedule's diagram is made of: where robots are held up, and when they occupy their encounters."""

from typing import Dict, List, NamedTuple, Optional, Tuple

import numpy as np

from social_fleet.coordination.schedule import FleetSchedule, Precedence, Schedule
from social_fleet.coordination.timing import nominal_timing
from social_fleet.scenario.recording import Recording

Progress = Tuple[np.ndarray, np.ndarray]  # times [s] and arc lengths [m]

SAME_PLACE = 1e-6  # [m]
AT_THE_EDGE = 0.02  # [m]
SHORTEST_DELAY = 1.0  # [s]
JOINED_WITHIN = 2.0  # [s] between two losses that are one delay
REASON_REACH = 5.0  # [m] between where a robot is held up and the place that it may not pass yet
REASON_SLACK = 3.0  # [s] between the other robot's having passed and this one's passing


class Delay(NamedTuple):
    """A stretch on which a robot loses `seconds` against driving alone, standing or slowed, for `reason` when known.

    `times` [s] and `arc_lengths` [m] are its motion there.
    """

    seconds: float
    times: np.ndarray
    arc_lengths: np.ndarray
    reason: Optional[Precedence]

    @property
    def standing(self) -> bool:
        """Whether it stands rather than drives slowly."""
        return float(self.arc_lengths[-1] - self.arc_lengths[0]) < 0.1

    @property
    def end(self) -> Tuple[float, float]:
        """Time [s] and arc length [m] from which on it drives freely."""
        return float(self.times[-1]), float(self.arc_lengths[-1])


class Occupancy(NamedTuple):
    """`robot` is between `enter` and `leave` [m] of its path from `begin` to `end` [s]."""

    robot: str
    begin: float
    end: float
    enter: float
    leave: float


def when(schedule: Schedule, arc_length: float, *, last: bool = False) -> float:
    """The first (or last) time [s] at which the robot is at `arc_length` [m]; its arrival for places beyond."""
    arcs, times = schedule.arc_lengths, schedule.times
    index = int(np.searchsorted(arcs, arc_length, "right") if last else np.searchsorted(arcs, arc_length, "left"))
    if index == 0:
        return float(times[0])
    if index >= len(arcs):
        return float(times[-1])
    rise = arcs[index] - arcs[index - 1]
    share = (arc_length - arcs[index - 1]) / rise if rise > 0.0 else 1.0
    return float(times[index - 1] + share * (times[index] - times[index - 1]))


def delays(fleet: FleetSchedule, schedule: Schedule) -> List[Delay]:
    """Where the robot stands for longer than turning takes, or drives slower than it could, and because of whom."""
    times, arcs, losses = _losses(schedule)
    lossy = np.flatnonzero(losses > np.maximum(0.05 * np.diff(times), 0.05))
    runs = np.split(lossy, np.flatnonzero(times[lossy[1:]] - times[lossy[:-1] + 1] > JOINED_WITHIN) + 1)
    found = []
    for run in runs:
        seconds = float(losses[run].sum())
        if seconds >= SHORTEST_DELAY:
            part = slice(run[0], run[-1] + 2)
            reason = _reason(fleet, schedule, arcs[run[0]], arcs[run[-1] + 1])
            found.append(Delay(seconds, times[part], arcs[part], reason))
    return found


def _losses(schedule: Schedule) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Arrival and departure at each knot's place, and the time lost between one and the next.

    Returns
    -------
    times, arc_lengths : (2 K,) arrays
    losses : (2 K - 1,) array
        Standing and driving in turn [s].
    """
    robot = schedule.robot
    nominal = nominal_timing(robot.path, robot.limits, start_yaw=robot.start_yaw, goal_yaw=robot.goal_yaw)
    steps = np.append(True, np.diff(schedule.arc_lengths) > SAME_PLACE)
    places = schedule.arc_lengths[steps]
    arrivals, departures = schedule.times[steps], schedule.times[np.append(np.flatnonzero(steps)[1:], len(steps)) - 1]
    alone = np.stack([nominal.first_time(places - SAME_PLACE), nominal.last_time(places + SAME_PLACE)], axis=1).ravel()
    times = np.stack([arrivals, departures], axis=1).ravel()
    if places[0] < SAME_PLACE:
        times[0] = min(times[0], robot.depart)
    return times, np.repeat(places, 2), np.diff(times) - np.diff(alone)


def _reason(fleet: FleetSchedule, schedule: Schedule, begin: float, end: float) -> Optional[Precedence]:
    """The rule from `begin` [m] on that binds: whose other robot has moved on just before this one passes."""
    slack = [(when(schedule, rule.at) - when(fleet[rule.other], rule.other_at), rule.at, rule)
             for rule in schedule.precedences
             if rule.other in fleet.by_name and begin - 0.01 <= rule.at <= end + REASON_REACH]
    if not slack:
        return None
    least, _, rule = min(slack, key=lambda item: item[:2])
    return rule if least <= REASON_SLACK else None


def occupancies(fleet: FleetSchedule) -> List[Tuple[str, Occupancy, Occupancy]]:
    """For each window among the planned robots its kind and both occupancies, the first robot's first; by time."""
    found = []
    for window in fleet.windows:
        if window.robot_r not in fleet.by_name or window.robot_s not in fleet.by_name:
            continue
        r = _occupancy(fleet[window.robot_r], window.r_enter, window.r_exit)
        s = _occupancy(fleet[window.robot_s], window.s_enter, window.s_exit)
        pair = (r, s) if window.first in ("", r.robot) else (s, r)
        found.append((window.kind,) + pair)
    return sorted(found, key=lambda item: (item[1].begin, item[1].robot, item[2].robot))


def _occupancy(schedule: Schedule, enter: float, leave: float) -> Occupancy:
    """A robot that waits just outside, to within `AT_THE_EDGE`, is not in."""
    return Occupancy(schedule.name, when(schedule, enter + AT_THE_EDGE, last=True), when(schedule, leave), enter, leave)


def driven_arcs(fleet: FleetSchedule, recording: Recording, step: float = 0.5) -> Dict[str, Progress]:
    """How far each robot had come at times about `step` [s] apart, until it came no further."""
    return {name: _reached(fleet[name], recording, index, step) for index, name in enumerate(recording.names)}


def _reached(schedule: Schedule, recording: Recording, index: int, step: float) -> Progress:
    """Progress by projecting true positions on the path, never backwards, and never further than one can drive."""
    wanted = np.arange(recording.times[0], recording.times[-1] + step, step)
    chosen = np.unique(np.searchsorted(recording.times, wanted).clip(0, len(recording.times) - 1))
    times, places = recording.times[chosen], recording.poses[chosen, index, :2]
    arcs = np.zeros(len(times))
    for now in range(1, len(times)):
        reach = 2.0 * schedule.robot.max_speed * (times[now] - times[now - 1]) + 0.3
        arcs[now] = schedule.robot.path.project(places[now], arcs[now - 1], arcs[now - 1] + reach)
    there = int(np.searchsorted(arcs, arcs[-1] - 0.01)) + 1
    return times[:there], arcs[:there]
