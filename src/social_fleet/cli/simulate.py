"""Drive a scenario's fleet in simulation, without ROS and faster than real time, and judge what happened."""

import argparse
from typing import Any, Callable, List, Tuple

from social_fleet.cli.arguments import check_outputs
from social_fleet.cli.output import show, table, written
from social_fleet.cli.progress import progress

SUMMARY = "drive the fleet of a scenario file in simulation"
EXAMPLE = "social_fleet simulate config/scenarios/figure_9.yaml --out report.json --animate fleet.gif"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """What the verb takes."""
    parser.add_argument("scenario", metavar="SCENARIO.yaml", help="map, robots, faults, and what is expected")
    parser.add_argument("--out", metavar="report.json", help="write the report")
    parser.add_argument("--animate", metavar="fleet.gif", help="write an animation of the run")
    parser.add_argument("--plot", metavar="PREFIX",
                        help="write PREFIX_map.png and PREFIX_time.png: paths and space-time diagram, as driven")


def run(args: argparse.Namespace) -> int:
    """Coordinate, drive, write and sum up; 1 when the run is not what the scenario expects."""
    plots = [] if args.plot is None else [f"{args.plot}_map.png", f"{args.plot}_time.png"]
    check_outputs(args.out, args.animate, *plots)
    from social_fleet.mapping.files import load_map
    from social_fleet.scenario.files import load_scenario
    from social_fleet.scenario.fleet import coordinate_scenario

    scenario = load_scenario(args.scenario)
    grid = load_map(scenario.map_path)
    with progress(len(scenario.robots), "planning", "robots") as update:
        fleet = coordinate_scenario(scenario, grid, progress=update)
    with progress(100.0, "driving", "%") as update:
        report, recording = _driven(scenario, fleet, grid, lambda share: update(100.0 * share))
    if args.out:
        from social_fleet.scenario.report import write_report
        write_report(report, args.out)
    if args.animate:
        from social_fleet.scenario.pictures.animation import animate
        animate(grid, fleet, args.animate, recording=recording, obstacles=scenario.obstacles, title=scenario.name)
    if plots:
        from social_fleet.scenario.pictures.map_picture import map_picture
        from social_fleet.scenario.pictures.space_time import space_time_picture
        map_picture(grid, fleet, plots[0], title=f"{scenario.name}: paths, encounters, and what was driven",
                    recording=recording)
        space_time_picture(fleet, plots[1], title=f"{scenario.name}: schedule and what was driven",
                           recording=recording)
    show(args, report.to_dict(), [*summary(report), *written(args.out, args.animate, *plots)])
    return 0 if report.passed else 1


def _driven(scenario: Any, fleet: Any, grid: Any, update: Callable[[float], None]) -> Tuple[Any, Any]:
    """Report and recording; with a dispatcher and a network where anything is to go wrong."""
    if scenario.is_undisturbed:
        from social_fleet.scenario.closed_loop import simulate_scenario
        return simulate_scenario(scenario, fleet, grid, config=scenario.simulation_config, progress=update)
    from social_fleet.scenario.faulty import drive_scenario, report_of
    run = drive_scenario(scenario, fleet, grid, progress=update)
    return report_of(scenario, fleet, run), run.recording


def summary(report: Any) -> List[str]:
    """A table of the robots and the verdict."""
    rows = [[robot.name, "-" if robot.arrival_time is None else f"{robot.arrival_time:.1f}",
             f"{robot.scheduled_time:.1f}", f"{robot.path_length:.1f}", f"{robot.max_tracking_error:.3f}"]
            for robot in report.robots]
    lines = table(["robot", "arrived s", "scheduled s", "path m", "off its reference m"], rows)
    closest = ("" if report.min_clearance is None
               else f", smallest clearance of two robots {report.min_clearance:.3f} m")
    lines.append(f"{'passed' if report.passed else 'FAILED'}: {len(report.collisions)} collisions{closest}")
    lines += [f"  {sentence}" for sentence in report.failures]
    lines.append(f"{report.simulated_time:.0f} s simulated in {report.wall_time:.1f} s")
    return lines
