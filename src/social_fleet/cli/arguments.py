"""Kinds of argument that several verbs take, and what they do first with them."""

import argparse
import math
import os
from typing import Any, List, Optional, Sequence, Union

from social_fleet.errors import InvalidInput
from social_fleet.files import check_writable, is_special


class PoseAction(argparse.Action):
    """Takes ``X Y [YAW]``."""

    def __call__(self, parser: argparse.ArgumentParser, namespace: argparse.Namespace,
                 values: Union[str, Sequence[Any], None], option_string: Optional[str] = None) -> None:
        """Called by argparse."""
        numbers: List[Any] = list(values or ())
        if len(numbers) not in (2, 3):
            parser.error(f"argument {option_string}: expects X Y [YAW] in metres and radians, not "
                         f"{len(numbers)} number{'s' if len(numbers) != 1 else ''}")
        setattr(namespace, self.dest, tuple(numbers))


def add_pose(parser: argparse.ArgumentParser, flag: str, help: str) -> None:
    """Let `parser` take a pose; its value is a tuple of two or three floats, or None."""
    parser.add_argument(flag, nargs="+", type=number, action=PoseAction, metavar=("X", "Y [YAW]"), help=help)


def add_zones(parser: argparse.ArgumentParser) -> None:
    """Let `parser` take a file of zones."""
    parser.add_argument("--zones", metavar="Z.yaml",
                        help="parts of the map with norms of their own, none for none; default: M.zones.yaml beside "
                             "the map, where there is one")


def number(text: str) -> float:
    """A float; NaN passes, for those who judge poses to refuse."""
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be a number, not {text!r}") from None


def positive(text: str) -> float:
    """A finite float above zero."""
    value = number(text)
    if not (math.isfinite(value) and value > 0.0):
        raise argparse.ArgumentTypeError(f"must be a positive number, not {text!r}")
    return value


def count(text: str) -> int:
    """A whole number from 1 on."""
    return _whole(text, 1)


def seed(text: str) -> int:
    """A whole number from 0 on."""
    return _whole(text, 0)


def _whole(text: str, least: int) -> int:
    try:
        value = int(text)
    except ValueError:
        value = least - 1
    if value < least:
        raise argparse.ArgumentTypeError(f"must be a whole number from {least} on, not {text!r}")
    return value


def check_outputs(*paths: Optional[str]) -> None:
    """Refuse files that cannot be written before any work starts; None is an output that nobody wants.

    Raises
    ------
    InvalidInput
        With the path as its source.
    """
    wanted = [path for path in paths if path is not None]
    for path in wanted:
        check_writable(path)
        if [os.path.realpath(other) for other in wanted].count(os.path.realpath(path)) > 1 and not is_special(path):
            raise InvalidInput("is named for two outputs; give each a file of its own", source=path)
