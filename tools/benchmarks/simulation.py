"""The closed loop without ROS: 16 robots, how fast beside real time, and how closely they keep their schedule."""

from typing import Callable

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.replanning import PlannerReplanner
from social_fleet.scenario.closed_loop import simulate

from .worlds import fleet, map_files, planner

ROBOTS = 16
SEEDS = (0, 1, 2)


def run(say: Callable[[str], None]) -> bool:
    """Environment 1 and the Willow map, three fleets each."""
    held = True
    for name in [name for name in ("environment_1", "willow") if name in map_files()]:
        for seed in SEEDS:
            schedule = coordinate(fleet(name, ROBOTS, seed), time_limit=120.0,
                                  replanner=PlannerReplanner(lambda radius, name=name: planner(name)))
            report, _ = simulate(schedule, planner(name).grid)
            late = max(robot.arrival_time - robot.scheduled_time for robot in report.robots
                       if robot.arrival_time is not None)
            say(f"{name}, seed {seed}: {report.simulated_time / report.wall_time:.0f} x real time; makespan "
                f"{report.makespan / schedule.makespan:.3f} x scheduled, latest arrival {late:+.2f} s, tracking error "
                f"{max(robot.max_tracking_error for robot in report.robots):.3f} m, smallest clearance "
                f"{report.min_clearance:.3f} m, {len(report.collisions)} contacts")
            held &= report.passed
    return held
