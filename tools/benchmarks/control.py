"""Control: eight robots through the nodes at 20 Hz in real time, and how many control periods pass without a command.

Each robot has its tracker and its navigator; all get goals at the same time. Trackers count
a period as missed when the next command comes more than one and a half periods after the last.
"""

import os
import time
from typing import Any, Callable, Dict

from .processes import LIMIT, ros_master, running, wait_for
from .worlds import ROOT

ROBOTS = 8
SECONDS = 60.0  # watched, of wall time, from when all drive


def run(say: Callable[[str], None]) -> bool:
    """Missed periods of every tracker, the longest time between two commands, and the machine's load."""
    import rospy
    from diagnostic_msgs.msg import DiagnosticArray
    scenario = _scenario()
    health: Dict[str, Dict[str, str]] = {}

    def hear(message: Any) -> None:
        for status in message.status:
            if status.name.endswith("trajectory_tracker: control"):
                health[status.hardware_id] = {item.key: item.value for item in status.values}

    with ros_master():
        port = os.environ["ROS_MASTER_URI"].rsplit(":", 1)[1]
        with running("roslaunch", "-p", port, "social_fleet", "simulated_fleet.launch", f"scenario:={scenario}",
                     "real_time_factor:=1.0"):
            rospy.init_node("control_benchmark", anonymous=True, disable_signals=True)
            rospy.Subscriber("/diagnostics", DiagnosticArray, hear, queue_size=100)
            _drive(scenario)
            wait_for(lambda: len(health) == ROBOTS)
            before = {name: dict(values) for name, values in health.items()}
            spent = _processor_time()
            time.sleep(SECONDS)
            after = {name: dict(values) for name, values in health.items()}
            used = {node: seconds - spent.get(node, 0.0) for node, seconds in _processor_time().items()}
            missed = {name: int(after[name]["missed"]) - int(before[name]["missed"]) for name in sorted(after)}
            periods = sum(int(after[name]["periods"]) - int(before[name]["periods"]) for name in after)
            longest = max(float(values["longest [s]"]) for values in after.values())
    say(f"{ROBOTS} robots, {SECONDS:.0f} s: {sum(missed.values())} of {periods} control periods "
        f"missed, wanted 0; longest time between two commands since the start {longest:.3f} s; load "
        f"{os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")
    shares = {node: seconds / SECONDS for node, seconds in used.items() if seconds > 0.01 * SECONDS}
    say(f"processors in use: {sum(shares.values()):.2f}, of them " + ", ".join(
        f"{node} {share:.2f}" for node, share in sorted(shares.items(), key=lambda item: -item[1])))
    return True


def _processor_time() -> Dict[str, float]:
    """Processor seconds so far of the nodes on this ROS master, by executable."""
    mark = f"ROS_MASTER_URI={os.environ['ROS_MASTER_URI'].rstrip('/')}".encode()
    spent: Dict[str, float] = {}
    for process in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{process}/environ", "rb") as stream:
                ours = mark in (entry.rstrip(b"/") for entry in stream.read().split(b"\0"))
            with open(f"/proc/{process}/cmdline", "rb") as stream:
                words = stream.read().decode().split("\0")
            with open(f"/proc/{process}/stat", encoding="utf-8") as stream:
                fields = stream.read().rsplit(")", 1)[1].split()
        except OSError:  # it has ended
            continue
        if ours and int(process) != os.getpid():
            ours_first = (word for word in words[:3] if "/social_fleet/" in word or "/scripts/" in word)
            node = os.path.basename(next(ours_first, words[0]))
            spent[node] = spent.get(node, 0.0) + (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return spent


def _scenario() -> str:
    """A random fleet, the same in every run."""
    from social_fleet.mapping.files import load_map
    from social_fleet.scenario.files import save_scenario
    from social_fleet.scenario.random_fleet import random_scenario
    path = os.path.join(ROOT, "maps", "environment_1.yaml")
    file = os.path.join(ROOT, "build", "control_benchmark.yaml")
    save_scenario(random_scenario(load_map(path), ROBOTS, seed=3, map_name=path, map_path=path), file)
    return file


def _drive(scenario: str) -> None:
    """Send all robots to their goals, and wait until they drive."""
    import actionlib
    import rospy
    from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
    from social_fleet.geometry import Pose
    from social_fleet.msg import NavigationStatus
    from social_fleet.ros import conversions
    from social_fleet.scenario.files import load_scenario
    states: Dict[str, int] = {}
    rospy.Subscriber("fleet/navigation", NavigationStatus, lambda item: states.update({item.robot: item.state}),
                     queue_size=100)
    for spec in load_scenario(scenario).robots:
        client = actionlib.SimpleActionClient(f"{spec.name}/move_base", MoveBaseAction)
        if not client.wait_for_server(rospy.Duration.from_sec(LIMIT)):
            raise TimeoutError(f"no navigator of {spec.name}")
        x, y, yaw = (*spec.goal, 0.0)[:3]
        client.send_goal(MoveBaseGoal(conversions.pose_to_stamped(Pose(x, y, yaw), "map")))
    wait_for(lambda: list(states.values()).count(NavigationStatus.DRIVING) == ROBOTS)
