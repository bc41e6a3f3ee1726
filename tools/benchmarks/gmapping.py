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

from social_fleet.geometry import Polyline
from social_fleet.mapping.drawing import draw
from social_fleet.mapping.files import save_map
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import random_pose_pairs

from .amcl import NOISE
from .navigation import Localisation, apart, launched
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
SHORTEST = 5.0  # [m] between a start and its goal, as the crow flies: on a short way a cell is more than what is wanted
APART = 2.0  # [m] between plans that go another way round
SPECK = 0.5  # [m] that a plan's ends may move on GMapping's map
CONFIG = PlannerConfig(robot_radius=0.25)
Pairs = Sequence[Sequence[Sequence[float]]]
Moved = Callable[[np.ndarray], np.ndarray]
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
    found, moved = _explored(truth, say)
    output = os.path.join(ROOT, "bench_output")
    os.makedirs(output, exist_ok=True)
    save_map(found, os.path.join(output, "gmapping.yaml"), image="png")
    drawn = random_pose_pairs(SocialPlanner(truth, PlannerConfig(robot_radius=0.5)), 3 * PAIRS, seed=1)
    pairs = [pair for pair in drawn if math.dist(*pair) >= SHORTEST][:PAIRS]
    planners = SocialPlanner(truth, CONFIG), SocialPlanner(found, CONFIG)
    return all([_differences(planners, pairs, moved, kind, say) for kind in ("shortest", "social")])


def _differences(planners: Tuple[SocialPlanner, SocialPlanner], pairs: Pairs, moved: Moved, kind: str,
                 say: Callable[[str], None]) -> bool:
    """Whether plans are as long on both maps; those that go another way round are counted by themselves."""
    same: List[float] = []
    others = 0
    for pair in pairs:
        start, goal = (np.array(place[:2], dtype=float) for place in pair)
        plan = planners[0].plan(start, goal, planner=kind)
        begin = moved(start)
        # A speck in a corridor may lie right there.
        begin = np.array(planners[1].departure(begin, SPECK) or begin)
        other = planners[1].plan(begin, moved(goal), planner=kind, tolerance=SPECK)
        way, steps = Polyline([moved(point) for point in plan.points]), np.linspace(0.0, 1.0, 200)
        apart = np.hypot(*(way.position(steps * way.length) - other.path.position(steps * other.length)).T).max()
        if apart < APART:
            same.append(abs(other.length - plan.length) / plan.length)
        else:
            others += 1
    say(f"{kind} plans on GMapping's map and on the truth: {len(same)} of {PAIRS} take the same way and differ in "
        f"length by {100.0 * np.mean(same):.2f} % in the mean, by {100.0 * max(same):.2f} % at most, {others} go "
        f"another way round; wanted <= {100.0 * WANTED:g} % at most")
    return max(same) <= WANTED and len(same) >= 0.75 * PAIRS


def _explored(truth: OccupancyGrid, say: Callable[[str], None]) -> Tuple[OccupancyGrid, Moved]:
    """GMapping's map after the tour, and where on it places of the world are."""
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
            begun, localisation = time.monotonic(), Localisation(("gold",))
            _drive()
            say(f"drove {_length(TOUR):.0f} m in {time.monotonic() - begun:.0f} s of wall time")
            maps: List[Any] = []
            rospy.Subscriber("map", GridMessage, maps.append, queue_size=1)
            since = rospy.Time.now()
            wait_for(lambda: bool(maps) and maps[-1].header.stamp > since or len(maps) > 2)
            return conversions.grid_from_message(maps[-1]), localisation.fitted("gold")


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
