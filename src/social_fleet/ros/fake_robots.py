"""The node fake_robots: the simulated fleet, in lock-step with its trackers."""

import math
import threading
import time
from dataclasses import dataclass, replace
from typing import Any, Dict, List, Mapping, Optional, Sequence, Set, Tuple

import genpy
import numpy as np
import rospy
from nav_msgs.msg import OccupancyGrid as GridMessage
from rospy.numpy_msg import numpy_msg
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64

from social_fleet.coordination.robot import Robot
from social_fleet.errors import InvalidInput, InvalidParameter
from social_fleet.geometry import Pose
from social_fleet.msg import Schedule
from social_fleet.parameters import from_mapping, parameter
from social_fleet.ros import conversions, parameters
from social_fleet.ros.fake_robot_topics import FleetTopics, RobotTopics
from social_fleet.ros.paths import resolve_path
from social_fleet.scenario.files import Scenario, load_scenario
from social_fleet.simulation.config import LidarConfig, SimulationConfig
from social_fleet.simulation.faults import CircleObstacle, Fault, pose_shift, speed_share
from social_fleet.simulation.lidar import Lidar
from social_fleet.simulation.world import World

EPOCH = 1  # simulated time begins here [s]: 0 means unset in ROS


@dataclass(frozen=True)
class FakeRobotsParameters:
    """Parameters of the node; all others in its namespace are those of `SimulationConfig`, `lidar` and `robots`."""

    map_frame: str = "map"
    scenario: str = ""  # a scenario file whose robots, faults and obstacles are simulated beside `robots`
    keep_time: bool = True  # publish /clock; otherwise follow the time of others
    localise: bool = True  # tell where the robots are in the map; otherwise that is left to AMCL or the like
    real_time_factor: float = parameter(1.0, minimum=0.0)  # simulated over wall time; 0: as fast as trackers answer
    answer_timeout: float = parameter(0.5, above=0.0)  # longest wait for a tracker that answered before [s, wall time]
    clock_rate: float = parameter(10.0, above=0.0)  # of /clock [Hz]: every node pays for it; odometry has every tick
    tf_rate: float = parameter(10.0, above=0.0)  # [Hz]
    scan_rate: float = parameter(5.0, above=0.0)  # [Hz], while somebody listens
    pose_rate: float = parameter(2.0, above=0.0)  # of amcl_pose [Hz]


@dataclass(frozen=True)
class FakeRobotParameters:
    """One robot of the parameter `robots`."""

    start: Tuple[float, ...]  # x, y and yaw [m, m, rad, map frame]
    radius: float = parameter(0.25, above=0.0)  # [m]
    max_speed: float = parameter(0.7, above=0.0)  # [m/s]

    def __post_init__(self) -> None:
        if len(self.start) not in (2, 3):
            raise InvalidParameter(f"must be x, y and yaw, not {list(self.start)}", field="start")


class FakeRobots:
    """Simulates robots tick by tick; each tick waits for the trackers that keep up.

    Subscribers
        ROBOT/cmd_vel (geometry_msgs/Twist).
        map (nav_msgs/OccupancyGrid): what lidars see.
        ~real_time_factor (std_msgs/Float64): goes before the parameter from now on.
    Publishers
        ROBOT/odom (nav_msgs/Odometry), ROBOT/scan (sensor_msgs/LaserScan),
        tf ROBOT/odom -> ROBOT/base_link; map -> ROBOT/odom and ROBOT/amcl_pose
        (geometry_msgs/PoseWithCovarianceStamped) where it localises them,
        /clock when it keeps the time, fleet/ground_truth (geometry_msgs/PoseArray): true poses in the robots' order.
    Parameters
        `FakeRobotsParameters`; those of `SimulationConfig`, see config/fake_robots.yaml; `lidar`, a mapping of those of
        `LidarConfig`; `robots`, a mapping of names to `FakeRobotParameters`.
    """

    def __init__(self) -> None:
        self._config, others = parameters.split_private(FakeRobotsParameters)
        prefix = parameters.private_prefix()
        robots = _listed(others.pop("robots", {}), prefix)
        lidar = LidarConfig.from_mapping(others.pop("lidar", {}), prefix=f"{prefix}lidar/")
        self._faults: Sequence[Fault] = ()
        self._obstacles: Sequence[CircleObstacle] = ()
        self._time_zero: Optional[float] = None
        if self._config.scenario:
            scenario = load_scenario(resolve_path(self._config.scenario))
            others = {**others, **scenario.simulation}
            robots += self._from_scenario(scenario)
        simulation = SimulationConfig.from_mapping(others, prefix=prefix)
        if not robots:
            raise InvalidParameter("lists no robot; name robots or a scenario file", field=f"{prefix}robots")
        self._world = World(robots, config=simulation)
        self._lidar = Lidar(lidar, seed=simulation.seed)
        self._factor = self._config.real_time_factor
        self._answered = threading.Condition()
        self._prompt: Set[str] = set()  # robots whose tracker answered lately: worth waiting for
        self._awaited: Set[str] = set()  # those whose answer to this tick is out
        self._clock = rospy.Publisher("/clock", Clock, queue_size=1) if self._config.keep_time else None
        self._fleet = FleetTopics(self._config.map_frame)
        self._robots: Dict[str, RobotTopics] = {
            name: RobotTopics(robot, self._hear_command) for name, robot in self._world.robots.items()}
        rospy.Subscriber("map", numpy_msg(GridMessage), self._hear_map, queue_size=1)
        rospy.Subscriber("~real_time_factor", Float64, self._hear_factor, queue_size=1)
        rospy.Subscriber("fleet/schedules", Schedule, self._hear_schedule, queue_size=10)

    def _from_scenario(self, scenario: Scenario) -> List[Robot]:
        self._faults, self._obstacles = scenario.faults, scenario.obstacles
        return [parked_robot(spec.name, spec.start, spec) for spec in scenario.robots]

    def _hear_command(self, name: str, speed: float, turn_rate: float) -> None:
        with self._answered:
            self._world.robots[name].command(speed, turn_rate)
            self._prompt.add(name)
            self._awaited.discard(name)
            if not self._awaited:
                self._answered.notify()

    def _hear_map(self, message: GridMessage) -> None:
        try:
            self._world.grid = conversions.grid_from_message(message)
        except InvalidInput as error:
            rospy.logerr("the map cannot be used: %s", error)

    def _hear_factor(self, message: Float64) -> None:
        if not message.data >= 0.0:
            rospy.logerr("the real time factor must be zero or more, not %s", message.data)
            return
        self._factor = message.data

    def _hear_schedule(self, message: Schedule) -> None:
        """Times of faults and obstacles count from the first schedule's time zero."""
        if self._time_zero is None:
            self._time_zero = message.header.stamp.to_sec()

    def spin(self) -> int:
        """Simulate until shutdown."""
        period = self._world.clock.period
        due = time.monotonic()
        rate = None if self._config.keep_time else rospy.Rate(1.0 / period)
        while not rospy.is_shutdown():
            stamp = self._now(rate)
            with self._answered:
                self._prompt = {name for name in self._prompt if self._robots[name].is_commanded}
                self._awaited = set(self._prompt)
            self._publish(stamp)
            self._await_answers()
            due = self._keep_pace(due)
            with self._answered:
                self._befall(stamp)
                self._world.step()
        return 0

    def _now(self, rate: Optional[rospy.Rate]) -> genpy.Time:
        """The time of this tick: its own, or that of others."""
        if rate is not None:
            rate.sleep()
            return rospy.Time.now()
        nanoseconds = round(self._world.now * 1e9)
        return rospy.Time(EPOCH + nanoseconds // 10**9, nanoseconds % 10**9)

    def _publish(self, stamp: genpy.Time) -> None:
        """All that this tick has to say; odometry last, because trackers answer it."""
        if self._clock is not None and self._due(self._config.clock_rate):
            self._clock.publish(Clock(stamp))
        if self._due(self._config.tf_rate):
            for name, topics in self._robots.items():
                topics.estimate = self._localise(name, stamp) if self._config.localise else None
            self._fleet.publish_transforms(stamp, self._robots.values())
        if self._due(self._config.pose_rate):
            for topics in self._robots.values():
                topics.publish_pose(stamp, self._config.map_frame)
        if self._due(self._config.scan_rate) and self._world.grid is not None:
            for name, topics in self._robots.items():
                if topics.scan_is_wanted:
                    topics.publish_scan(stamp, self._world.scan(name, self._lidar), self._lidar.config,
                                        1.0 / self._config.scan_rate)
        self._fleet.publish_truth(stamp, [robot.pose for robot in self._world.robots.values()])
        for topics in self._robots.values():
            topics.publish_odometry(stamp)

    def _localise(self, name: str, stamp: genpy.Time) -> Optional[Pose]:
        """Where localisation has a robot; None while it does not know."""
        pose = self._world.localise(name)
        now = -math.inf if self._time_zero is None else stamp.to_sec() - self._time_zero
        for fault in self._faults:
            if pose is None or fault.robot != name or not fault.active(now):
                continue
            if fault.kind == "lost":
                return None
            dx, dy = pose_shift(fault, now)
            pose = Pose(pose.x + dx, pose.y + dy, pose.yaw)
        return pose

    def _due(self, rate: float) -> bool:
        """Whether something that happens `rate` times a second happens in this tick."""
        clock = self._world.clock
        return clock.tick % max(1, round(1.0 / (rate * clock.period))) == 0

    def _await_answers(self) -> None:
        """Let trackers that answered before answer this tick; who does not is not waited for again until it does."""
        if self._clock is None:
            return
        with self._answered:
            if not self._answered.wait_for(lambda: not self._awaited, self._config.answer_timeout):
                self._prompt -= self._awaited
                rospy.logwarn_throttle(10.0, "no command within %g s for: %s" % (
                    self._config.answer_timeout, ", ".join(sorted(self._awaited))))

    def _keep_pace(self, due: float) -> float:
        """Sleep until wall time has caught up with simulated time; when the next tick is due.

        As fast as the trackers answer means real time while there is none.
        """
        now = time.monotonic()
        factor = self._factor or (0.0 if self._prompt else 1.0)
        if self._clock is None or factor == 0.0:
            return now
        due += self._world.clock.period / factor
        if due > now:
            rospy.rostime.wallsleep(due - now)
        return max(due, now - 1.0)

    def _befall(self, stamp: genpy.Time) -> None:
        """Let faults and obstacles take effect."""
        if self._time_zero is None or not (self._faults or self._obstacles):
            return
        now = stamp.to_sec() - self._time_zero
        for name, robot in self._world.robots.items():
            robot.speed_share = speed_share(self._faults, name, now)
        self._world.obstacles = tuple(replace(obstacle, appears=0.0, disappears=math.inf)
                                      for obstacle in self._obstacles if obstacle.present(now))


def parked_robot(name: str, start: Sequence[float], values: Any) -> Robot:
    """A robot that stands at `start`, with the limits that are attributes of `values` and not None."""
    limits = {key: getattr(values, key) for key in ("max_acceleration", "max_turn_rate", "max_turn_acceleration")
              if getattr(values, key, None) is not None}
    return Robot(name, np.array([start[:2]]), values.max_speed, values.radius,
                 start_yaw=start[2] if len(start) > 2 else 0.0, **limits)


def _listed(given: Any, prefix: str) -> List[Robot]:
    """The robots of the parameter `robots`."""
    if not isinstance(given, Mapping):
        raise InvalidParameter(f"must be a mapping of robots' names to their values, not {given!r}",
                               field=f"{prefix}robots")
    robots = []
    for name, values in given.items():
        entry = from_mapping(FakeRobotParameters, values, prefix=f"{prefix}robots/{name}/")
        robots.append(parked_robot(name, entry.start, entry))
    return robots
