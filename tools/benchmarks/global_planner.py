"""ROS's C++ global_planner beside ours on a real map: the same pairs in one run.

Runs where `rospack find global_planner` finds it; a workspace that it was built in can be named in
SOCIAL_FLEET_EXTRA_WORKSPACE. It is asked as its users ask it, through make_plan; ours is measured so, too, beside the
planner alone.
"""

import os
import subprocess
import time
from typing import Any, Callable, List, Sequence, Tuple

import numpy as np

from social_fleet.planning.random_poses import random_pose_pairs

from .processes import LIMIT, ros_master, running, wait_for
from .worlds import ROOT, map_files, planner

PAIRS = 100
REPEATS = 3
WANTED = 0.25  # our plain A* / global_planner's Dijkstra
SETTLING = 2.0  # [s] in which a new costmap is still being filled
COSTMAP = {
    "global_frame": "map", "robot_base_frame": "base_link", "rolling_window": False, "track_unknown_space": True,
    "robot_radius": 0.25, "footprint_padding": 0.0,
    "plugins": [{"name": "static_layer", "type": "costmap_2d::StaticLayer"},
                {"name": "inflation_layer", "type": "costmap_2d::InflationLayer"}],
    "static_layer": {"map_topic": "/map", "track_unknown_space": True, "lethal_cost_threshold": 65},
    "inflation_layer": {"inflation_radius": 0.25, "cost_scaling_factor": 10.0}}
# Its defaults, but that unknown space is no way.
PLANNER = {"use_dijkstra": True, "allow_unknown": False}
Pairs = Sequence[Tuple[Tuple[float, float], Tuple[float, float]]]


def run(say: Callable[[str], None]) -> bool:
    """Mean times per plan; nothing fails where global_planner is not there."""
    if subprocess.run(("rospack", "find", "global_planner"), capture_output=True).returncode:
        say("skipped: rospack does not find global_planner")
        return True
    name = "willow" if "willow" in map_files() else "office_floor"
    pairs = random_pose_pairs(planner(name), PAIRS, seed=1)
    alone = {kind: _alone(name, kind, pairs) for kind in ("shortest", "social")}
    with ros_master(), running(os.path.join(ROOT, "scripts", "map_publisher"), f"_map_file:={map_files()[name]}"):
        base = _publish_base()
        theirs = _theirs(pairs, say)
        del base
        ours = {side: _ours(side, pairs) for side in ("none", "right")}
    say(f"{name}: global_planner's Dijkstra {1e3 * theirs:.1f} ms; of that take: our social plan "
        f"{alone['social'] / theirs:.2f}, through the node's make_plan with side none {ours['none'] / theirs:.2f}, "
        f"with side right {ours['right'] / theirs:.2f}")
    ratio = alone["shortest"] / theirs
    say(f"{name}: plain A* / Dijkstra {ratio:.2f}, wanted <= {WANTED}")
    return True


def _mean(plan: Callable[[Any, Any], bool], pairs: Pairs) -> Tuple[float, int]:
    """Mean over the pairs that get a path of the median time of several tries [s], and how many do."""
    times: List[float] = []
    for start, goal in pairs:
        taken, found = [], True
        for _ in range(REPEATS):
            begun = time.perf_counter()
            found &= plan(start, goal)
            taken.append(time.perf_counter() - begun)
        if found:
            times.append(float(np.median(taken)))
    return float(np.mean(times)), len(times)


def _alone(name: str, kind: str, pairs: Pairs) -> float:
    """Our planner without ROS [s]."""
    planner(name).prepare()
    planner(name).plan(*pairs[0], planner=kind)
    return _mean(lambda start, goal: planner(name).plan(start, goal, planner=kind).length > 0.0, pairs)[0]


def _theirs(pairs: Pairs, say: Callable[[str], None]) -> float:
    """global_planner through its make_plan [s]."""
    import roslib.message
    import rospy
    rospy.set_param("/global_planner", {"costmap": COSTMAP, "planner": PLANNER})
    make_nav_plan = roslib.message.get_service_class("navfn/MakeNavPlan")
    with running("rosrun", "global_planner", "planner", "__name:=global_planner"):
        rospy.wait_for_service("/global_planner/make_plan", LIMIT)
        call = rospy.ServiceProxy("/global_planner/make_plan", make_nav_plan)

        def found(start: Any, goal: Any) -> bool:
            return bool(call(_pose(start), _pose(goal)).plan_found)

        wait_for(lambda: found(*pairs[0]))
        time.sleep(SETTLING)
        call = rospy.ServiceProxy("/global_planner/make_plan", make_nav_plan, persistent=True)
        seconds, count = _mean(found, pairs)
    say(f"global_planner: {count} of {len(pairs)} pairs found, and those alone counted")
    return seconds


def _ours(side: str, pairs: Pairs) -> float:
    """The node social_planner through its make_plan [s]."""
    import rospy
    from nav_msgs.srv import GetPlan
    with running(os.path.join(ROOT, "scripts", "social_planner"), f"_side:={side}"):
        rospy.wait_for_service("/social_planner/make_plan", LIMIT)
        call = rospy.ServiceProxy("/social_planner/make_plan", GetPlan, persistent=True)

        def found(start: Any, goal: Any) -> bool:
            try:
                return bool(call(_pose(start), _pose(goal), 0.0).plan.poses)
            except rospy.ServiceException:
                return False

        wait_for(lambda: found(*pairs[0]))
        time.sleep(SETTLING)
        return _mean(found, pairs)[0]


def _publish_base() -> Any:
    """Tell tf where the robot is, as long as what is returned lives."""
    import rospy
    import tf2_ros
    from geometry_msgs.msg import TransformStamped
    rospy.init_node("benchmark", disable_signals=True)
    transform = TransformStamped()
    transform.header.stamp = rospy.Time.now()
    transform.header.frame_id, transform.child_frame_id = "map", "base_link"
    transform.transform.rotation.w = 1.0
    broadcaster = tf2_ros.StaticTransformBroadcaster()
    broadcaster.sendTransform(transform)
    return broadcaster


def _pose(position: Tuple[float, float]) -> Any:
    from geometry_msgs.msg import PoseStamped
    pose = PoseStamped()
    pose.header.frame_id = "map"
    pose.pose.position.x, pose.pose.position.y = position
    pose.pose.orientation.w = 1.0
    return pose
