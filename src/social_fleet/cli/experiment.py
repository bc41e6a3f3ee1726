"""Run one of the paper's experiments again: NAME.json, NAME.csv and NAME.png, the paper's figures beside ours.

table2: length, right distance and time of A*, RRT* and the social planner. fig6: their paths. fig7: the social graph as
it grows, and round an obstacle. fig8: planning time on the graph. predictability: entropy of headings per place.
"""

import argparse
from typing import Any, Dict, List, Optional, Sequence

from social_fleet.cli.arguments import count, seed
from social_fleet.cli.output import show, table, written
from social_fleet.cli.progress import progress
from social_fleet.experiments import EXPERIMENTS

SUMMARY = "run one of the paper's experiments again"
EXAMPLE = "social_fleet experiment table2 --trials 100 --out results"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """What the verb takes."""
    parser.add_argument("name", choices=list(EXPERIMENTS), metavar="NAME", help=", ".join(EXPERIMENTS))
    parser.add_argument("--map", action="append", default=[], metavar="M.yaml",
                        help="a map of your own beside the paper's environments, for fig6 and fig7 in their stead; "
                             "may be given several times")
    parser.add_argument("--only", action="store_true", help="run on the maps of --map alone")
    parser.add_argument("--trials", type=count, metavar="N", help="random pairs or paths per map; default: the paper's")
    parser.add_argument("--seed", type=seed, default=0, metavar="S", help="same seed, same pairs; default: 0")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder for the files; created when not there")


def run(args: argparse.Namespace) -> int:
    """Run, write and sum up."""
    from social_fleet.experiments import experiment_named
    from social_fleet.experiments.frame import check_folder, write_result

    check_folder(args.name, args.out)
    experiment = experiment_named(args.name)
    worlds = experiment.worlds(args.map, only=args.only)
    with progress(100, args.name, "%") as update:
        result = experiment.run(worlds, trials=args.trials or experiment.trials, seed=args.seed,
                                progress=lambda share: update(round(100.0 * share)))
    paths = write_result(result, args.out)
    show(args, result.to_dict() if args.json else None, [*summary(result.rows), *written(*paths)])
    return 0


def summary(rows: Sequence[Dict[str, Any]]) -> List[str]:
    """The rows as a table; a mean with its standard deviation in one column, the paper's in the next."""
    if not rows:
        return []
    hidden = {key for key in rows[0] if key.endswith("_std") or all(row[key] is None for row in rows)}
    columns = [key for key in rows[0] if key not in hidden]
    columns.sort(key=lambda key: (_place(key, list(rows[0])), key.startswith("paper_")))
    return table([column.replace("_mean", "").replace("_", " ") for column in columns],
                 [[_cell(row, column) for column in columns] for row in rows])


def _place(key: str, order: Sequence[str]) -> int:
    """Where a column stands; the paper's figure directly behind ours."""
    return order.index(key[len("paper_"):] if key.startswith("paper_") else key)


def _cell(row: Dict[str, Any], key: str) -> str:
    value: Optional[Any] = row[key]
    spread = row.get(key[:-len("_mean")] + "_std") if key.endswith("_mean") else None
    text = "-" if value is None else f"{value:.3g}" if isinstance(value, float) else str(value)
    return text if spread is None else f"{text} ± {spread:.3g}"
