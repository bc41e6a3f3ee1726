"""Nodes: from the second start of map_publisher and social_planner until PlanPath answers on a real map, and memory."""

import os
import time
from typing import Callable, Tuple

from .processes import LIMIT, ros_master, running, wait_for
from .worlds import ROOT, map_files

STARTS = 4  # the first compiles what Numba has not compiled yet
MEMORY = 400  # [MB] wanted at most
SETTLING = 5.0  # [s] in which a node ends what it does in the background
LEARNT = 100  # paths that a social graph is learnt from where memory is measured


def run(say: Callable[[str], None]) -> bool:
    """Seconds from launch to answer, and what a planner with a social graph holds in memory, and held at most."""
    map_file = map_files().get("willow", map_files()["office_floor"])
    with ros_master():
        taken = [_start(map_file)[0] for _ in range(STARTS)]
        _, held, most = _start(map_file, f"_learn_at_start:={LEARNT}", settling=SETTLING)
    name = os.path.basename(map_file)
    say(f"{name}: first start {taken[0]:.1f} s, then {', '.join(f'{seconds:.2f}' for seconds in taken[1:])} s, "
        "wanted <= 3 s")
    say(f"{name}: the planner node holds {held:.0f} MB, at most {most:.0f} MB, wanted <= {MEMORY} MB")
    return True


def _start(map_file: str, *arguments: str, settling: float = 0.0) -> Tuple[float, float, float]:
    """Seconds until the planner, started beside its map, knows it and answers; its memory now and at most [MB]."""
    import rospy
    from social_fleet.srv import PlanPath, PlanPathResponse
    begun = time.monotonic()
    with running(os.path.join(ROOT, "scripts", "map_publisher"), f"_map_file:={map_file}"), \
            running(os.path.join(ROOT, "scripts", "social_planner"), *arguments) as planner:
        rospy.wait_for_service("social_planner/plan_path", LIMIT)
        call = rospy.ServiceProxy("social_planner/plan_path", PlanPath)
        wait_for(lambda: call().status != PlanPathResponse.NOT_INITIALIZED)
        taken = time.monotonic() - begun
        time.sleep(settling)
        return (taken, *_memory(planner.pid))


def _memory(process: int) -> Tuple[float, float]:
    """Resident memory now and at most [MB]."""
    with open(f"/proc/{process}/status") as stream:
        fields = dict(line.split(":", 1) for line in stream)
    return int(fields["VmRSS"].split()[0]) / 1e3, int(fields["VmHWM"].split()[0]) / 1e3
