"""What a robot's lidar sees that the map does not hold: how far the way is free, and obstacles for the fleet."""

import math
import threading
from collections import deque
from dataclasses import dataclass
from functools import partial
from typing import Any, Deque, Mapping, NamedTuple, Optional, Tuple

import numpy as np
import rospy
from nav_msgs.msg import OccupancyGrid as GridMessage
from rospy.numpy_msg import numpy_msg
from scipy.ndimage import distance_transform_edt
from sensor_msgs.msg import LaserScan

from social_fleet.errors import InvalidInput
from social_fleet.execution.lidar_stop import LidarStop, points_of_scan
from social_fleet.execution.obstacle_watch import ObstacleWatch
from social_fleet.execution.recovery.messages import Report
from social_fleet.execution.tracker import Tracker
from social_fleet.geometry import Polyline, Pose, compose
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.parameters import parameter
from social_fleet.planning.overlays.shapes import DiscObstacle
from social_fleet.ros import conversions
from social_fleet.ros.exchange_conversions import FleetClock
from social_fleet.ros.frames import Frames
from social_fleet.simulation.sight import in_sight

_LOOK = 0.25  # between two looks for obstacles [s]
_MEMORY = 40  # poses that are remembered: scans come later than odometry
_BESIDE = 0.2  # hits so close to a robot's disc, where it says that it is, are of that robot [m]


@dataclass(frozen=True)
class EyesParameters:
    """How a tracker uses its lidar."""

    margin: float = parameter(0.03, above=0.0)  # kept to what is seen, beyond the robot's disc [m]
    standoff: float = parameter(0.25, above=0.0)  # how far before it would come so near the robot stands [m]
    reach: float = parameter(3.0, above=0.0)  # how far ahead the way has to be free to be driven at full speed [m]
    range_max: float = parameter(6.0, above=0.0)  # hits farther away are left out [m]
    wall_margin: float = parameter(0.25, minimum=0.0)  # hits so close to a wall of the map are of that wall [m]
    timeout: float = parameter(1.0, above=0.0)  # a lidar that is silent for so long stops the robot [s]


class View(NamedTuple):
    """How far a robot may drive by what its lidar sees."""

    horizon: float  # along its path, by arc length [m]
    ahead: float  # straight on, where it is off its path [m]


FREE = View(math.inf, math.inf)


class Eyes:
    """Keeps what the last scan hit, where the robot was then, and what that means.

    Without a map there are no obstacles for the fleet, and walls stop the robot like anything else. Without any scan so
    far the robot is taken to have no lidar; one whose scans cannot be placed on the map stands.

    Subscribers
        scan (sensor_msgs/LaserScan), map (nav_msgs/OccupancyGrid).

    Parameters
    ----------
    name, radius
        What the names of its obstacles begin with, see `ObstacleWatch`, and the radius of the robot's disc [m].
    clock, frames
        Of the node.
    config
        See there.

    Attributes
    ----------
    reason : str
        Why the view is not free, as a sentence.
    """

    def __init__(self, name: str, radius: float, clock: FleetClock, frames: Frames, config: EyesParameters) -> None:
        self.reason = ""
        self._config, self._clock, self._frames = config, clock, frames
        self._stop = LidarStop(radius, margin=config.margin, standoff=config.standoff, reach=config.reach)
        self._watch = ObstacleWatch(name)
        self._known: Mapping[str, DiscObstacle] = {}
        self._lock = threading.Lock()
        self._poses: Deque[Tuple[float, Pose]] = deque(maxlen=_MEMORY)
        self._points = np.zeros((0, 2))
        self._has_lidar = False
        self._scanned: Optional[float] = None  # when the last scan was that could be placed on the map [s]
        self._mount: Optional[Pose] = None  # of the sensor on the robot
        self._base = ""
        self._grid: Optional[OccupancyGrid] = None
        self._to_wall = np.zeros((0, 0))
        self._followed: object = None
        self._looked = -math.inf
        _load_compiled_code(radius)
        rospy.Subscriber("map", numpy_msg(GridMessage), self._hear_map, queue_size=1)
        rospy.Subscriber("scan", LaserScan, self._hear_scan, queue_size=1, tcp_nodelay=True)

    @property
    def obstacles(self) -> Mapping[str, DiscObstacle]:
        """What this robot has seen, by names that are its own."""
        return self._watch.obstacles

    @property
    def cleared(self) -> Tuple[str, ...]:
        """Obstacles of any robot that this one sees to be gone."""
        return self._watch.cleared

    def know(self, obstacles: Mapping[str, DiscObstacle]) -> None:
        """The fleet's obstacles; what is no longer among them was seen to be gone."""
        self._watch.forget([name for name in self._known if name not in obstacles])
        self._known = obstacles

    def view(self, now: float, pose: Optional[Pose], base: str, tracker: Tracker,
             others: Mapping[str, Report]) -> View:
        """How far the way is free.

        Parameters
        ----------
        now, pose, base
            The time [s], and where the robot's frame `base` is then [m, rad, map frame].
        tracker
            What it drives.
        others
            The other robots' latest reports: they are no obstacles.
        """
        self.reason = ""
        if pose is not None:
            self._poses.append((now, pose))
            self._base = base
        with self._lock:
            points, scanned = self._points, self._scanned
        if not self._has_lidar or tracker.schedule is None:
            return FREE
        if scanned is None or now - scanned > self._config.timeout:
            self.reason = "the lidar says nothing" if self._mount is not None else "its lidar's place on it is unknown"
            return View(-math.inf, 0.0)
        if pose is None:
            return FREE
        if tracker.schedule is not self._followed:
            self._followed = tracker.schedule
            self._stop.follow(tracker.schedule.robot.path)
        if now - self._looked >= _LOOK and tracker.pose_believed:
            self._looked = now
            self._look(now, pose, points, others)
        horizon = self._stop.horizon(points, tracker.progress, pose)
        if math.isfinite(horizon):
            self.reason = f"something stands in the way at {horizon:.1f} m"
        return View(horizon, self._stop.ahead(points, pose))

    def _look(self, now: float, pose: Pose, points: np.ndarray, others: Mapping[str, Report]) -> None:
        """Look for obstacles among the hits that neither map nor robots explain."""
        grid = self._grid
        if grid is None:
            return
        for report in others.values():
            if report.pose is not None and len(points):
                gaps = np.hypot(points[:, 0] - report.pose.x, points[:, 1] - report.pose.y)
                points = points[gaps > report.body.radius + _BESIDE]
        if len(points) or self._known or self._watch.obstacles:
            self._watch.see(now, pose, points, self._known, partial(_is_in_sight, grid, pose))

    def _hear_map(self, message: GridMessage) -> None:
        try:
            grid = conversions.grid_from_message(message)
        except InvalidInput as error:
            rospy.logerr("the map cannot be used: %s", error)
            return
        to_wall = distance_transform_edt(~grid.blocked) * grid.resolution
        self._grid, self._to_wall = grid, to_wall.astype(np.float32)

    def _hear_scan(self, message: LaserScan) -> None:
        """Place the hits on the map, and leave out those of walls."""
        self._has_lidar = True
        stamp = self._clock.seconds(message.header.stamp)
        pose = self._pose_at(stamp, conversions.frame_name(message.header.frame_id))
        if pose is None:
            return
        ranges: Any = np.array(message.ranges)
        ranges[ranges < message.range_min] = np.inf
        angles: Any = message.angle_min + message.angle_increment * np.arange(len(ranges))
        points = points_of_scan(ranges, angles, pose, range_max=min(self._config.range_max, message.range_max))
        if self._grid is not None:
            points = points[self._far_from_walls(self._grid, points)]
        with self._lock:
            self._points, self._scanned = points, stamp

    def _pose_at(self, stamp: float, frame: str) -> Optional[Pose]:
        """Where the sensor was; None while that is not known."""
        if not self._poses:
            return None
        pose = min(list(self._poses), key=lambda item: abs(item[0] - stamp))[1]
        if self._mount is None:
            try:
                self._mount = Pose(0.0, 0.0, 0.0) if frame == self._base else self._frames.between(self._base, frame)
            except InvalidInput as error:
                rospy.logwarn_throttle(10.0, "scans are left out: %s" % error)
                return None
        return compose(pose, self._mount)

    def _far_from_walls(self, grid: OccupancyGrid, points: np.ndarray) -> np.ndarray:
        """Which points (N, 2) lie on the map and away from its walls."""
        local = np.floor(np.asarray(grid.to_local(points)) / grid.resolution).astype(int)
        columns, rows = local[:, 0], local[:, 1]
        on = (rows >= 0) & (rows < grid.shape[0]) & (columns >= 0) & (columns < grid.shape[1])
        far = np.zeros(len(points), dtype=bool)
        far[on] = self._to_wall[rows[on], columns[on]] > self._config.wall_margin
        return far


def _is_in_sight(grid: OccupancyGrid, pose: Pose, shape: DiscObstacle) -> bool:
    return in_sight(grid, pose.x, pose.y, (shape.x, shape.y))


def _load_compiled_code(radius: float) -> None:
    """What is loaded, or compiled, when it is first called would otherwise be so while the robot drives."""
    stop, here, far = LidarStop(radius), Pose(0.5, 0.5, 0.0), np.array([(9.0, 9.0)])
    stop.follow(Polyline([(0.0, 0.0), (1.0, 0.0)]))
    stop.horizon(far, 0.0, here)
    stop.ahead(far, here)
    in_sight(OccupancyGrid(np.zeros((2, 2), dtype=np.int8), 1.0), here.x, here.y, (1.5, 0.5))
