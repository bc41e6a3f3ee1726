"""How goals reach a robot: the action move_base and the topic move_base_simple/goal, as move_base has them."""

from typing import Callable, Optional

import actionlib
import genpy
import rospy
from geometry_msgs.msg import PoseStamped
from move_base_msgs.msg import MoveBaseAction, MoveBaseActionGoal, MoveBaseFeedback, MoveBaseGoal, MoveBaseResult
from std_msgs.msg import Header

from social_fleet.geometry import Pose
from social_fleet.ros import conversions


class GoalServer:
    """One goal at a time; a new one takes the place of the one before, whose client is told so.

    All but the constructor belongs to one thread, which `woken` wakes: actionlib calls back under its own locks.

    Parameters
    ----------
    woken : callable
        Called when there is something to look at.

    Subscribers
        move_base_simple/goal (geometry_msgs/PoseStamped).
    Actions
        move_base (move_base_msgs/MoveBaseAction).
    """

    def __init__(self, woken: Callable[[], None]) -> None:
        self._woken = woken
        self._server = actionlib.SimpleActionServer("move_base", MoveBaseAction, auto_start=False)
        self._server.register_goal_callback(woken)
        self._server.register_preempt_callback(woken)
        self._goals = rospy.Publisher("move_base/goal", MoveBaseActionGoal, queue_size=10)
        self._server.start()
        rospy.Subscriber("move_base_simple/goal", PoseStamped, self._hear_simple, queue_size=10)

    def _hear_simple(self, message: PoseStamped) -> None:
        """A goal without a client becomes one of the action, where all can see it."""
        self._goals.publish(MoveBaseActionGoal(header=Header(stamp=rospy.Time.now()), goal=MoveBaseGoal(message)))

    def take(self) -> Optional[PoseStamped]:
        """The goal that came last, once; None when there is no new one."""
        if not self._server.is_new_goal_available():
            return None
        target: PoseStamped = self._server.accept_new_goal().target_pose
        return target

    @property
    def taken_back(self) -> bool:
        """Whether the client wants its goal no more."""
        return self._server.is_active() and self._server.is_preempt_requested() \
            and not self._server.is_new_goal_available()

    def tell(self, pose: Pose, frame: str, stamp: genpy.Time) -> None:
        """Feedback: where the robot is."""
        if self._server.is_active():
            self._server.publish_feedback(MoveBaseFeedback(conversions.pose_to_stamped(pose, frame, stamp)))

    def succeed(self, text: str) -> None:
        """The robot stands at the goal."""
        if self._server.is_active():
            self._server.set_succeeded(MoveBaseResult(), text)

    def abort(self, text: str) -> None:
        """The goal is given up; `text` says why."""
        if self._server.is_active():
            self._server.set_aborted(MoveBaseResult(), text)

    def cancel(self, text: str) -> None:
        """The goal was taken back."""
        if self._server.is_active():
            self._server.set_preempted(MoveBaseResult(), text)
