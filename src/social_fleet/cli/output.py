"""How results reach stdout: JSON and nothing else with ``--json``, sentences and tables without."""

import argparse
from typing import Any, List, Sequence

from social_fleet.files import dump_json


def show(args: argparse.Namespace, value: Any, lines: Sequence[str]) -> None:
    """Print `value` as JSON with ``--json``, else `lines`."""
    print(dump_json(value) if args.json else "\n".join(lines))


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> List[str]:
    """Lines of a table with aligned columns: the first to the left, the others to the right."""
    widths = [max(len(row[column]) for row in [header, *rows]) for column in range(len(header))]

    def line(cells: Sequence[str]) -> str:
        padded = [cell.ljust(width) if index == 0 else cell.rjust(width)
                  for index, (cell, width) in enumerate(zip(cells, widths))]
        return "  ".join(padded).rstrip()

    return [line(header), *(line(row) for row in rows)]


def written(*paths: Any) -> List[str]:
    """A line for each file that was asked for."""
    return [f"wrote {path}" for path in paths if path is not None]
