"""Drive many random fleets while much goes wrong, and judge every run: contacts, arrivals, waits without end, limits.

Run number k is drawn from the seed S + k alone. Runs that DIR holds already are not made again.
"""

import argparse
import re
from typing import Any, List, Tuple

from social_fleet.cli.arguments import count, seed
from social_fleet.cli.output import show
from social_fleet.cli.progress import progress

SUMMARY = "drive many random fleets with random faults"
EXAMPLE = "social_fleet campaign --runs 100 --seed 1 --robots 2..16 --out campaign"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """What the verb takes."""
    parser.add_argument("--runs", required=True, type=count, metavar="N", help="how many")
    parser.add_argument("--seed", required=True, type=seed, metavar="S", help="of the first run")
    parser.add_argument("--robots", type=robot_range, default=(2, 16), metavar="A..B",
                        help="fewest and most robots; default: 2..16")
    parser.add_argument("--out", required=True, metavar="DIR",
                        help="folder of summary.json, runs.jsonl, and a scenario with a picture for each failing run")


def robot_range(text: str) -> Tuple[int, int]:
    """``A..B``, or one number for both."""
    match = re.fullmatch(r"(\d+)(?:\.\.(\d+))?", text)
    if match is None or not 1 <= int(match.group(1)) <= int(match.group(2) or match.group(1)):
        raise argparse.ArgumentTypeError(f"must be A..B, two whole numbers from 1 on, such as 2..16, not {text!r}")
    return int(match.group(1)), int(match.group(2) or match.group(1))


def run(args: argparse.Namespace) -> int:
    """Draw, drive, judge, sum up; 1 when any run failed."""
    from social_fleet.errors import InvalidInput
    from social_fleet.scenario.campaign import Campaign

    try:
        campaign = Campaign(args.out, seed=args.seed, robots=args.robots)
    except OSError as error:
        raise InvalidInput(f"cannot be made: {error.strerror}; name another folder", source=args.out) from error
    with progress(args.runs, "runs", "runs") as update:
        summary = campaign.run(args.runs, progress=update)
    show(args, summary, lines(summary, args.out))
    return 0 if summary["passed"] == summary["runs"] else 1


def lines(summary: Any, folder: str) -> List[str]:
    """The summary in sentences."""
    text = [f"{summary['passed']} of {summary['runs']} runs passed: {summary['robots']} robots, {summary['arrived']} "
            f"arrived, {summary['excused']} had no way or died, {summary['stranded']} stranded",
            f"{summary['contacts']} contacts, {summary['exceeded']} limits exceeded, smallest clearance "
            f"{summary['min_clearance']:.3f} m" if summary["min_clearance"] is not None else
            f"{summary['contacts']} contacts, {summary['exceeded']} limits exceeded",
            f"{summary['simulated_time']:.0f} s simulated in {summary['wall_time']:.0f} s"]
    text += [f"seed {entry['seed']} ({entry['map']}): {'; '.join(entry['failures'])}" for entry in summary["failed"]]
    return text + [f"wrote {folder}/summary.json"]
