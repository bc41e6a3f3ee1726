"""One goal for one robot by hand, through its navigator; the others may stand or drive."""

import time
from typing import Callable, Dict

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal

from social_fleet.errors import InvalidInput, NotReady
from social_fleet.geometry import Pose
from social_fleet.msg import NavigationStatus, Schedule
from social_fleet.ros import conversions
from social_fleet.ros.fleet_client import Refused

_LOOK = 0.05  # between two looks at what has come of it [s, wall time]
_GREETING = 5.0  # for a robot's navigator to be heard of [s, wall time]


class GoalSender:
    """Sends a robot to a goal, and waits until it is under way.

    Actions called
        ROBOT/move_base (move_base_msgs/MoveBaseAction).
    Subscribers
        fleet/navigation (NavigationStatus): who is there, and what comes of the goal; fleet/following (Schedule).

    Parameters
    ----------
    patience
        For planner and fleet to make way [s, wall time].
    frame
        The map's frame.
    """

    def __init__(self, patience: float = 90.0, frame: str = "map") -> None:
        self._patience, self._frame = patience, frame
        self._states: Dict[str, NavigationStatus] = {}
        self._schedules: Dict[str, Schedule] = {}
        rospy.Subscriber("fleet/navigation", NavigationStatus, self._hear_state, queue_size=100)
        rospy.Subscriber("fleet/following", Schedule, self._hear_schedule, queue_size=100)

    def send(self, robot: str, goal: Pose) -> float:
        """Let `robot` drive to `goal` [m, rad, map frame]; seconds that it is scheduled to take.

        Raises
        ------
        InvalidInput
            No navigator of such a robot is there.
        Refused
            The goal is given up; the message says why.
        NotReady
            Nobody has answered in time.
        """
        if not self._await(lambda: robot in self._states, _GREETING):
            known = ", ".join(sorted(self._states)) or "none at all"
            raise InvalidInput(f"there is no navigator of robot '{robot}'; there are: {known}")
        client = actionlib.SimpleActionClient(f"{robot}/move_base", MoveBaseAction)
        if not client.wait_for_server(rospy.Duration.from_sec(self._patience)):
            raise NotReady(f"the action {rospy.resolve_name(robot)}/move_base does not answer")
        former = self._states[robot].number
        client.send_goal(MoveBaseGoal(conversions.pose_to_stamped(goal, self._frame, rospy.Time.now())))
        self._await(lambda: _is_over(client) or self._drives(robot, former), self._patience)
        if self._drives(robot, former):
            schedule = self._schedules[robot]
            return float((schedule.header.stamp - rospy.Time.now()).to_sec() + schedule.times[-1])
        if client.get_state() == GoalStatus.SUCCEEDED:
            return 0.0
        if _is_over(client):
            raise Refused(f"{robot} does not go there: {client.get_goal_status_text()}")
        state = self._states[robot]
        raise NotReady(f"{robot} has not set off within {self._patience:g} s: {state.reason or 'nobody says why'}")

    def _drives(self, robot: str, former: int) -> bool:
        state, schedule = self._states[robot], self._schedules.get(robot)
        return (state.number > former and state.state == NavigationStatus.DRIVING and schedule is not None
                and schedule.version >= state.schedule_version)

    @staticmethod
    def _await(condition: Callable[[], bool], patience: float) -> bool:
        """Whether the condition came true in time."""
        deadline = time.monotonic() + patience
        while not condition() and time.monotonic() < deadline and not rospy.is_shutdown():
            rospy.rostime.wallsleep(_LOOK)
        return condition()

    def _hear_state(self, message: NavigationStatus) -> None:
        self._states[message.robot] = message

    def _hear_schedule(self, message: Schedule) -> None:
        self._schedules[message.robot] = message


def _is_over(client: actionlib.SimpleActionClient) -> bool:
    return client.get_state() not in (GoalStatus.PENDING, GoalStatus.ACTIVE)
