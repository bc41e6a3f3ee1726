"""The real GMapping in corridors like those of Environment 1: plans on its map beside plans on the truth.

Runs where `rospack find gmapping` finds it; a workspace that it was built in can be named in
SOCIAL_FLEET_EXTRA_WORKSPACE.
"""

import math
import os
import subprocess
import tempfile
import time
from typing import Any, Callable, List, Sequence, Tuple

import numpy as np

from social_fleet.errors import SocialFleetError
from social_fleet.mapping.drawing import draw
from social_fleet.mapping.files import save_map
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import random_pose_pairs

from .amcl import NOISE
from .navigation import apart, launched
from .processes import LIMIT, running, wait_for
from .worlds import ROOT

SIZE = 30.0  # [m]
# Four blocks; 2.85 m wide corridors about them and 4 m wide ones between them.
WORLD = {"size": [SIZE, SIZE], "resolution": 0.05, "border": 3, "shapes": [
    {"fill": "wall", "x": x, "y": y} for x in ([3.0, 13.0], [17.0, 27.0]) for y in ([3.0, 13.0], [17.0, 27.0])]}
EDGE, MIDDLE, FAR = 1.6, 15.0, SIZE - 1.6
# Round the outside, then through the middle both ways.
TOUR = ((EDGE, EDGE), (FAR, EDGE), (FAR, FAR), (EDGE, FAR), (EDGE, EDGE), (MIDDLE, EDGE), (MIDDLE, FAR), (FAR, FAR),
        (FAR, MIDDLE), (EDGE, MIDDLE))
SPEED = 0.6  # [m/s]
FACTOR = 1.0  # simulated over wall time
PAIRS = 40
WANTED = 0.03  # difference of a plan's lengths / length on the truth


def run(say: Callable[[str], None]) -> bool:
    """Whether every plan is about as long on GMapping's map; True where it is not there."""
    if subprocess.run(("rospack", "find", "gmapping"), capture_output=True).returncode:
        say("skipped: rospack does not find gmapping")
        return True
    return apart(lambda: _compare(say))


def _compare(say: Callable[[str], None]) -> bool:
    """Plan on both maps."""
    truth = draw(WORLD)
    found = _explored(truth, say)
    output = os.path.join(ROOT, "bench_output")
    os.makedirs(output, exist_ok=True)
    save_map(found, os.path.join(output, "gmapping.yaml"), image="png")
    save_map(truth, os.path.join(output, "corridors.yaml"), image="png")
    config = PlannerConfig(robot_radius=0.25)
    true_planner, found_planner = SocialPlanner(truth, config), SocialPlanner(found, config)
    pairs = random_pose_pairs(SocialPlanner(truth, PlannerConfig(robot_radius=0.4)), PAIRS, seed=1)
    differences: List[float] = []
    for start, goal in pairs:
        length = true_planner.plan(start[:2], goal[:2]).length
        try:
            other = found_planner.plan(_shifted(start), _shifted(goal)).length
        except SocialFleetError as error:
            say(f"no plan on GMapping's map: {error}")
            other = math.inf
        differences.append(abs(other - length) / length)
    say(f"{PAIRS} plans on GMapping's map and on the truth: lengths differ by {100.0 * np.mean(differences):.2f} % in "
        f"the mean, by {100.0 * max(differences):.2f} % at most, wanted <= {100.0 * WANTED:g} %")
    return max(differences) <= WANTED


def _shifted(place: Sequence[float]) -> Tuple[float, float]:
    """GMapping's map begins where the robot does."""
    return float(place[0]) - EDGE, float(place[1]) - EDGE


def _explored(truth: OccupancyGrid, say: Callable[[str], None]) -> OccupancyGrid:
    """GMapping's map after the tour."""
    import rospy
    from nav_msgs.msg import OccupancyGrid as GridMessage

    from social_fleet.ros import conversions
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "corridors.yaml")
        save_map(truth, file)
        robots = f"{{gold: {{start: [{EDGE}, {EDGE}, 0.0], max_speed: {SPEED}}}}}"
        with launched("fake_robots.launch", robots=robots, localise=False, real_time_factor=FACTOR, overrides=NOISE,
                      map_topic="/true_map"), \
                running("rosrun", "social_fleet", "map_publisher", file, "map:=/true_map"), \
                running("roslaunch", "social_fleet", "gmapping.launch", "robot:=gold"):
            begun = time.monotonic()
            _drive()
            say(f"drove {_length(TOUR):.0f} m in {time.monotonic() - begun:.0f} s of wall time")
            maps: List[Any] = []
            rospy.Subscriber("map", GridMessage, maps.append, queue_size=1)
            since = rospy.Time.now()
            wait_for(lambda: bool(maps) and maps[-1].header.stamp > since or len(maps) > 2)
            return conversions.grid_from_message(maps[-1])


def _length(places: Sequence[Sequence[float]]) -> float:
    return sum(math.dist(one, other) for one, other in zip(places, places[1:]))


def _drive() -> None:
    """Steer the robot from corner to corner, as one does by hand."""
    import rospy
    from geometry_msgs.msg import PoseArray, Twist
    poses: List[Any] = []
    rospy.Subscriber("fleet/ground_truth", PoseArray, lambda message: poses.append(message.poses[0]), queue_size=1)
    commands = rospy.Publisher("gold/cmd_vel", Twist, queue_size=1)
    wait_for(lambda: bool(poses) and commands.get_num_connections() > 0)
    for goal in TOUR[1:]:
        deadline = time.monotonic() + LIMIT
        while math.dist((poses[-1].position.x, poses[-1].position.y), goal) > 0.3:
            if time.monotonic() > deadline:
                raise TimeoutError(f"did not get to {goal}")
            pose = poses[-1]
            del poses[:-1]
            yaw = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
            bearing = math.atan2(goal[1] - pose.position.y, goal[0] - pose.position.x)
            turn = math.atan2(math.sin(bearing - yaw), math.cos(bearing - yaw))
            command = Twist()
            command.linear.x = SPEED * max(0.0, math.cos(turn)) ** 4
            command.angular.z = max(-0.6, min(0.6, 1.5 * turn))
            commands.publish(command)
            time.sleep(0.05)
    commands.publish(Twist())
