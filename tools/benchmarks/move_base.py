"""The real move_base with SocialGlobalPlanner on a simulated robot: goals reached, and what the plugin costs.

Runs where `rospack find move_base` finds it; a workspace that it was built in can be named in
SOCIAL_FLEET_EXTRA_WORKSPACE.
"""

import math
import os
import subprocess
import time
from typing import Any, Callable, Sequence, Tuple

from .navigation import Robot, apart, launched, tour
from .processes import LIMIT
from .worlds import ROOT, map_files, planner

GOALS = 20
NEAREST, FARTHEST = 8.0, 25.0  # [m] of path from one goal to the next
FACTOR = 3.0  # simulated over wall time
WITHIN = 0.3  # [m] of the goal
WANTED = 1.2  # time of the plugin / time of PlanPath alone
Point = Tuple[float, float]


def run(say: Callable[[str], None]) -> bool:
    """Whether all goals were reached and the plugin adds little; True where move_base is not there."""
    if subprocess.run(("rospack", "find", "move_base"), capture_output=True).returncode:
        say("skipped: rospack does not find move_base")
        return True
    return apart(lambda: _run("willow" if "willow" in map_files() else "office_floor", say))


def _run(name: str, say: Callable[[str], None]) -> bool:
    """All of it on one map."""
    stops = tour(name, GOALS, NEAREST, FARTHEST)
    with launched("robot.launch", robot="gold", map=map_files()[name], localization="fake", x=stops[0][0],
                  y=stops[0][1], real_time_factor=FACTOR):
        robot = Robot("gold")
        robot.await_plan(stops[1])
        ratio = _ratio(stops, say)
        reached, planned = _drive(robot, stops, say)
    say(f"{name}: {reached} of {GOALS} goals reached, {planned} paths from SocialGlobalPlanner, smallest distance from "
        f"the map's walls {robot.smallest_gap(planner(name).space):.2f} m (radius 0.25 m)")
    say(f"{name}: planning through the plugin / PlanPath alone {ratio:.2f}, wanted <= {WANTED}")
    return reached == GOALS and planned >= GOALS and ratio <= WANTED


def _drive(robot: Any, stops: Sequence[Point], say: Callable[[str], None]) -> Tuple[int, int]:
    """How many goals were reached, and how many paths came from the plugin."""
    reached = 0
    for goal in stops[1:]:
        begun = time.monotonic()
        state = robot.go(goal)
        gap = math.dist(robot.position, goal)
        reached += gap <= WITHIN
        if gap > WITHIN:
            say(f"not reached: {goal}, {gap:.1f} m from it after {time.monotonic() - begun:.0f} s: {state}")
    return reached, robot.plans


def _ratio(stops: Sequence[Point], say: Callable[[str], None]) -> float:
    """Time of the plugin's makePlan over that of PlanPath alone, both called from C++."""
    import rospy
    rospy.set_param("/time_plans", {**rospy.get_param("/gold/move_base"), "SocialGlobalPlanner": {
        **rospy.get_param("/gold/move_base/SocialGlobalPlanner"), "robot": ""}})
    places = [str(value) for stop in stops for value in stop]
    program = os.path.join(ROOT, "build", "devel", "lib", "social_fleet", "time_plans")  # rosrun leaves build/ out
    out = subprocess.run((program, *places), capture_output=True, text=True, timeout=LIMIT, check=True).stdout
    alone, plugin = map(float, out.split()[-2:])
    say(f"a plan: PlanPath alone {1e3 * alone:.1f} ms, through the plugin {1e3 * plugin:.1f} ms")
    return plugin / alone
