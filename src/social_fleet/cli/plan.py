"""Plan one robot's path on a map, or many with --batch: social (keeps to one side), shortest, or RRT*."""

import argparse
import math
import os
import sys
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

from social_fleet.cli.arguments import add_pose, add_zones, check_outputs
from social_fleet.cli.output import show, written
from social_fleet.cli.progress import progress
from social_fleet.errors import InvalidGoal, InvalidInput, InvalidParameter, InvalidPose, InvalidStart, NoPath

SUMMARY = "plan one robot's path, or many with --batch"
EXAMPLE = "social_fleet plan --map maps/environment_1.yaml --start 2 25 --goal 97 40 --plot plan.png"
PLANNERS = ("social", "shortest", "rrt_star")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """What the verb takes."""
    parser.add_argument("--map", required=True, metavar="M.yaml", help="the map, as map_server's YAML file")
    add_pose(parser, "--start", "where the robot stands, in the map's frame [m, rad]")
    add_pose(parser, "--goal", "where it is to go; without a yaw any heading will do")
    parser.add_argument("--batch", metavar="pairs.json",
                        help="plan many: [[[x, y], [x, y]], …], each a start and a goal, with or without yaw")
    parser.add_argument("--planner", choices=PLANNERS, default="social", help="default: social")
    parser.add_argument("--graph", metavar="G", help="favour the routes of this social graph, made by learn")
    parser.add_argument("--overlays", metavar="O.yaml",
                        help="go round obstacles that the map does not hold: a list of {shape: circle, center: [x, y], "
                             "radius}, {shape: rectangle, center, size: [x, y], yaw}, {shape: polygon, points}")
    parser.add_argument("--config", metavar="C.yaml", help="parameters of the planner, such as robot_radius and side")
    add_zones(parser)
    parser.add_argument("--out", metavar="plan.json", help="write the path, with --batch a list of paths")
    parser.add_argument("--plot", metavar="plan.png", help="draw the path on the map")


def run(args: argparse.Namespace) -> int:
    """Plan, write, draw and sum up; 1 when a path is missing."""
    pairs = _pairs(args)
    check_outputs(args.out, args.plot)
    records, plans = [], []
    with progress(len(pairs), "planning", "paths") as update:
        planner = make_planner(args.map, args.config, args.graph, zones=args.zones)
        overlays = _overlays(args, planner.grid)
        _prepare(planner, args, pairs, overlays)
        for index, (name, start, goal) in enumerate(pairs):
            plan, record = _plan(planner, args, start, goal, overlays)
            plans.append(plan)
            records.append(record)
            update(index + 1)
    result = records if args.batch else records[0]
    if args.out:
        from social_fleet.files import write_json
        write_json(args.out, result)
    if args.plot:
        from social_fleet.planning.overlays.raster import drawn_on
        from social_fleet.scenario.pictures.plan_picture import plan_picture
        drawn = drawn_on(planner.grid, overlays.values())
        plan_picture(drawn, [(pairs[index][1], pairs[index][2], plan) for index, plan in enumerate(plans)], args.plot,
                     robot_radius=planner.config.robot_radius)
    show(args, result, [*_summary(records, bool(args.batch)), *written(args.out, args.plot)])
    return 0 if all(plan is not None for plan in plans) else 1


def _prepare(planner: Any, args: argparse.Namespace, pairs: Sequence[Tuple[str, Sequence[float], Sequence[float]]],
             overlays: Mapping[str, Any]) -> None:
    """Refuse poses before any path is planned, and make the planner fast where it pays."""
    from social_fleet.planning.planner import PREPARED_FROM
    for name, start, goal in pairs:
        _check(planner, args, name, start, goal, overlays)
    if len(pairs) >= PREPARED_FROM:
        planner.prepare()


def make_planner(map_path: str, config_path: Optional[str], graph_path: Optional[str] = None, *,
                 zones: Optional[str] = None) -> Any:
    """A planner from files; raises InvalidMap, InvalidParameter or InvalidGraph, naming the file."""
    from social_fleet.files import read_yaml
    from social_fleet.mapping.files import load_map
    from social_fleet.planning.config import PlannerConfig
    from social_fleet.planning.planner import SocialPlanner
    from social_fleet.planning.social_cost.norms import norm_of
    from social_fleet.planning.routes.social_graph import SocialGraph
    from social_fleet.planning.social_cost.zones import zones_of_map

    overrides = read_yaml(config_path, InvalidParameter) if config_path else {}
    if not isinstance(overrides or {}, dict):
        raise InvalidParameter("must be a mapping of parameters to values", source=str(config_path))
    config = PlannerConfig.from_mapping(overrides or {}, source=config_path or "")
    grid = load_map(map_path)
    graph = SocialGraph.load(graph_path, grid=grid) if graph_path else None
    try:
        norm_of(config)  # a class that cannot be had is better named with its file
    except InvalidParameter as error:
        raise InvalidParameter(error.message, source=str(config_path), field=error.field) from error
    return SocialPlanner(grid, config, graph=graph, zones=zones_of_map(map_path, zones))


def _pairs(args: argparse.Namespace) -> List[Tuple[str, Tuple[float, ...], Tuple[float, ...]]]:
    """(name for messages, start, goal) of every path asked for."""
    if args.batch:
        if args.start or args.goal:
            raise InvalidInput("give either --batch or --start and --goal", source="command line")
        return read_batch(args.batch)
    for flag in ("start", "goal"):
        if getattr(args, flag) is None:
            raise InvalidInput("is missing; give --start and --goal, or --batch", source="command line",
                               field=f"--{flag}")
    return [("", args.start, args.goal)]


def read_batch(path: str) -> List[Tuple[str, Tuple[float, ...], Tuple[float, ...]]]:
    """The pairs of a batch file, each with the name that messages give it."""
    from social_fleet.files import read_json
    content = read_json(path)
    if not isinstance(content, list) or not content:
        raise InvalidInput("must be a list of pairs [[x, y], [x, y]]", source=path)
    pairs = []
    for index, pair in enumerate(content):
        if not (isinstance(pair, list) and len(pair) == 2 and all(map(_is_pose, pair))):
            raise InvalidInput(f"must be a pair [[x, y], [x, y]], not {pair!r:.80}", source=path, field=f"[{index}]")
        pairs.append((f"[{index}]", tuple(map(float, pair[0])), tuple(map(float, pair[1]))))
    return pairs


def _is_pose(value: Any) -> bool:
    return (isinstance(value, list) and len(value) in (2, 3)
            and all(isinstance(item, (int, float)) and not isinstance(item, bool)
                    and abs(item) <= sys.float_info.max for item in value))


def _overlays(args: argparse.Namespace, grid: Any) -> Mapping[str, Any]:
    """The obstacles asked for, by name."""
    if not args.overlays:
        return {}
    from social_fleet.scenario.obstacle_files import load_obstacles
    return load_obstacles(args.overlays, grid)


def _check(planner: Any, args: argparse.Namespace, name: str, start: Sequence[float], goal: Sequence[float],
           overlays: Mapping[str, Any]) -> None:
    """Refuse a pose that the robot cannot take before any path is planned."""
    for what, pose, kind in (("start", start, InvalidStart), ("goal", goal, InvalidGoal)):
        try:
            planner.space.check_pose(pose[0], pose[1], what)
            if not math.isfinite(pose[-1]):
                raise kind(f"the yaw {pose[-1]} is not finite; give it in radians")
            planner.check_pose(pose, what, overlays=overlays)
        except InvalidPose as error:
            raise _placed(error, args, name) from error


def _placed(error: InvalidPose, args: argparse.Namespace, name: str) -> InvalidPose:
    """`error` with the file and field that the pose came from."""
    end = int(isinstance(error, InvalidGoal))
    if args.batch:
        return type(error)(error.message, source=args.batch, field=f"{name}[{end}]")
    return type(error)(error.message, source=args.map, field=("--start", "--goal")[end])


def _plan(planner: Any, args: argparse.Namespace, start: Sequence[float], goal: Sequence[float],
          overlays: Mapping[str, Any]) -> Tuple[Any, Dict[str, Any]]:
    """The plan, None where there is no path, and its record for plan.json."""
    record: Dict[str, Any] = {"map": args.map, "planner": args.planner, "robot_radius": planner.config.robot_radius,
                              "points": [], "length": None, "social_cost": None, "cost": None, "expanded": None,
                              "search_time": None, "status": "ok"}
    try:
        plan = planner.plan(start, goal, planner=args.planner, overlays=overlays)
    except NoPath as error:
        return None, {**record, "status": "no_path_found", "message": str(error)}
    for name in ("points", "length", "social_cost", "cost", "expanded", "search_time"):
        record[name] = getattr(plan, name)
    if overlays:
        record["temporary"] = plan.temporary
    return plan, record


def _summary(records: Sequence[Dict[str, Any]], batch: bool) -> List[str]:
    found = [record for record in records if record["status"] == "ok"]
    if not batch:
        record = records[0]
        if not found:
            return [f"no path: {record['message']}"]
        return [f"{record['planner']} path on {os.path.basename(record['map'])}: {record['length']:.2f} m, "
                f"cost {record['cost']:.2f} (social {record['social_cost']:.2f}), {len(record['points'])} points",
                f"searched {record['expanded']} cells in {1000.0 * record['search_time']:.1f} ms"]
    count = max(len(found), 1)
    return [f"{len(found)} of {len(records)} paths found; mean length {sum(r['length'] for r in found) / count:.2f} m, "
            f"mean search {1000.0 * sum(r['search_time'] for r in found) / count:.1f} ms"]
