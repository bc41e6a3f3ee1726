"""The node fleet_markers: the fleet in RViz."""

import threading
from dataclasses import dataclass
from typing import Dict, List, Tuple

import numpy as np
import rospy
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from social_fleet.coordination.schedule import EncounterWindow, Schedule
from social_fleet.errors import InvalidInput
from social_fleet.msg import (Directive, EncounterWindow as WindowMessage, Obstacle, PlannedPath, Progress,
                              Schedule as ScheduleMessage, Waiting)
from social_fleet.parameters import parameter
from social_fleet.ros import conversions, markers, parameters
from social_fleet.scenario.pictures.colours import robot_colours


@dataclass(frozen=True)
class FleetMarkersParameters:
    """Parameters of the node."""

    map_frame: str = "map"
    rate: float = parameter(10.0, above=0.0)  # of the robots' markers [Hz]
    text_height: float = parameter(2.0, above=0.0)  # of the robots' names [m]


class FleetMarkers:
    """Robots where they report to be, their plans, where they meet, and who waits for whom.

    Subscribers
        fleet/paths (PlannedPath), fleet/schedules (Schedule), fleet/windows (EncounterWindow),
        fleet/progress (Progress), fleet/following (Schedule): those that were made for robots under way, too;
        fleet/waiting (Waiting), fleet/directives (Directive): obstacles that the fleet has seen.
    Publishers
        visualization_marker_array (visualization_msgs/MarkerArray).
    Parameters
        `FleetMarkersParameters`.
    """

    def __init__(self) -> None:
        self._config = parameters.read_private(FleetMarkersParameters)
        self._lock = threading.Lock()
        self._numbers: Dict[str, int] = {}  # of the robots: colours and marker ids
        self._plans: Dict[str, np.ndarray] = {}
        self._schedules: Dict[str, Schedule] = {}
        self._windows: Dict[Tuple[int, str, str, float, float], EncounterWindow] = {}
        self._progress: Dict[str, Progress] = {}
        self._waits: Dict[str, Waiting] = {}
        self._obstacles: List[Obstacle] = []
        self._shown_obstacles = 0
        self._changed = True  # plans or windows differ from what was last shown
        self._shown_windows = 0
        self._out = rospy.Publisher("visualization_marker_array", MarkerArray, queue_size=2)
        rospy.Subscriber("fleet/paths", PlannedPath, self._hear_path, queue_size=100)
        rospy.Subscriber("fleet/schedules", ScheduleMessage, self._hear_schedule, queue_size=100)
        rospy.Subscriber("fleet/following", ScheduleMessage, self._hear_schedule, queue_size=100)
        rospy.Subscriber("fleet/waiting", Waiting, self._hear_waiting, queue_size=100)
        rospy.Subscriber("fleet/directives", Directive, self._hear_directive, queue_size=10)
        rospy.Subscriber("fleet/windows", WindowMessage, self._hear_window, queue_size=1000)
        rospy.Subscriber("fleet/progress", Progress, self._hear_progress, queue_size=100)
        rospy.Timer(rospy.Duration(1.0 / self._config.rate), self._show)
        rospy.Timer(rospy.Duration(2.0), self._show_all)

    def _hear_path(self, message: PlannedPath) -> None:
        try:
            points, _ = conversions.path_from_message(message.path, self._config.map_frame)
        except InvalidInput as error:
            rospy.logwarn_throttle(10.0, "a plan is not shown: %s" % error)
            return
        with self._lock:
            self._plans[message.robot] = points
            self._changed = True

    def _hear_schedule(self, message: ScheduleMessage) -> None:
        try:
            schedule = conversions.schedule_from_message(message, self._config.map_frame)
        except InvalidInput as error:
            rospy.logwarn_throttle(10.0, "a schedule is not shown: %s" % error)
            return
        with self._lock:
            known = self._schedules.get(message.robot)
            if known is not None and known.version > schedule.version:
                return
            self._schedules[message.robot] = schedule
            self._plans[message.robot] = schedule.robot.path.points
            self._changed = True

    def _hear_window(self, message: WindowMessage) -> None:
        """Windows of older coordinations leave when a robot of theirs has a newer schedule."""
        try:
            window = conversions.window_from_message(message)
        except InvalidInput as error:
            rospy.logwarn_throttle(10.0, "a window is not shown: %s" % error)
            return
        with self._lock:
            key = (message.version, window.robot_r, window.robot_s, window.r_enter, window.s_enter)
            self._windows[key] = window
            self._changed = True

    def _hear_progress(self, message: Progress) -> None:
        with self._lock:
            self._progress[message.robot] = message

    def _hear_waiting(self, message: Waiting) -> None:
        with self._lock:
            self._waits[message.robot] = message

    def _hear_directive(self, message: Directive) -> None:
        with self._lock:
            self._obstacles = message.obstacles

    def _number(self, robot: str) -> int:
        return self._numbers.setdefault(robot, len(self._numbers))

    def _colour(self, robot: str, alpha: float = 1.0) -> ColorRGBA:
        """The colour that pictures give the robot, too."""
        self._number(robot)
        return markers.colour_of(robot_colours(list(self._numbers))[robot], alpha)

    def _show_all(self, _event: rospy.timer.TimerEvent) -> None:
        """Also for an RViz that came late."""
        with self._lock:
            self._changed = True

    def _show(self, _event: rospy.timer.TimerEvent) -> None:
        with self._lock:
            shown = [item for name in sorted(self._progress) for item in self._robot(name)]
            if self._changed:
                shown += self._lines()
                self._changed = False
        if shown and not rospy.core.is_shutdown_requested():
            self._out.publish(MarkerArray(shown))

    def _robot(self, name: str) -> List[Marker]:
        """Disc, name, and whom it waits for."""
        progress, schedule, stamp = self._progress[name], self._schedules.get(name), rospy.Time.now()
        number, frame = self._number(name), self._config.map_frame
        if progress.header.frame_id == "" or (schedule is None and progress.reference.x == progress.reference.y == 0.0):
            return []
        position = (progress.reference.x, progress.reference.y)
        radius = 0.25 if schedule is None else schedule.robot.body_radius
        return [markers.disc_marker(number, position, radius, self._colour(name), frame, stamp),
                markers.text_marker("names", number, position, self._label(name), self._colour(name),
                                    self._config.text_height, frame, stamp), self._wait(name, position)]

    def _label(self, name: str) -> str:
        """The name, and what keeps the robot from driving."""
        wait, progress = self._waits.get(name), self._progress[name]
        if wait is not None and wait.waits:
            seconds = max((rospy.Time.now() - wait.header.stamp).to_sec(), 0.0)
            return f"{name} waits {seconds:.0f} s for {wait.other or 'what is in its way'}"
        return f"{name} is stopped: {progress.reason}" if progress.state == Progress.STOPPED else name

    def _wait(self, name: str, position: Tuple[float, float]) -> Marker:
        """A line from a robot that waits to the place that the other has to pass; none where it does not wait."""
        wait, number, frame = self._waits.get(name), self._number(name), self._config.map_frame
        other = None if wait is None or not wait.waits else self._schedules.get(wait.other)
        if wait is None or other is None:
            return Marker(ns="waits", id=number, action=Marker.DELETE)
        path = other.robot.path
        place = path.position(min(max(wait.other_at, 0.0), path.length))
        return markers.line_marker("waits", number, np.array([position, place]), self._colour(name, 0.9), 0.06, frame,
                                   rospy.Time.now())

    def _lines(self) -> List[Marker]:
        """Plans, and the stretches where robots meet."""
        stamp, frame = rospy.Time.now(), self._config.map_frame
        shown = [markers.line_marker("plans", self._number(name), points, self._colour(name, 0.8), 0.15, frame, stamp)
                 for name, points in self._plans.items() if len(points) > 1]
        self._windows = {key: window for key, window in self._windows.items() if self._current(key[0], window)}
        stretches = [stretch for window in self._windows.values() for stretch in (
            (window.kind, window.robot_r, window.r_enter, window.r_exit),
            (window.kind, window.robot_s, window.s_enter, window.s_exit)) if stretch[1] in self._schedules]
        shown += [markers.window_marker(number, kind, self._schedules[name].robot.path, enter, leave, frame, stamp)
                  for number, (kind, name, enter, leave) in enumerate(stretches)]
        shown += self._seen_obstacles()
        gone = range(len(stretches), self._shown_windows)
        shown += [Marker(ns="windows", id=number, action=Marker.DELETE) for number in gone]
        self._shown_windows = len(stretches)
        return shown

    def _seen_obstacles(self) -> List[Marker]:
        """Discs for what the map does not hold."""
        grey, stamp, count = ColorRGBA(0.3, 0.3, 0.3, 0.8), rospy.Time.now(), len(self._obstacles)
        shown = [markers.disc_marker(number, (item.x, item.y), item.radius, grey, self._config.map_frame, stamp,
                                     namespace="obstacles") for number, item in enumerate(self._obstacles)]
        shown += [Marker(ns="obstacles", id=number, action=Marker.DELETE)
                  for number in range(count, self._shown_obstacles)]
        self._shown_obstacles = count
        return shown

    def _current(self, version: int, window: EncounterWindow) -> bool:
        """Whether neither robot has a schedule newer than the window."""
        return all(self._schedules[name].version <= version for name in (window.robot_r, window.robot_s)
                   if name in self._schedules)
