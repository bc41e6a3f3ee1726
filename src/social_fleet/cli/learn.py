"""Learn a social graph: plan many paths between random free poses and keep the routes that recur (3.2.2).

With --merge, what other robots learnt is counted in; of a graph of another map, or of this one before it changed, what
still holds.
"""

import argparse
import logging
from typing import Any, Callable, Optional

from social_fleet.cli.arguments import add_zones, check_outputs, count, seed
from social_fleet.cli.output import show, written
from social_fleet.cli.progress import progress
from social_fleet.errors import InvalidGraph, InvalidInput

log = logging.getLogger(__name__)

SUMMARY = "learn a social graph from random plans"
EXAMPLE = "social_fleet learn --map maps/environment_1.yaml --paths 250 --seed 1 --out environment_1.graph"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """What the verb takes."""
    parser.add_argument("--map", required=True, metavar="M.yaml", help="the map, as map_server's YAML file")
    parser.add_argument("--paths", type=count, metavar="N", help="how many paths to plan; may be left out with --merge")
    parser.add_argument("--merge", nargs="+", default=[], metavar="G",
                        help="count in what these graphs were learnt from, in any order")
    parser.add_argument("--seed", type=seed, default=0, metavar="S", help="of the random poses; default: 0")
    parser.add_argument("--config", metavar="C.yaml", help="parameters of the planner, such as robot_radius and side")
    add_zones(parser)
    parser.add_argument("--out", required=True, metavar="G", help="the graph file, for plan --graph")
    parser.add_argument("--graphml", metavar="FILE", help="write the graph as GraphML, too, for other programs")


def run(args: argparse.Namespace) -> int:
    """Learn, save and sum up."""
    if args.paths is None and not args.merge:
        raise InvalidInput("is missing; say how many paths to plan, or give --merge", source="command line",
                           field="--paths")
    check_outputs(args.out, args.graphml)
    from social_fleet.cli.plan import make_planner
    from social_fleet.planning.routes.graph_changes import merged

    with progress(args.paths or 1, "learning", "paths") as update:
        planner = make_planner(args.map, args.config, zones=args.zones)
        graphs = [_load(path, planner) for path in args.merge]
        own = _learnt(args, planner, update)
    graph = merged(graphs + ([own] if own else []), planner.config.heatmap_threshold, planner.config.min_component)
    graph.save(args.out)
    if args.graphml:
        from social_fleet.planning.routes.graph_files import write_graphml
        write_graphml(graph, args.graphml)
    result = {"map": args.map, "paths": args.paths or 0, "seed": args.seed, "nodes": graph.node_count,
              "edges": graph.edge_count}
    if args.merge:
        result["merged"] = args.merge
    sources = [f"{args.paths} paths"] if args.paths else []
    sources += [f"{len(graphs)} other graph{'s' * (len(graphs) > 1)}"] if graphs else []
    show(args, result, [f"a social graph of {graph.node_count} nodes and {graph.edge_count} edges "
                        f"from {' and '.join(sources)}", *written(args.out, args.graphml)])
    return 0


def _learnt(args: argparse.Namespace, planner: Any, update: Callable[[float], None]) -> Optional[Any]:
    """The graph of the paths that are asked for, None without."""
    from social_fleet.planning.routes.social_graph import learn
    if args.paths is None:
        return None
    return learn(planner, paths=args.paths, seed=args.seed, progress=lambda done, _: update(done))


def _load(path: str, planner: Any) -> Any:
    """A graph that can be merged; raises InvalidGraph, naming the file."""
    from social_fleet.planning.routes.graph_changes import adapted
    from social_fleet.planning.routes.social_graph import SocialGraph
    graph = SocialGraph.load(path)
    if graph.counts is None:
        raise InvalidGraph("does not say how many paths used its edges; learn it again", source=path, field="counts")
    if graph.digest == planner.grid.digest:
        return graph
    try:
        graph, kept, dropped = adapted(graph, planner.grid)
    except InvalidGraph as error:
        raise InvalidGraph(error.message, source=path, field=error.field) from error
    if not kept:
        raise InvalidGraph("was learnt on another map, and none of its edges holds on this one", source=path,
                           field="map")
    log.warning("%s was learnt on another map: %d of its edges still hold on this one, %d are dropped", path, kept,
                dropped)
    return graph
