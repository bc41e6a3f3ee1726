"""Check a schedule independently of what made it: the smallest clearance of every pair of robots over all time."""

import argparse

from social_fleet.cli.output import show, table

SUMMARY = "check that no two robots of a schedule ever touch"
EXAMPLE = "social_fleet verify schedule.json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """What the verb takes."""
    parser.add_argument("schedule", metavar="schedule.json", help="made by coordinate, or by anybody else")


def run(args: argparse.Namespace) -> int:
    """Verify and print every pair, worst first; 1 when any two touch."""
    from social_fleet.coordination.files import read_schedule
    from social_fleet.coordination.verification import verify

    report = verify(read_schedule(args.schedule))
    pairs = [{"robot_r": first, "robot_s": second, "clearance": clearance, "time": time}
             for first, second, clearance, time in report.pairs]
    result = {"schedule": args.schedule, "safe": bool(report.safe),
              "min_clearance": report.min_clearance if pairs else None, "pairs": pairs}
    lines = table(["pair", "clearance m", "at s"],
                  [[f"{first} - {second}", f"{clearance:.3f}", f"{time:.1f}"]
                   for first, second, clearance, time in report.pairs]) if pairs else []
    touching = sum(clearance < 0.0 for _, _, clearance, _ in report.pairs)
    if not pairs:
        lines.append("safe: there is one robot only")
    elif report.safe:
        lines.append(f"safe: no two robots ever come closer than {report.min_clearance:.3f} m, surface to surface")
    else:
        lines.append(f"not safe: {touching} of {len(pairs)} pairs collide, the worst by "
                     f"{-report.min_clearance:.3f} m")
    show(args, result, lines)
    return 0 if report.safe else 1
