"""What a navigator asks of the planner and of the coordinator, and what their refusals mean."""

import threading
from typing import Any, Dict

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path

from social_fleet.coordination.robot import MotionLimits
from social_fleet.errors import SocialFleetError
from social_fleet.geometry import Pose
from social_fleet.msg import PlannedPath, Schedule
from social_fleet.ros import conversions
from social_fleet.srv import (Coordinate, CoordinateRequest, CoordinateResponse, PlanPath, PlanPathRequest,
                              PlanPathResponse)

_PRESENCE = 1.0  # that a service is waited for [s, wall time]
_HOPELESS = (PlanPathResponse.INVALID_GOAL, PlanPathResponse.NO_PATH_FOUND, PlanPathResponse.INVALID_REQUEST,
             PlanPathResponse.TF_ERROR)


class ErrandRefused(SocialFleetError):
    """A path or a schedule that is not to be had.

    Parameters
    ----------
    message
        Why, as a sentence.
    final
        Whether asking again will not help.
    """

    def __init__(self, message: str, *, final: bool = False) -> None:
        self.final = final
        super().__init__(message)


class FleetErrands:
    """Plans and schedules for one robot; may be used from any thread.

    Parameters
    ----------
    robot
        Its name.
    frame
        The map's frame.
    limits
        `max_acceleration`, `max_turn_rate`, `max_turn_acceleration` by name; 0 for the defaults.
    time_limit
        For the coordinator [s].

    Subscribers
        fleet/schedules, fleet/following (Schedule): what the others drive.
    Services called
        social_planner/plan_path (PlanPath), fleet_coordinator/coordinate (Coordinate).
    """

    def __init__(self, robot: str, frame: str, *, limits: Dict[str, float], time_limit: float) -> None:
        self._robot, self._frame, self._limits, self._time_limit = robot, frame, limits, time_limit
        self._lock = threading.Lock()
        self._schedules: Dict[str, Schedule] = {}
        self._plan = rospy.ServiceProxy("social_planner/plan_path", PlanPath)
        self._coordinate = rospy.ServiceProxy("fleet_coordinator/coordinate", Coordinate)
        for topic in ("fleet/schedules", "fleet/following"):
            rospy.Subscriber(topic, Schedule, self._hear_schedule, queue_size=100)

    def _hear_schedule(self, message: Schedule) -> None:
        with self._lock:
            known = self._schedules.get(message.robot)
            if known is None or message.version >= known.version:
                self._schedules[message.robot] = message

    def plan(self, start: Pose, goal: Pose) -> PlannedPath:
        """The path that the robot is to drive; raises ErrandRefused."""
        answer = self._call(self._plan, PlanPathRequest(
            robot=self._robot, start=conversions.pose_to_stamped(start, self._frame),
            goal=conversions.pose_to_stamped(goal, self._frame)))
        if answer.status != PlanPathResponse.SUCCESS:
            raise ErrandRefused(f"no path: {answer.message}", final=answer.status in _HOPELESS)
        return self._path(answer.path, start, answer.radius, answer.max_speed, answer.temporary)

    def inquire(self, start: PoseStamped, goal: PoseStamped, tolerance: float) -> Path:
        """A path that nobody is going to drive; raises ErrandRefused."""
        answer = self._call(self._plan, PlanPathRequest(robot=self._robot, start=start, goal=goal,
                                                        tolerance=tolerance, inquiry=True))
        if answer.status != PlanPathResponse.SUCCESS:
            raise ErrandRefused(f"no path: {answer.message}", final=True)
        path: Path = answer.path
        return path

    def coordinate(self, path: PlannedPath) -> Schedule:
        """A schedule for `path` that is in force, round what the others drive; raises ErrandRefused."""
        with self._lock:
            fixed = [message for name, message in sorted(self._schedules.items()) if name != self._robot]
        answer = self._call(self._coordinate, CoordinateRequest(planning=[path], fixed=fixed,
                                                                time_limit=self._time_limit))
        if answer.status != CoordinateResponse.SUCCESS:
            raise ErrandRefused(f"no schedule: {answer.message}")
        for message in [*answer.schedules, *answer.amended]:
            self._hear_schedule(message)
        return next(message for message in answer.schedules if message.robot == self._robot)

    def park(self, pose: Pose, radius: float) -> Schedule:
        """Have the fleet know that the robot stands at `pose` for good; raises ErrandRefused."""
        path = conversions.path_to_message(np.array([pose[:2]]), pose.yaw, self._frame, rospy.Time.now())
        return self.coordinate(self._path(path, pose, radius, MotionLimits.max_speed, False))

    def _path(self, path: Path, start: Pose, radius: float, max_speed: float, temporary: bool) -> PlannedPath:
        message = PlannedPath(header=path.header, robot=self._robot, path=path, radius=radius, max_speed=max_speed,
                              temporary=temporary, start_orientation=conversions.yaw_to_quaternion(start.yaw))
        for name, value in self._limits.items():
            setattr(message, name, value)
        return message

    def _call(self, proxy: rospy.ServiceProxy, request: Any) -> Any:
        """The answer of a service; raises ErrandRefused where there is none."""
        try:
            rospy.wait_for_service(proxy.resolved_name, _PRESENCE)
            return proxy(request)
        except (rospy.ROSException, rospy.ServiceException) as error:
            raise ErrandRefused(f"the service {proxy.resolved_name} does not answer: {error}") from error
