"""What rostests share: waiting with a deadline, worlds drawn as text, requests."""

import os
import signal
import time
from typing import Any, Callable, List, Sequence, TypeVar
from xmlrpc.client import ServerProxy

import numpy as np
import rosgraph
import rospy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid

from social_fleet.geometry import Pose
from social_fleet.mapping.grid import OccupancyGrid as Grid
from social_fleet.msg import PlannedPath
from social_fleet.ros import conversions

T = TypeVar("T")
DEADLINE = 30.0  # [s] of wall time


def wait_until(condition: Callable[[], T], what: str, deadline: float = DEADLINE) -> T:
    """The first true value of `condition`; fails when there is none in time."""
    end = time.monotonic() + deadline
    while not rospy.is_shutdown():
        value = condition()
        if value:
            return value
        if time.monotonic() > end:
            raise AssertionError(f"waited {deadline:g} s in vain for {what}")
        rospy.rostime.wallsleep(0.02)
    raise AssertionError(f"shut down while waiting for {what}")


def service(name: str, kind: Any) -> rospy.ServiceProxy:
    """A service that is up."""
    rospy.wait_for_service(name, DEADLINE)
    return rospy.ServiceProxy(name, kind)


def kill(node: str) -> None:
    """End a node without a chance to say goodbye, and wait until it is gone."""
    pid = ServerProxy(rosgraph.Master(rospy.get_name()).lookupNode(node)).getPid(rospy.get_name())[2]
    os.kill(pid, signal.SIGKILL)
    wait_until(lambda: not os.path.exists(f"/proc/{pid}") or _is_zombie(pid), f"{node} to end")


def _is_zombie(pid: int) -> bool:
    with open(f"/proc/{pid}/stat", encoding="ascii") as stream:
        return stream.read().rsplit(")", 1)[1].split()[0] == "Z"


class Listener:
    """Keeps the messages of a topic."""

    def __init__(self, topic: str, kind: Any) -> None:
        self.messages: List[Any] = []
        self._subscriber = rospy.Subscriber(topic, kind, self.messages.append, queue_size=1000)

    def wait(self, count: int = 1) -> Any:
        """The last message, once there are `count`."""
        wait_until(lambda: len(self.messages) >= count, f"{count} messages on {self._subscriber.resolved_name}")
        return self.messages[-1]

    def close(self) -> None:
        """Leave the topic: only then is the next listener of this process a new subscriber."""
        self._subscriber.unregister()


def drawn(rows: Sequence[str], resolution: float) -> OccupancyGrid:
    """A map from text, the top row first: '#' wall, '?' unknown, all else free."""
    values = {"#": 100, "?": -1}
    cells = np.array([[values.get(letter, 0) for letter in row] for row in reversed(rows)], dtype=np.int8)
    return conversions.grid_to_message(Grid(cells, resolution), "map", rospy.Time.now())


def stamped(x: float, y: float, yaw: float = 0.0, frame: str = "map") -> PoseStamped:
    """A pose with its frame."""
    return conversions.pose_to_stamped(Pose(x, y, yaw), frame)


def planned(name: str, points: Sequence[Sequence[float]], **values: Any) -> PlannedPath:
    """A robot's path as a request to coordinate holds it."""
    message = PlannedPath(robot=name, max_speed=0.7, radius=0.25)
    message.header.frame_id = "map"
    message.path = conversions.path_to_message(np.array(points, dtype=float), None, "map", rospy.Time.now())
    for key, value in values.items():
        setattr(message, key, value)
    return message
