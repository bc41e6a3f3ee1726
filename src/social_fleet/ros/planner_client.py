"""What a navigator asks of the planner."""

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
import rospy

from social_fleet.errors import SocialFleetError
from social_fleet.srv import PlanPath, PlanPathRequest, PlanPathResponse

_PRESENCE = 1.0  # that the service is waited for [s, wall time]
_HOPELESS = (PlanPathResponse.INVALID_GOAL, PlanPathResponse.NO_PATH_FOUND, PlanPathResponse.INVALID_REQUEST,
             PlanPathResponse.TF_ERROR)


class NoAnswer(SocialFleetError):
    """A path that is not to be had.

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


class PlannerClient:
    """Asks for paths that nobody is going to drive; may be used from any thread.

    Parameters
    ----------
    robot
        The robot's name.

    Services called
        social_planner/plan_path (PlanPath).
    """

    def __init__(self, robot: str) -> None:
        self._robot = robot
        self._plan = rospy.ServiceProxy("social_planner/plan_path", PlanPath)

    def path(self, start: PoseStamped, goal: PoseStamped, tolerance: float = 0.0) -> Path:
        """From `start` to `goal`; raises NoAnswer."""
        request = PlanPathRequest(robot=self._robot, start=start, goal=goal, tolerance=tolerance, inquiry=True)
        try:
            rospy.wait_for_service(self._plan.resolved_name, _PRESENCE)
            answer = self._plan(request)
        except (rospy.ROSException, rospy.ServiceException) as error:
            raise NoAnswer(f"the planner does not answer: {error}") from error
        if answer.status != PlanPathResponse.SUCCESS:
            raise NoAnswer(f"no path: {answer.message}", final=answer.status in _HOPELESS)
        path: Path = answer.path
        return path
