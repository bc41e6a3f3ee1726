"""Learn a social graph: plan many paths between random free poses and keep the routes that recur (3.2.2)."""

import argparse

from social_fleet.cli.arguments import add_zones, check_outputs, count, seed
from social_fleet.cli.output import show, written
from social_fleet.cli.progress import progress

SUMMARY = "learn a social graph from random plans"
EXAMPLE = "social_fleet learn --map maps/environment_1.yaml --paths 250 --seed 1 --out environment_1.graph"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """What the verb takes."""
    parser.add_argument("--map", required=True, metavar="M.yaml", help="the map, as map_server's YAML file")
    parser.add_argument("--paths", required=True, type=count, metavar="N", help="how many paths to plan")
    parser.add_argument("--seed", type=seed, default=0, metavar="S", help="of the random poses; default: 0")
    parser.add_argument("--config", metavar="C.yaml", help="parameters of the planner, such as robot_radius and side")
    add_zones(parser)
    parser.add_argument("--out", required=True, metavar="G", help="the graph file, for plan --graph")


def run(args: argparse.Namespace) -> int:
    """Learn, save and sum up."""
    check_outputs(args.out)
    from social_fleet.cli.plan import make_planner
    from social_fleet.planning.social_graph import learn

    planner = make_planner(args.map, args.config, zones=args.zones)
    with progress(args.paths, "learning", "paths") as update:
        graph = learn(planner, paths=args.paths, seed=args.seed, progress=lambda done, _: update(done))
    graph.save(args.out)
    result = {"map": args.map, "paths": args.paths, "seed": args.seed, "nodes": graph.node_count,
              "edges": graph.edge_count}
    show(args, result, [f"a social graph of {graph.node_count} nodes and {graph.edge_count} edges "
                        f"from {args.paths} paths", *written(args.out)])
    return 0
