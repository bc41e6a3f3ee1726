"""The program of one simulated robot: its part in the fleet, and its eyes."""

import math
from typing import Mapping, Optional

import numpy as np

from social_fleet.execution.lidar_stop import LidarStop
from social_fleet.execution.obstacle_watch import ObstacleWatch
from social_fleet.execution.recovery.config import RecoveryConfig
from social_fleet.execution.recovery.member import Member
from social_fleet.execution.recovery.messages import Body, Directive, Report
from social_fleet.execution.state import STANDSTILL, Command
from social_fleet.execution.tracker import Tracker
from social_fleet.geometry import Pose, compose, inverse
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.overlays.shapes import DiscObstacle
from social_fleet.simulation.sight import hits, in_sight

_REACH = 4.0  # of the lidar [m]
_LOOK = 0.25  # between two looks for obstacles [s]
_REPORT, _QUIET = 0.2, 0.5  # between two reports of a robot that moves, and of one that stands [s]
_BESIDE = 0.2  # hits so close to a robot's disc, where it says that it is, are of that robot [m]


class Agent:
    """What runs on one robot.

    Attributes
    ----------
    member : Member
        Its part in the fleet.
    """

    def __init__(self, name: str, body: Body, tracker: Tracker, session: int, recovery: RecoveryConfig,
                 grid: Optional[OccupancyGrid]) -> None:
        self.member = Member(name, body, tracker, session=session, config=recovery)
        self._eyes = LidarStop(body.radius)
        self._watch = ObstacleWatch(f"{name}/{session}")
        self._grid = grid
        self._known: Mapping[str, DiscObstacle] = {}
        self._followed = -1
        self._looked = self._reported = -math.inf
        self._last: Optional[Report] = None

    @property
    def settled(self) -> bool:
        """Whether it stands at its goal, or has given it up."""
        return self.member.served or bool(self.given_up)

    @property
    def given_up(self) -> str:
        """Why the present errand is given up; empty when it is not."""
        given, errand = self.member.assignment, self.member.errand
        over = given is not None and given.final and errand is not None and given.errand == errand.number
        return given.reason if over and given is not None else ""

    def hear(self, directive: Directive) -> None:
        """Take in what the dispatcher says."""
        self._known = directive.obstacles
        self.member.hear(directive)

    def hear_report(self, report: Report) -> None:
        """Take in what another robot says."""
        self.member.hear_report(report)
        if report.cleared:
            self._watch.forget(report.cleared)

    def step(self, now: float, pose: Optional[Pose], truth: Pose, discs: np.ndarray, own: int) -> Command:
        """The command for the period that begins at `now` [s].

        Parameters
        ----------
        pose : Pose, optional
            Where the robot takes itself to be [m, rad, map frame].
        truth : Pose
            Where it is: its eyes see from there.
        discs : (D, 3) array
            True centres and radii of all robots, its own in row `own`, and of obstacles [m].
        """
        horizon, ahead = math.inf, math.inf
        tracker = self.member.tracker
        looks = now - self._looked >= _LOOK - 1e-9
        if pose is not None and (looks or not tracker.arrived):  # one that has arrived needs its eyes for others only
            points = self._points(pose, truth, discs, own)
            if tracker.schedule is not None and len(points):
                if tracker.schedule.version != self._followed:
                    self._eyes.follow(tracker.schedule.robot.path)
                    self._followed = tracker.schedule.version
                horizon = self._eyes.horizon(points, tracker.progress, pose)
                ahead = self._eyes.ahead(points, pose)
            if looks and tracker.pose_believed:
                self._looked = now
                self._look(now, pose, truth, points, discs, own)
        return self.member.step(now, pose, horizon=horizon, ahead=ahead)

    def _points(self, pose: Pose, truth: Pose, discs: np.ndarray, own: int) -> np.ndarray:
        """Hits as the robot places them on the map, (N, 2) [m]."""
        points = hits(truth.x, truth.y, discs, _REACH, own)
        if not len(points) or pose == truth:
            return points
        shift = compose(pose, inverse(truth))
        cos, sin = math.cos(shift.yaw), math.sin(shift.yaw)
        return points @ np.array([[cos, sin], [-sin, cos]]) + shift[:2]

    def _look(self, now: float, pose: Pose, truth: Pose, points: np.ndarray, discs: np.ndarray, own: int) -> None:
        """Look for obstacles among the hits that no robot explains."""
        if len(points):
            for report in self.member.others.values():
                heard = now - report.stamp <= self.member.config.gone
                if heard and report.pose is not None and len(points):
                    gaps = np.hypot(points[:, 0] - report.pose.x, points[:, 1] - report.pose.y)
                    points = points[gaps > report.body.radius + _BESIDE]
        if not len(points) and not self._known and not self._watch.obstacles:
            return

        def visible(shape: DiscObstacle) -> bool:
            return self._grid is None or in_sight(self._grid, truth.x, truth.y, (shape.x, shape.y))

        self._watch.see(now, pose, points, self._known, visible)
        self.member.obstacles, self.member.cleared = self._watch.obstacles, self._watch.cleared

    def news(self, now: float) -> Optional[Report]:
        """A report, when one is due."""
        moves = self.member.tracker.command != STANDSTILL
        due = now - self._reported >= (_REPORT if moves else _QUIET) - 1e-9
        last, member = self._last, self.member
        changed = last is None or (member.version, member.exchange, member.tracker.state) != (
            last.version, last.exchange, last.state)
        if not (due or changed):
            return None
        self._reported = now
        self._last = member.report(now)
        return self._last
