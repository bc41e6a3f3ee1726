"""Nodes: from the second start of map_publisher and social_planner until PlanPath answers, on a real map."""

import os
import signal
import subprocess
import time
from typing import Callable

from .worlds import ROOT, map_files

STARTS = 4  # the first compiles what Numba has not compiled yet
LIMIT = 120.0  # [s]


def run(say: Callable[[str], None]) -> bool:
    """Seconds from launch to answer; a master runs already."""
    import rosgraph
    map_file = map_files().get("willow", map_files()["office_floor"])
    master = _spawn("roscore", "-p", os.environ["ROS_MASTER_URI"].rsplit(":", 1)[1])
    try:
        _wait(rosgraph.is_master_online)
        taken = [_start(map_file) for _ in range(STARTS)]
    finally:
        _stop(master)
    say(f"{os.path.basename(map_file)}: first start {taken[0]:.1f} s, then "
        f"{', '.join(f'{seconds:.2f}' for seconds in taken[1:])} s, wanted <= 3 s")
    return True


def _start(map_file: str) -> float:
    """Seconds until the planner, started beside its map, answers a request with anything but 'no map yet'."""
    import rospy
    from social_fleet.srv import PlanPath, PlanPathResponse
    begun = time.monotonic()
    nodes = [_spawn(os.path.join(ROOT, "scripts", "map_publisher"), f"_map_file:={map_file}"),
             _spawn(os.path.join(ROOT, "scripts", "social_planner"))]
    try:
        rospy.wait_for_service("social_planner/plan_path", LIMIT)
        call = rospy.ServiceProxy("social_planner/plan_path", PlanPath)
        _wait(lambda: call().status != PlanPathResponse.NOT_INITIALIZED)
        return time.monotonic() - begun
    finally:
        for node in nodes:
            _stop(node)


def _spawn(*command: str) -> "subprocess.Popen[bytes]":
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)


def _stop(process: "subprocess.Popen[bytes]") -> None:
    os.killpg(process.pid, signal.SIGINT)
    try:
        process.wait(10.0)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _wait(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + LIMIT
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(f"nothing within {LIMIT:.0f} s")
        time.sleep(0.02)
