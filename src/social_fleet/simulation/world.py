"""Several robots in one place, moved together tick by tick."""

from typing import Dict, List, Mapping, Optional, Sequence

import numpy as np

from social_fleet.coordination.robot import Robot
from social_fleet.errors import InvalidScenario
from social_fleet.geometry import Pose
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.simulation.clock import TickClock
from social_fleet.simulation.config import SimulationConfig
from social_fleet.simulation.faults import DISPATCHER, CircleObstacle, Fault, active, pose_shift, speed_share
from social_fleet.simulation.lidar import Lidar
from social_fleet.simulation.localisation import Localisation
from social_fleet.simulation.robot import DifferentialDriveRobot


class World:
    """Simulated robots on a map, with obstacles and faults.

    Parameters
    ----------
    robots : sequence of Robot
        Each stands at its start at first.
    grid : OccupancyGrid, optional
        The map, which only lidars see; robots pass through walls, and the report says so.
    obstacles : sequence of CircleObstacle
        Discs that appear and disappear.
    faults : sequence of Fault
        What befalls the robots.
    config : SimulationConfig
        Period, noise, seed.

    Raises
    ------
    InvalidScenario
        When two robots have one name, or a fault names a robot that is not there.
    """

    def __init__(self, robots: Sequence[Robot], grid: Optional[OccupancyGrid] = None, *,
                 obstacles: Sequence[CircleObstacle] = (), faults: Sequence[Fault] = (),
                 config: SimulationConfig = SimulationConfig()) -> None:
        self.grid = grid
        self.obstacles = tuple(obstacles)
        self.clock = TickClock(config.period)
        self.robots: Dict[str, DifferentialDriveRobot] = {}
        for robot in robots:
            if robot.name in self.robots:
                raise InvalidScenario(f"two robots are named {robot.name}; give each its own name", field="robots")
            self.robots[robot.name] = DifferentialDriveRobot(
                robot.name, robot.start, radius=robot.body_radius, limits=robot.limits,
                odometry_noise=config.odometry_noise, seed=config.seed, command_timeout=config.command_timeout)
        self._localisations = {name: Localisation(config.position_error, config.heading_error, seed=config.seed,
                                                  name=name) for name in self.robots}
        self._faults: Dict[str, List[Fault]] = {}
        for fault in faults:
            if fault.robot not in self.robots and fault.robot != DISPATCHER:
                raise InvalidScenario(f"there is no robot {fault.robot}; known are {', '.join(self.robots)}",
                                      field="faults")
            self._faults.setdefault(fault.robot, []).append(fault)

    @property
    def now(self) -> float:
        """Present time [s]."""
        return self.clock.now

    def command(self, commands: Mapping[str, Sequence[float]]) -> None:
        """Give robots, by name, the (speed, turn rate) to strive for."""
        for name, (speed, turn_rate) in commands.items():
            self.robots[name].command(speed, turn_rate)

    def step(self) -> float:
        """Let one period pass; the new time [s]."""
        for name, faults in self._faults.items():
            if name in self.robots:
                self.robots[name].speed_share = speed_share(faults, name, self.clock.now)
        for robot in self.robots.values():
            robot.step(self.clock.period)
        return self.clock.advance()

    def localise(self, name: str) -> Optional[Pose]:
        """Where robot `name` takes itself to be [m, rad, map frame], None when it does not know; ask once per period.
        """
        pose = self._localisations[name].estimate(self.robots[name].pose, self.clock.period)
        for fault in self._faults.get(name, ()):
            if fault.kind == "lost" and fault.active(self.clock.now):
                return None
            dx, dy = pose_shift(fault, self.clock.now)
            pose = Pose(pose.x + dx, pose.y + dy, pose.yaw) if dx or dy else pose
        return pose

    def befalls(self, name: str, *kinds: str) -> bool:
        """Whether a fault of these kinds befalls the robot, or the dispatcher, now."""
        return name in self._faults and active(self._faults[name], self.clock.now, *kinds)

    def poses(self) -> np.ndarray:
        """True poses [m, rad, map frame], shape (R, 3), in the robots' order."""
        return np.array([robot.pose for robot in self.robots.values()])

    def present_obstacles(self) -> List[CircleObstacle]:
        """The obstacles that are there now."""
        return [obstacle for obstacle in self.obstacles if obstacle.present(self.clock.now)]

    def scan(self, name: str, lidar: Lidar) -> np.ndarray:
        """What `lidar` at the centre of robot `name` sees: walls, obstacles and the other robots' discs [m].

        Raises
        ------
        InvalidScenario
            When the world has no map.
        """
        if self.grid is None:
            raise InvalidScenario("a lidar needs a world with a map", field="map")
        discs = [(other.pose.x, other.pose.y, other.radius) for other in self.robots.values() if other.name != name]
        discs += [(obstacle.x, obstacle.y, obstacle.radius) for obstacle in self.present_obstacles()]
        return lidar.scan(self.grid, self.robots[name].pose, np.array(discs, dtype=float).reshape(-1, 3))
