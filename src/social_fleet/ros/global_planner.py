"""A global planner in nav_core's manner, for those who stay in Python."""

import threading
from typing import Any, List, Optional

import rospy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path

from social_fleet.errors import NotReady
from social_fleet.srv import PlanPath, PlanPathRequest, PlanPathResponse

_WARNING_PERIOD = 5.0  # [s, ROS time] between two warnings


class SocialGlobalPlanner:
    """Asks the node social_planner, and stops waiting when it takes too long; what the C++ plugin is to move_base.

    Publishers
        ~NAME/plan (nav_msgs/Path): the last plan.
    Parameters
        Below ~NAME: server, robot, planner_patience, default_tolerance and start_tolerance, as in
        config/social_global_planner.yaml.
    """

    def __init__(self) -> None:
        self._plan: Optional[rospy.Publisher] = None
        self._goal: Optional[PoseStamped] = None

    def initialize(self, name: str = "SocialGlobalPlanner") -> None:
        """Read the parameters below ~`name` and begin to publish; a node must run."""
        self._server = rospy.get_param(f"~{name}/server", "social_planner")
        self._robot = rospy.get_param(f"~{name}/robot", "")
        self._patience = float(rospy.get_param(f"~{name}/planner_patience", 5.0))
        self._tolerance = float(rospy.get_param(f"~{name}/default_tolerance", 0.0))
        self._start_tolerance = float(rospy.get_param(f"~{name}/start_tolerance", 0.3))
        self._plan = rospy.Publisher(f"~{name}/plan", Path, queue_size=1)

    def make_plan(self, start: PoseStamped, goal: PoseStamped, tolerance: Optional[float] = None) -> List[PoseStamped]:
        """The path's poses, none where there is no path or no answer in time; the log says why.

        Parameters
        ----------
        start, goal
            In the map's frame; an empty frame of `start` means where the robot is.
        tolerance
            How far from the goal the path may end [m]; None: the parameter default_tolerance.

        Raises
        ------
        NotReady
            Before `initialize`.
        """
        if self._plan is None:
            raise NotReady("initialize the planner before it is to plan")
        known = self._goal is not None and self._goal.pose == goal.pose  # planned before: the fleet was told
        self._goal = goal
        request = PlanPathRequest(robot=self._robot, start=start, goal=goal, inquiry=known,
                                  tolerance=self._tolerance if tolerance is None else tolerance,
                                  start_tolerance=self._start_tolerance)
        answer = _Call(f"{self._server}/plan_path", request).wait(self._patience)
        if answer is None:
            rospy.logwarn_throttle(_WARNING_PERIOD, f"no path from {rospy.resolve_name(self._server)}: it is not "
                                                    f"there, or did not answer within {self._patience:g} s")
            return []
        if answer.status != PlanPathResponse.SUCCESS:
            rospy.logwarn_throttle(_WARNING_PERIOD, f"the social planner has no path: {answer.message}")
        self._plan.publish(answer.path)
        return list(answer.path.poses)


class _Call:
    """One service call in a thread, since rospy's know no time limit; its connection is cut when nobody waits."""

    def __init__(self, name: str, request: PlanPathRequest) -> None:
        self._proxy = rospy.ServiceProxy(name, PlanPath, persistent=True)
        self._request = request
        self._answer: Any = None
        self._thread = threading.Thread(target=self._run, name=f"call of {name}", daemon=True)
        self._thread.start()

    def wait(self, patience: float) -> Optional[PlanPathResponse]:
        """The answer, None when none comes within `patience` [s]."""
        self._thread.join(patience)
        answer = self._answer
        self._proxy.close()
        return answer

    def _run(self) -> None:
        try:
            self._answer = self._proxy(self._request)
        except (rospy.ServiceException, rospy.ROSException, OSError, AttributeError) as error:
            # Not there, died, or cut, which takes the connection away while it is in use.
            rospy.logdebug("%s", error)
