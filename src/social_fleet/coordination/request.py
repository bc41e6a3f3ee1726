"""What a request for coordination must keep to, before anything is searched or solved."""

from typing import Sequence

import numpy as np

from social_fleet.coordination.robot import Robot, safety_distance
from social_fleet.coordination.schedule import Schedule
from social_fleet.coordination.verification import verify
from social_fleet.errors import InvalidScenario

_END_TOLERANCE = 1e-3  # by which a fixed schedule may miss the ends of its path [m]
_CONTACT = 1e-6  # overlap of two discs that is rounding [m]


def check_fleet(robots: Sequence[Robot], fixed: Sequence[Schedule], tolerance: float) -> None:
    """Raise InvalidScenario for what no schedule could come of."""
    for things, kind, field in ((robots, Robot, "robots"), (fixed, Schedule, "fixed")):
        if not isinstance(things, (list, tuple)) or not all(isinstance(thing, kind) for thing in things):
            raise InvalidScenario(f"must be a list of {kind.__name__}", field=field)
    if not robots:
        raise InvalidScenario("there is no robot to coordinate", field="robots")
    everyone = list(robots) + [schedule.robot for schedule in fixed]
    check_names([robot.name for robot in everyone])
    _check_under_way(fixed)
    _check_apart(robots, 0, "start", tolerance, planned=len(robots))
    _check_apart(everyone, -1, "goal", tolerance, planned=len(robots))


def check_names(names: Sequence[str]) -> None:
    """Raise InvalidScenario when a name comes twice."""
    for name in names:
        if names.count(name) > 1:
            raise InvalidScenario(f"two robots are named {name}; names must differ", field="robots")


def _check_under_way(fixed: Sequence[Schedule]) -> None:
    """Schedules under way must run to their ends, and must not touch among themselves: nothing could mend that."""
    for schedule in fixed:
        ends = schedule.arc_lengths[[0, -1]] - (0.0, schedule.robot.path.length)
        if np.abs(ends).max() > _END_TOLERANCE:
            raise InvalidScenario(f"the schedule of {schedule.name} must run from the start of its path to the end; "
                                  "cut the path where the schedule is cut", field="fixed")
    report = verify(fixed)
    if report.min_clearance < -_CONTACT:
        r, s, clearance, when = report.pairs[0]
        raise InvalidScenario(f"the schedules of {r} and {s} overlap by {-clearance:.2f} m at {when:.1f} s; stop one "
                              "of them and plan it anew", field="fixed")


def _check_apart(robots: Sequence[Robot], end: int, what: str, tolerance: float, planned: int) -> None:
    points = np.array([robot.path.points[end] for robot in robots])
    radii = np.array([robot.body_radius for robot in robots])
    rows, columns = np.triu_indices(len(robots), 1)
    rows, columns = rows[rows < planned], columns[rows < planned]
    if end == 0:  # robots under way are where they are
        waiting = np.array([robot.committed is None for robot in robots])
        counted = waiting[rows] & waiting[columns]
    else:  # those that go no farther than they are committed to end where they end
        settled = np.array([robot.committed is not None and robot.path.length <= robot.committed + _CONTACT
                            for robot in robots])
        counted = ~(settled[rows] & settled[columns])
    rows, columns = rows[counted], columns[counted]
    apart = np.hypot(*(points[rows] - points[columns]).T)
    needed = safety_distance(radii[rows], radii[columns], tolerance)
    for pair in np.flatnonzero(apart < needed)[:1]:
        r, s = robots[rows[pair]].name, robots[columns[pair]].name
        x, y = points[rows[pair]]
        raise InvalidScenario(f"{r} and {s} have {what}s {apart[pair]:.2f} m apart near ({x:.1f}, {y:.1f}); their "
                              f"discs need {needed[pair]:.2f} m; move one of them", field="robots")
