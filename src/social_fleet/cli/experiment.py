"""Run one of the paper's experiments again: NAME.json, NAME.csv and NAME.png, the paper's figures beside ours.

table2: length, right distance and time of A*, RRT* and the social planner. fig6: their paths. fig7: the social graph as
it grows, and round an obstacle. fig8: planning time on the graph. fig9: four robots of different speeds, coordinated.
fig10: whole fleets by our coordination, conflict-based search and prioritized planning. fig11: how much robots get into
each other's way. fig12, table3: encounter windows searched by one robot, and by the fleet in shares. fig14: head-on in
a hallway. fig15: robots at an intersection. predictability: entropy of headings per place.

What is finished is kept in DIR/NAME.cells: after an interruption the same command goes on where it was.
"""

import argparse
import os
import sys
from contextlib import ExitStack
from typing import Any, Callable, Dict, List, Optional, Sequence

from social_fleet.cli.arguments import count, positive, seed
from social_fleet.cli.output import show, table, written
from social_fleet.cli.progress import progress
from social_fleet.errors import InvalidInput
from social_fleet.experiments import EXPERIMENTS

SUMMARY = "run one of the paper's experiments again"
EXAMPLE = "social_fleet experiment table2 --trials 100 --out results"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """What the verb takes."""
    parser.add_argument("name", choices=list(EXPERIMENTS), metavar="NAME", help=", ".join(EXPERIMENTS))
    parser.add_argument("--map", action="append", default=[], metavar="M.yaml",
                        help="a map of your own beside the paper's environments, or in their stead where an experiment "
                             "draws one map; may be given several times")
    parser.add_argument("--only", action="store_true", help="run on the maps of --map alone")
    parser.add_argument("--trials", type=count, metavar="N",
                        help="random pairs, paths or fleets; doc/experiments.md says which; default: the paper's")
    parser.add_argument("--seed", type=seed, default=0, metavar="S", help="same seed, same pairs; default: 0")
    parser.add_argument("--limit", type=positive, metavar="S",
                        help="wall time for one solve in seconds, where there is a limit; default: the paper's")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder for the files; created when not there")


def run(args: argparse.Namespace) -> int:
    """Run, write and sum up."""
    from social_fleet.experiments import experiment_named
    from social_fleet.experiments.frame import check_folder, write_result

    check_folder(args.name, args.out)
    experiment = experiment_named(args.name)
    if args.limit is not None:
        if experiment.limit is None:
            raise InvalidInput(f"{args.name} has no limit for its solves", field="--limit")
        experiment.limit = args.limit
    worlds = experiment.worlds(args.map, only=args.only)
    with CellBar(args.name, args.out) as bar:
        result = experiment.run(worlds, trials=args.trials or experiment.trials, seed=args.seed, folder=args.out,
                                progress=bar.tell)
    paths = write_result(result, args.out)
    show(args, result.to_dict() if args.json else None, [*summary(result.rows), *written(*paths)])
    return 0


class CellBar(ExitStack):
    """A bar that shows how many cells are done and, when they are interrupted, a line that says how to go on."""

    def __init__(self, name: str, folder: str) -> None:
        super().__init__()
        self._name = name
        self._folder = folder
        self._update: Optional[Callable[[float], None]] = None
        self.push(self._interrupted)

    def tell(self, done: int, total: int) -> None:
        """Show that `done` of `total` cells are done."""
        if self._update is None:
            self._update = self.enter_context(progress(total, self._name, "cells", initial=done))
        self._update(done)

    def _interrupted(self, kind: Any, *_: Any) -> None:
        """Called when all is over, with the class of what ended it."""
        from social_fleet.experiments.cells import cells_file
        path = cells_file(self._name, self._folder)
        if kind is not None and issubclass(kind, KeyboardInterrupt):
            print("interrupted: " + (f"finished cells are kept in {path}; the same command goes on from there"
                                     if os.path.exists(path) else "nothing was finished"), file=sys.stderr)


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
    text = "-" if value is None else _number(value) if isinstance(value, float) else str(value)
    return text if spread is None else f"{text} ± {_number(spread)}"


def _number(value: float) -> str:
    """Three digits, or all before the point."""
    return f"{value:.3g}" if abs(value) < 1000.0 else f"{value:.0f}"
