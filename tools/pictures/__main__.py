"""Draw the pictures that are named on the command line, or all."""

import os
import sys

from .norms import PICTURES

FOLDER = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "doc", "pictures")


def main() -> int:
    """Exit code 2 for a name that is not a picture."""
    names = sys.argv[1:] or sorted(PICTURES)
    unknown = [name for name in names if name not in PICTURES]
    if unknown:
        print(f"error: {unknown[0]}: no such picture; there are {', '.join(sorted(PICTURES))}", file=sys.stderr)
        return 2
    for name in names:
        path = os.path.join(FOLDER, f"{name}.png")
        PICTURES[name](path)
        print(f"{name}: {os.path.getsize(path) // 1000} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
