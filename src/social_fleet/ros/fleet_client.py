"""Asks the planner and the coordinator for a scenario's schedules."""

import time
from typing import Any, List, Sequence, Tuple

import rospy

from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.errors import NotReady, SocialFleetError
from social_fleet.geometry import Polyline, Pose
from social_fleet.msg import EncounterWindow, PlannedPath, Schedule
from social_fleet.ros import conversions
from social_fleet.scenario.files import RobotSpec, Scenario
from social_fleet.srv import (Coordinate, CoordinateRequest, CoordinateResponse, PlanPath, PlanPathRequest,
                              PlanPathResponse)

_RETRY = 0.1  # [s] of wall time
_LIMITS = ("max_acceleration", "max_turn_rate", "max_turn_acceleration")


class Refused(SocialFleetError):
    """A service answered with a status that is no success; the message is the service's."""


class FleetClient:
    """Plans and coordinates through services.

    Parameters
    ----------
    planner, coordinator
        Names of the services.
    frame
        The map's frame.
    patience
        Longest wait for a service, and for the planner's map [s, wall time].
    """

    def __init__(self, planner: str, coordinator: str, frame: str, patience: float) -> None:
        self._frame = frame
        self._deadline = time.monotonic() + patience
        self._plan = self._service(planner, PlanPath)
        self._coordinate = self._service(coordinator, Coordinate)

    def plan(self, spec: RobotSpec) -> PlannedPath:
        """The path of one robot, with all that coordination wants to know of it."""
        request = PlanPathRequest(robot=spec.name)
        request.start = conversions.pose_to_stamped(_pose(spec.start), self._frame)
        request.goal = conversions.pose_to_stamped(_pose(spec.goal), self._frame)
        answer = self._plan(request)
        while answer.status == PlanPathResponse.NOT_INITIALIZED and time.monotonic() < self._deadline:
            rospy.rostime.wallsleep(_RETRY)
            answer = self._plan(request)
        if answer.status != PlanPathResponse.SUCCESS:
            raise Refused(f"no path for robot {spec.name}: {answer.message}")
        message = PlannedPath(header=answer.path.header, robot=spec.name, path=answer.path, radius=spec.radius,
                              max_speed=spec.max_speed, depart=spec.depart, temporary=answer.temporary)
        message.start_orientation = request.start.pose.orientation
        for name in _LIMITS:
            setattr(message, name, getattr(spec, name) or 0.0)
        if len(spec.goal) == 2:
            _arrive_as_driven(message)
        return message

    def coordinate(self, scenario: Scenario, paths: Sequence[PlannedPath]) -> Tuple[FleetSchedule, List[Schedule]]:
        """Schedules of all robots, as the scenario's mode wants them."""
        sequential = scenario.coordination.mode == "sequential"
        requests = [[path] for path in paths] if sequential else [list(paths)]
        schedules: List[Schedule] = []
        windows: List[EncounterWindow] = []
        answers: List[CoordinateResponse] = []
        for planning in requests:
            answers.append(self._coordinate(CoordinateRequest(
                planning=planning, fixed=schedules, time_margin=scenario.coordination.time_margin,
                time_limit=scenario.coordination.time_limit)))
            if answers[-1].status != CoordinateResponse.SUCCESS:
                raise Refused(f"no schedule: {answers[-1].message}")
            amended = {message.robot: message for message in answers[-1].amended}
            schedules = [amended.get(message.robot, message) for message in schedules] + answers[-1].schedules
            windows += answers[-1].windows
        fleet = FleetSchedule(
            tuple(conversions.schedule_from_message(message, self._frame) for message in schedules),
            tuple(conversions.window_from_message(message) for message in windows),
            formulation=scenario.coordination.formulation, objective=sum(answer.objective for answer in answers),
            gap=max(answer.gap for answer in answers), solve_time=sum(answer.solve_time for answer in answers),
            map=scenario.map, message="; ".join(answer.message for answer in answers if answer.message))
        return fleet, schedules

    def _service(self, name: str, kind: Any) -> rospy.ServiceProxy:
        try:
            rospy.wait_for_service(name, max(self._deadline - time.monotonic(), _RETRY))
        except rospy.ROSException as error:
            raise NotReady(f"the service {rospy.resolve_name(name)} has not come up: {error}") from error
        return rospy.ServiceProxy(name, kind)


def _pose(values: Sequence[float]) -> Pose:
    return Pose(values[0], values[1], values[2] if len(values) > 2 else 0.0)


def _arrive_as_driven(message: PlannedPath) -> None:
    """Any heading will do at the goal: keep the one that the robot has there."""
    points = [(stamped.pose.position.x, stamped.pose.position.y) for stamped in message.path.poses]
    path = Polyline(points)
    message.path.poses[-1].pose.orientation = conversions.yaw_to_quaternion(path.heading(path.length))
