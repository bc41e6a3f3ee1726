"""Run the benchmarks that are named on the command line, or all."""

import importlib
import sys

SUBJECTS = ("planning", "global_planner", "learning", "steadiness", "head_on",
            "coordination", "fleets", "simulation", "execution", "nodes", "control", "move_base",
            "amcl", "gmapping")


def main() -> int:
    """Exit code 2 for a name that is not a benchmark, 1 when a figure that must hold does not."""
    names = sys.argv[1:] or list(SUBJECTS)
    unknown = [name for name in names if name not in SUBJECTS]
    if unknown:
        print(f"error: {unknown[0]}: no such benchmark; there are {', '.join(SUBJECTS)}", file=sys.stderr)
        return 2
    held = True
    for name in names:
        print(f"\n== {name}", flush=True)
        held &= importlib.import_module(f"benchmarks.{name}").run(lambda line: print("  " + line, flush=True))
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
