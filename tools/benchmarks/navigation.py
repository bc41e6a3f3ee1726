"""What the benchmarks of the ROS navigation stack share: launch files that run, simulated robots to send about."""

import math
import multiprocessing
import sys
import time
from contextlib import contextmanager
from typing import Any, Callable, Dict, Iterator, List, Sequence, Tuple

import numpy as np

from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import random_pose_pairs

from .processes import LIMIT, ros_master, running, wait_for
from .worlds import planner

PATIENCE = 120.0  # [s] of wall time for one drive


def apart(work: Callable[[], bool]) -> bool:
    """Whether `work` says that all holds; in a process of its own, for rospy knows one master in its life."""
    process = multiprocessing.get_context("fork").Process(target=lambda: sys.exit(0 if work() else 1))
    process.start()
    process.join()
    return process.exitcode == 0


@contextmanager
def launched(file: str, **arguments: Any) -> Iterator[None]:
    """A launch file of the package with a master of its own, and this process as a node."""
    import rospy
    given = [f"{name}:={value}" for name, value in arguments.items()]
    with ros_master(), running("roslaunch", "--wait", "--skip-log-check", "social_fleet", file, *given):
        rospy.init_node("benchmark", disable_signals=True)
        yield


def tour(name: str, count: int, nearest: float, farthest: float) -> List[Tuple[float, float]]:
    """A start and `count` goals on a map, with some room about them, `nearest` to `farthest` metres of path apart."""
    roomy = SocialPlanner(planner(name).grid, PlannerConfig(robot_radius=0.45))
    stops: List[Tuple[float, float]] = []
    for pair in random_pose_pairs(roomy, 300, seed=7):
        for place in pair:
            point = (round(float(place[0]), 2), round(float(place[1]), 2))
            apart = not any(math.dist(point, stop) < 2.0 for stop in stops)
            if not stops or apart and nearest <= planner(name).plan(stops[-1], point).length <= farthest:
                stops.append(point)
                if len(stops) > count:
                    return stops
    raise RuntimeError(f"{name} has no tour of {count} goals")


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


class Trackers:
    """Sends the robots of a fleet on one schedule."""

    def __init__(self, robots: Sequence[str]) -> None:
        import rospy

        from social_fleet.msg import Progress
        from social_fleet.srv import Coordinate, PlanPath
        self._robots = robots
        self._news: Dict[str, Any] = {}
        rospy.Subscriber("fleet/progress", Progress, self._hear, queue_size=100)
        for name in ("social_planner/plan_path", "fleet_coordinator/coordinate"):
            rospy.wait_for_service(name, LIMIT)
        self._plan = rospy.ServiceProxy("social_planner/plan_path", PlanPath)
        self._coordinate = rospy.ServiceProxy("fleet_coordinator/coordinate", Coordinate)
        wait_for(lambda: set(self._news) >= set(robots))

    def send(self, goals: Dict[str, Sequence[float]]) -> str:
        """Let all of them drive; ``arrived``, or what became of it."""
        from social_fleet.msg import PlannedPath
        from social_fleet.srv import CoordinateRequest, PlanPathRequest
        paths = []
        for robot, goal in goals.items():
            request = PlanPathRequest(robot=robot, goal=stamped(goal), start_tolerance=0.3)
            answer: List[Any] = []
            wait_for(lambda: answer.append(self._plan(request)) or not answer[-1].status)
            paths.append(PlannedPath(header=answer[-1].path.header, robot=robot, path=answer[-1].path, max_speed=0.7,
                                     radius=0.25))
        answer = self._coordinate(CoordinateRequest(planning=paths))
        if answer.status:
            return f"no schedule: {answer.message}"
        versions = {schedule.robot: schedule.version for schedule in answer.schedules}
        deadline = time.monotonic() + 3.0 * PATIENCE
        while time.monotonic() < deadline:
            news = [self._news[robot] for robot in goals]
            if all(item.state == item.ARRIVED and item.schedule_version == versions[item.robot] for item in news):
                return "arrived"
            time.sleep(0.05)
        return "not arrived: " + ", ".join(f"{item.robot} in state {item.state}" for item in news)

    def _hear(self, message: Any) -> None:
        self._news[message.robot] = message


class Localisation:
    """What tf tells of robots beside where they truly are."""

    def __init__(self, robots: Sequence[str]) -> None:
        import rospy
        import tf2_ros
        from geometry_msgs.msg import PoseArray
        self._robots = list(robots)
        self._truth: Dict[float, np.ndarray] = {}  # positions (N, 2) by time [s]
        self._told: Dict[str, Dict[float, Tuple[float, float]]] = {robot: {} for robot in robots}
        self.largest_after = 0.0  # [m] of driving came the largest of the errors that were asked for last
        self._buffer = tf2_ros.Buffer(debug=False)
        self._listener = tf2_ros.TransformListener(self._buffer)
        rospy.Subscriber("fleet/ground_truth", PoseArray, self._hear, queue_size=1000)
        self._timer = rospy.Timer(rospy.Duration(0.1), self._look)

    def errors(self, robot: str, driven: float) -> np.ndarray:
        """Distances between what tf told and the truth [m] from so many metres of driving on."""
        index = self._robots.index(robot)
        told = dict(self._told[robot])
        times = sorted(time_ for time_ in told if time_ in self._truth)
        truth = np.array([self._truth[time_][index] for time_ in times])
        gaps = np.hypot(*(np.array([told[time_] for time_ in times]) - truth).T)
        way = np.append(0.0, np.cumsum(np.hypot(*np.diff(truth, axis=0).T)))
        self.largest_after = float(way[way >= driven][gaps[way >= driven].argmax()])
        return gaps[way >= driven]

    def fitted(self, robot: str) -> Callable[[np.ndarray], np.ndarray]:
        """From the world to the map that tf tells of: the turn and shift that fit the robot's track best."""
        index, told = self._robots.index(robot), dict(self._told[robot])
        times = sorted(time_ for time_ in told if time_ in self._truth)
        truth = np.array([self._truth[time_][index] for time_ in times])
        found = np.array([told[time_] for time_ in times])
        centres = truth.mean(axis=0), found.mean(axis=0)
        left, _, right = np.linalg.svd((truth - centres[0]).T @ (found - centres[1]))
        turn = (left @ right).T
        return lambda place: turn @ (place - centres[0]) + centres[1]

    def driven(self, robot: str) -> float:
        """How far it has come [m]."""
        track = self._track()[:, self._robots.index(robot)]
        return float(np.hypot(*np.diff(track, axis=0).T).sum())

    def smallest_gap(self) -> float:
        """Between the centres of any two robots at any time [m]."""
        track = self._track()
        return min(float(np.hypot(*(track[:, one] - track[:, other]).T).min())
                   for one in range(track.shape[1]) for other in range(one))

    def _track(self) -> np.ndarray:
        truth = dict(self._truth)
        return np.array([truth[time_] for time_ in sorted(truth)])

    def _hear(self, message: Any) -> None:
        self._truth[round(message.header.stamp.to_sec(), 3)] = np.array(
            [(pose.position.x, pose.position.y) for pose in message.poses])

    def _look(self, _: Any) -> None:
        import rospy
        import tf2_ros
        for robot in self._robots:
            try:
                transform = self._buffer.lookup_transform("map", f"{robot}/base_link", rospy.Time())
            except tf2_ros.TransformException:
                continue
            place = transform.transform.translation
            self._told[robot][round(transform.header.stamp.to_sec(), 3)] = (place.x, place.y)


def stamped(place: Sequence[float]) -> Any:
    """A pose in the map: x, y and maybe yaw."""
    from geometry_msgs.msg import PoseStamped
    pose = PoseStamped()
    pose.header.frame_id = "map"
    pose.pose.position.x, pose.pose.position.y = place[:2]
    yaw = place[2] if len(place) > 2 else 0.0
    pose.pose.orientation.z, pose.pose.orientation.w = math.sin(0.5 * yaw), math.cos(0.5 * yaw)
    return pose
