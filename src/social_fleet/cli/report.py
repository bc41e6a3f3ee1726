"""Judge and draw a run that rosbag recorded: by true poses where the bag has them, else by measured ones. Needs ROS."""

import argparse
import os
from importlib import import_module
from typing import Any, List

from social_fleet.cli.output import show, written
from social_fleet.cli.simulate import summary
from social_fleet.errors import NotReady

SUMMARY = "judge and draw a run that rosbag recorded (needs ROS)"
EXAMPLE = "social_fleet report run.bag --out run_report   (recorded with roslaunch social_fleet record.launch)"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """What the verb takes."""
    parser.add_argument("bag", metavar="RUN.bag", help="recorded with rosbag; fleet/progress at least")
    parser.add_argument("--out", metavar="DIR", required=True,
                        help="folder for report.json, events.txt, map.png and time.png")
    parser.add_argument("--map", metavar="M.yaml", help="the map; default: the one in the bag")
    parser.add_argument("--animate", action="store_true", help="write fleet.gif, too")


def run(args: argparse.Namespace) -> int:
    """Read, judge, draw and sum up; 1 when robots touched or did not end where their last schedules do."""
    run = _recorded(args.bag)
    from social_fleet.files import atomic_write
    from social_fleet.mapping.files import load_map
    from social_fleet.scenario.report import judge, write_report
    grid = run.grid if args.map is None else load_map(args.map)
    name = os.path.splitext(os.path.basename(args.bag))[0]
    report = judge(run.recording, run.fleet, grid=grid, scenario=name,
                   replans={robot: max(count - 1, 0) for robot, count in run.schedules.items()})
    os.makedirs(args.out, exist_ok=True)
    write_report(report, os.path.join(args.out, "report.json"))
    with atomic_write(os.path.join(args.out, "events.txt")) as stream:
        stream.writelines(f"{event.time:9.2f}  {event.robot}: {event.what}\n" for event in run.events)
    files = ["report.json", "events.txt", *_draw(args, run, grid, name)]
    poses = "true poses" if run.is_true else "measured poses: contacts are as certain as localisation"
    show(args, report.to_dict(), [*summary(report), f"judged by {poses}; {len(run.events)} events",
                                  *written(*(os.path.join(args.out, file) for file in files))])
    return 0 if report.passed else 1


def _recorded(path: str) -> Any:
    """The run; by name, for the rooms that the command line is built of know no ROS."""
    try:
        module = import_module("social_fleet.ros.recorded_run")
    except ImportError as error:
        raise NotReady(f"reading a bag needs ROS and this package's messages ({error}); source devel/setup.bash of "
                       "the workspace first") from error
    return module.RecordedRun(path)


def _draw(args: argparse.Namespace, run: Any, grid: Any, title: str) -> List[str]:
    """The pictures' names."""
    from social_fleet.scenario.pictures.space_time import space_time_picture
    space_time_picture(run.fleet, os.path.join(args.out, "time.png"), title=title, recording=run.recording)
    if grid is None:
        return ["time.png"]
    from social_fleet.scenario.pictures.map_picture import map_picture
    map_picture(grid, run.fleet, os.path.join(args.out, "map.png"), title=title, recording=run.recording)
    if args.animate:
        from social_fleet.scenario.pictures.animation import animate
        animate(grid, run.fleet, os.path.join(args.out, "fleet.gif"), recording=run.recording, title=title)
        return ["time.png", "map.png", "fleet.gif"]
    return ["time.png", "map.png"]
