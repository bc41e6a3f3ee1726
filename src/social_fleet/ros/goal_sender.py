"""One goal for one robot by hand: plan from where it is, coordinate round the robots that stand about, let it drive."""

import copy
import time
from typing import Dict, List

import numpy as np
import rospy

from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import Schedule
from social_fleet.errors import InvalidInput, NotReady
from social_fleet.geometry import Pose
from social_fleet.msg import PlannedPath, Progress
from social_fleet.ros import conversions
from social_fleet.ros.admission import stands_for_good
from social_fleet.ros.fleet_client import Refused
from social_fleet.ros.frames import Frames
from social_fleet.srv import (Coordinate, CoordinateRequest, CoordinateResponse, PlanPath, PlanPathRequest,
                              PlanPathResponse)

_LISTEN = 1.0  # how long to listen for the fleet before asking [s, wall time]
_TF_PATIENCE = 2.0  # for tf to tell where a robot is [s, wall time]


class GoalSender:
    """Sends a robot to a goal while the others stand.

    Radius and speed of a robot are those that the planner announced last. A robot that nothing was announced of counts
    as large as the one that is sent: where the fleet is of several sizes, have every robot planned for once before.

    Subscribers
        fleet/progress (Progress): who is there and who moves; fleet/paths (PlannedPath): radii and speeds; tf.
    Services called
        social_planner/plan_path, fleet_coordinator/coordinate.
    """

    def __init__(self, patience: float = 30.0) -> None:
        self._patience = patience
        self._frames = Frames("map")
        self._progress: Dict[str, Progress] = {}
        self._paths: Dict[str, PlannedPath] = {}
        rospy.Subscriber("fleet/progress", Progress, self._on_progress, queue_size=100)
        rospy.Subscriber("fleet/paths", PlannedPath, self._on_path, queue_size=100)
        for name in ("social_planner/plan_path", "fleet_coordinator/coordinate"):
            try:
                rospy.wait_for_service(name, patience)
            except rospy.ROSException as error:
                raise NotReady(f"the service {rospy.resolve_name(name)} has not come up: {error}") from error
        self._plan = rospy.ServiceProxy("social_planner/plan_path", PlanPath)
        self._coordinate = rospy.ServiceProxy("fleet_coordinator/coordinate", Coordinate)

    def send(self, robot: str, goal: Pose) -> float:
        """Let `robot` drive to `goal` [m, rad, map frame]; seconds that it is scheduled to take.

        Raises
        ------
        InvalidInput
            There is no such robot, it is under way, or another one may move by an earlier schedule.
        Refused
            The planner or the coordinator says no; the message is theirs.
        NotReady
            No news of the fleet.
        """
        rospy.rostime.wallsleep(_LISTEN)
        if robot not in self._progress:
            known = ", ".join(sorted(self._progress)) or "none at all"
            raise InvalidInput(f"no tracker reports for robot '{robot}'; there are: {known}")
        self._check_standing(robot)
        start = self._frames.await_pose_of(f"{robot}/base_link", _TF_PATIENCE)
        answer = self._plan(PlanPathRequest(robot=robot, start=conversions.pose_to_stamped(start, "map"),
                                            goal=conversions.pose_to_stamped(goal, "map")))
        if answer.status != PlanPathResponse.SUCCESS:
            raise Refused(f"no path for {robot}: {answer.message}")
        path = self._planned(robot, start, answer)
        request = CoordinateRequest(planning=[path], fixed=self._parked(robot, path.radius),
                                    time_margin=1.0, time_limit=self._patience)
        schedules = self._coordinate(request)
        if schedules.status != CoordinateResponse.SUCCESS:
            raise Refused(f"no schedule for {robot}: {schedules.message}")
        return float(schedules.schedules[0].times[-1])

    def _check_standing(self, robot: str) -> None:
        """Refuse while anybody moves or may start to; only `robot` itself may be one that stopped on its way."""
        moving = sorted(name for name, news in self._progress.items() if not stands_for_good(news)
                        and not (name == robot and news.state == Progress.STOPPED))
        if moving:
            what = ", ".join(f"{name} ({_state(self._progress[name])})" for name in moving)
            raise InvalidInput(f"{what} may move by an earlier schedule; wait until it has arrived, or send it first "
                               "where it is stopped")

    def _planned(self, robot: str, start: Pose, answer: PlanPathResponse) -> PlannedPath:
        """The path that was asked for, with the size and speed that the planner announces for the robot."""
        deadline = time.monotonic() + self._patience
        while robot not in self._paths:
            if time.monotonic() > deadline:
                raise NotReady(f"the planner did not announce the path of {robot} on fleet/paths")
            rospy.rostime.wallsleep(0.02)
        message = copy.copy(self._paths[robot])
        message.header, message.path, message.temporary = answer.path.header, answer.path, answer.temporary
        message.start_orientation = conversions.yaw_to_quaternion(start.yaw)
        return message

    def _parked(self, robot: str, radius: float) -> List:
        """The others as schedules that stand still."""
        now = rospy.Time.now()
        parked = []
        for name in sorted(set(self._progress) - {robot}):
            pose = self._frames.await_pose_of(f"{name}/base_link", _TF_PATIENCE)
            size = self._paths[name].radius if name in self._paths else radius
            body = Robot(name, np.array([[pose.x, pose.y]]), radius=size, start_yaw=pose.yaw, goal_yaw=pose.yaw)
            still = Schedule(body, np.zeros(1), np.zeros(1), version=self._progress[name].schedule_version)
            parked.append(conversions.schedule_to_message(still, "map", now))
        return parked

    def _on_progress(self, message: Progress) -> None:
        self._progress[message.robot] = message

    def _on_path(self, message: PlannedPath) -> None:
        self._paths[message.robot] = message


def _state(news: Progress) -> str:
    """The state's name, as the message has it."""
    names = {getattr(Progress, name): name.lower() for name in dir(Progress) if name.isupper()}
    return names.get(news.state, str(news.state))
