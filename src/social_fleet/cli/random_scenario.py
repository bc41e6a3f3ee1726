"""Make a scenario file: robots at random free poses of a map, each with a random goal that it can reach."""

import argparse
import os

from social_fleet.cli.arguments import check_outputs, count, positive, seed
from social_fleet.cli.output import show, written

SUMMARY = "make a scenario with random starts and goals"
EXAMPLE = "social_fleet random-scenario --map maps/environment_1.yaml --robots 8 --seed 1 --out eight.yaml"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """What the verb takes."""
    parser.add_argument("--map", required=True, metavar="M.yaml", help="the map, as map_server's YAML file")
    parser.add_argument("--robots", required=True, type=count, metavar="N", help="how many")
    parser.add_argument("--seed", type=seed, default=0, metavar="S", help="same seed, same scenario; default: 0")
    parser.add_argument("--radius", type=positive, default=0.25, metavar="M", help="of every robot [m]; default: 0.25")
    parser.add_argument("--max-speed", type=positive, default=0.7, metavar="V", help="[m/s]; default: 0.7")
    parser.add_argument("--mixed", action="store_true", help="speeds from a third of the maximum up to it")
    parser.add_argument("--out", required=True, metavar="scenario.yaml", help="the scenario file")


def run(args: argparse.Namespace) -> int:
    """Draw the poses and write the file."""
    check_outputs(args.out)
    from social_fleet.mapping.files import load_map
    from social_fleet.scenario.files import save_scenario, scenario_to_dict
    from social_fleet.scenario.locations import refer
    from social_fleet.scenario.random_fleet import random_scenario

    grid = load_map(args.map)
    scenario = random_scenario(grid, args.robots, seed=args.seed, max_speed=args.max_speed, radius=args.radius,
                               mixed=args.mixed, map_path=os.path.abspath(args.map),
                               map_name=refer(args.map, os.path.dirname(os.path.abspath(args.out))))
    save_scenario(scenario, args.out)
    show(args, scenario_to_dict(scenario),
         [f"{args.robots} robots on {scenario.map}, seed {args.seed}", *written(args.out)])
    return 0
