"""What the benchmarks of the ROS navigation stack share: launch files that run, and a simulated robot to send about."""

import math
import time
from contextlib import contextmanager
from typing import Any, Iterator, List, Sequence, Tuple

import numpy as np

from social_fleet.mapping.clearance import ConfigurationSpace

from .processes import LIMIT, ros_master, running, wait_for

PATIENCE = 120.0  # [s] of wall time for one drive


@contextmanager
def launched(file: str, **arguments: Any) -> Iterator[None]:
    """A launch file of the package with a master of its own, and this process as a node."""
    import rospy
    given = [f"{name}:={value}" for name, value in arguments.items()]
    with ros_master(), running("roslaunch", "--wait", "--skip-log-check", "social_fleet", file, *given):
        rospy.init_node("benchmark", disable_signals=True)
        yield


class Robot:
    """A simulated robot with a move_base of its own."""

    def __init__(self, name: str) -> None:
        import actionlib
        import rospy
        from geometry_msgs.msg import PoseArray
        from move_base_msgs.msg import MoveBaseAction
        from nav_msgs.msg import Path
        self.name = name
        self.plans = 0
        self.track: List[Tuple[float, float]] = []
        rospy.Subscriber("fleet/ground_truth", PoseArray, self._hear, queue_size=10)
        rospy.Subscriber(f"{name}/move_base/SocialGlobalPlanner/plan", Path, self._hear_plan, queue_size=10)
        self._client = actionlib.SimpleActionClient(f"{name}/move_base", MoveBaseAction)
        if not self._client.wait_for_server(rospy.Duration(LIMIT)):
            raise TimeoutError("move_base does not start")
        wait_for(lambda: bool(self.track))

    @property
    def position(self) -> Tuple[float, float]:
        """Where it truly is [m]."""
        return self.track[-1]

    def await_plan(self, goal: Sequence[float]) -> None:
        """Return once the plugin plans to the goal: map, costmap and planner are there."""
        import rospy
        from geometry_msgs.msg import PoseStamped
        from nav_msgs.srv import GetPlan
        name = f"{self.name}/move_base/SocialGlobalPlanner/make_plan"
        rospy.wait_for_service(name, LIMIT)
        call = rospy.ServiceProxy(name, GetPlan)
        wait_for(lambda: bool(call(PoseStamped(), stamped(goal), 0.0).plan.poses))
        time.sleep(3.0)  # the planner prepares itself for being fast

    def go(self, goal: Sequence[float]) -> str:
        """Send it there and wait until it arrives or gives up; what move_base said."""
        from move_base_msgs.msg import MoveBaseGoal
        self._client.send_goal(MoveBaseGoal(target_pose=stamped(goal)))
        deadline = time.monotonic() + PATIENCE
        while self._client.get_state() in (0, 1) and time.monotonic() < deadline:
            time.sleep(0.05)
        return self._client.get_goal_status_text() or "still under way"

    def smallest_gap(self, space: ConfigurationSpace) -> float:
        """The smallest distance of its centre to a wall of the map on all its way [m], to the cell."""
        cells = space.grid.cells(np.array(self.track))
        return float(space.clearance[cells[:, 0], cells[:, 1]].min())

    def _hear(self, message: Any) -> None:
        place = message.poses[0].position
        if not self.track or math.dist(self.track[-1], (place.x, place.y)) > 0.01:
            self.track.append((place.x, place.y))

    def _hear_plan(self, message: Any) -> None:
        self.plans += bool(message.poses)


def stamped(place: Sequence[float]) -> Any:
    """A pose in the map: x, y and maybe yaw."""
    from geometry_msgs.msg import PoseStamped
    pose = PoseStamped()
    pose.header.frame_id = "map"
    pose.pose.position.x, pose.pose.position.y = place[:2]
    yaw = place[2] if len(place) > 2 else 0.0
    pose.pose.orientation.z, pose.pose.orientation.w = math.sin(0.5 * yaw), math.cos(0.5 * yaw)
    return pose
