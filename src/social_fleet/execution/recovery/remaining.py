"""What is left of a robot's way: the stretch that it is committed to, and the path behind that."""

from dataclasses import dataclass, replace
from typing import Optional, Sequence, Tuple

import numpy as np

from social_fleet.coordination.replanning import PlannerReplanner, Replanner
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import Schedule
from social_fleet.coordination.timing import ACCELERATION_SHARE, Timing
from social_fleet.execution.recovery.messages import Report
from social_fleet.geometry import Polyline, Pose
from social_fleet.planning.overlays.discs import Disc

_STANDING = 0.02  # slower is standing [m/s]


@dataclass(frozen=True)
class Remaining:
    """One robot's promise, as the beginning of whatever it is to drive next.

    Attributes
    ----------
    report : Report
        With the promise.
    schedule : Schedule, optional
        What it follows; None where it follows nothing, or is astray.
    origin : float
        Where on that schedule's path the robot is [m].
    prefix : Polyline
        From there to where it has promised to stop.
    """

    report: Report
    schedule: Optional[Schedule]
    origin: float
    prefix: Polyline

    @classmethod
    def of(cls, report: Report, schedule: Optional[Schedule]) -> "Remaining":
        """What a promise leaves of a schedule; None: it follows none. The report must know its pose then."""
        if schedule is None or report.astray:
            assert report.pose is not None
            return cls(report, None, 0.0, Polyline([report.pose[:2]]))
        path = schedule.robot.path
        origin = min(max(report.arc_length, 0.0), path.length)
        return cls(report, schedule, origin, path.slice(origin, min(max(report.bound, origin), path.length)))

    @property
    def committed(self) -> float:
        """How far it drives in any case [m]."""
        return self.prefix.length

    @property
    def end(self) -> Pose:
        """Where it will have come to then [m, rad]; the heading of one that stands is its own."""
        x, y = self.prefix.points[-1]
        if self.prefix.length > 0.0:
            step = self.prefix.points[-1] - self.prefix.points[-2]
            return Pose(float(x), float(y), float(np.arctan2(step[1], step[0])))
        return Pose(float(x), float(y), 0.0 if self.report.pose is None else self.report.pose.yaw)

    @property
    def way(self) -> Polyline:
        """All that is left of the present path."""
        if self.schedule is None:
            return self.prefix
        path = self.schedule.robot.path
        return path.slice(self.origin, path.length)

    @property
    def goal_yaw(self) -> Optional[float]:
        """Of the present path [rad]."""
        return None if self.schedule is None else self.schedule.robot.goal_yaw

    def robot(self, path: Polyline, *, depart: float, goal_yaw: Optional[float]) -> Robot:
        """The robot on `path`, which begins with the prefix, under way from `depart` [s] on."""
        report, limits = self.report, self.report.body.limits
        lead = 0.5 * report.speed / (ACCELERATION_SHARE * limits.max_acceleration)  # schedules begin from standstill
        standing = abs(report.speed) < _STANDING and report.pose is not None
        return Robot(report.name, path.points, max_speed=limits.max_speed, radius=report.body.radius,
                     depart=max(depart - lead, 0.0),
                     start_yaw=report.pose.yaw if standing and report.pose is not None else None, goal_yaw=goal_yaw,
                     max_acceleration=limits.max_acceleration, max_turn_rate=limits.max_turn_rate,
                     max_turn_acceleration=limits.max_turn_acceleration, weight=report.body.weight,
                     committed=self.committed)

    def staying(self, depart: float) -> Robot:
        """The robot that goes no farther than it has promised to."""
        return self.robot(self.prefix, depart=depart, goal_yaw=None)

    def former(self, robot: Robot) -> Optional[Schedule]:
        """The present schedule along the path of `robot`, which is what is left of the present one."""
        if self.schedule is None:
            return None
        timing = Timing(self.schedule.arc_lengths, self.schedule.times)
        arcs, times = self.schedule.arc_lengths, self.schedule.times
        ahead = arcs > self.origin + 1e-6
        begin = float(timing.last_time(self.origin))
        if not ahead.any() or times[ahead][0] <= begin:
            return Schedule(robot, np.zeros(1), np.array([begin]))
        return Schedule(robot, np.minimum(np.append(0.0, arcs[ahead] - self.origin), robot.path.length),
                        np.append(begin, times[ahead]))


def joined(prefix: Polyline, onward: Polyline) -> Polyline:
    """Two paths, the second from the end of the first."""
    return Polyline(np.vstack((prefix.points, onward.points[1:]))) if len(onward.points) > 1 else prefix


class ContinuingReplanner(Replanner):
    """Finds other paths for robots under way: what they are committed to stays.

    Parameters
    ----------
    planner : PlannerReplanner
        Plans from standing starts.
    remaining : sequence of Remaining
        All robots.
    """

    def __init__(self, planner: PlannerReplanner, remaining: Sequence[Remaining]) -> None:
        self._planner = planner
        self._remaining = {item.report.name: item for item in remaining}

    def detour(self, robot: Robot, avoid: Sequence[Disc]) -> Optional[Robot]:
        """See `Replanner`."""
        changed = self._planner.detour(self._onward(robot), avoid)
        return None if changed is None else self._whole(robot, changed)

    def aside(self, robot: Robot, others: Sequence[Robot], distance: float, avoid: Sequence[Disc]):  # type: ignore
        """See `Replanner`."""
        for changed in self._planner.aside(self._onward(robot), others, distance, avoid):
            yield self._whole(robot, changed)

    def _onward(self, robot: Robot) -> Robot:
        end, goal = self._remaining[robot.name].end, robot.path.points[-1]
        return replace(robot, plan=np.array([end[:2], goal]), start_yaw=end.yaw, committed=None)

    def _whole(self, robot: Robot, changed: Robot) -> Robot:
        return replace(robot, plan=joined(self._remaining[robot.name].prefix, changed.path).points)


def stretch(remaining_path: Polyline, length: float, spacing: float = 0.2) -> Tuple[Tuple[float, float], ...]:
    """Places [m] on the first `length` metres of a path, both ends included."""
    length = min(length, remaining_path.length)
    places = remaining_path.position(np.linspace(0.0, length, max(int(np.ceil(length / spacing)), 1) + 1))
    return tuple((float(x), float(y)) for x, y in places)
