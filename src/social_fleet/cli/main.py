"""The command line: finds the verb, runs it, and turns what it raises into an exit code and one line.

Exit codes: 0 done; 1 a true negative answer (no path, no schedule, collision found, robot not arrived); 2 bad input;
130 interrupted; 70 a mistake in this program.
"""

import logging
import os
import sys
import traceback
from typing import List, Optional

from social_fleet.cli.parser import build_parser
from social_fleet.errors import Infeasible, InvalidInput, NoPath, NotReady, SocialFleetError, SolverFailed, TimedOut

DONE, NEGATIVE, BAD_INPUT, INTERNAL, INTERRUPTED, BROKEN_PIPE = 0, 1, 2, 70, 130, 141

_NEGATIVES = ((NoPath, "no path"), (Infeasible, "no schedule"), (TimedOut, "timed out"),
              (SolverFailed, "solver failed"), (NotReady, "not ready"))


def main(argv: Optional[List[str]] = None) -> int:
    """Run one command line and return its exit code; nothing escapes but `SystemExit` from ``--help``."""
    try:
        args = build_parser().parse_args(argv)
        _start_logging(args.verbose)
        code = int(args.run(args))
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception as error:
        return report(error)


def report(error: Exception) -> int:
    """Say on stderr what `error` means to a user, in one line, and return the exit code for it."""
    if isinstance(error, InvalidInput):
        _say("error", str(error))
        return BAD_INPUT
    if isinstance(error, SocialFleetError):
        _say(next((label for kind, label in _NEGATIVES if isinstance(error, kind)), "failed"), str(error))
        return NEGATIVE
    if isinstance(error, OSError) and error.strerror:
        _say("error", ": ".join(str(part) for part in (error.filename, error.strerror) if part))
        return BAD_INPUT
    traceback.print_exception(type(error), error, error.__traceback__)
    _say("error", "this is a mistake in social_fleet, not in your input; please report the lines above")
    return INTERNAL


def _say(label: str, message: str) -> None:
    print(f"{label}: {' '.join(message.split())}", file=sys.stderr)


def _start_logging(verbose: bool) -> None:
    logging.basicConfig(stream=sys.stderr, format="%(levelname)s: %(message)s", force=True,
                        level=logging.INFO if verbose else logging.WARNING)
    for level in (logging.INFO, logging.WARNING, logging.ERROR):
        logging.addLevelName(level, logging.getLevelName(level).lower())
    for chatty in ("matplotlib", "PIL", "numba"):
        logging.getLogger(chatty).setLevel(logging.WARNING)
