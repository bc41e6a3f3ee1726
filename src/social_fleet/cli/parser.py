"""The argument parser: verbs, what they share, and errors in one line."""

import argparse
import re
from typing import Any, NoReturn

from social_fleet import __version__
from social_fleet.cli import (campaign, coordinate, experiment, learn, plan, random_scenario, report, simulate,
                              verify)
from social_fleet.errors import InvalidInput

VERBS = {"plan": plan, "learn": learn, "coordinate": coordinate, "verify": verify, "simulate": simulate,
         "campaign": campaign, "random-scenario": random_scenario, "experiment": experiment, "report": report}


class Parser(argparse.ArgumentParser):
    """Raises `InvalidInput` for a wrong command line, and takes -1e-3 for a number, not an option."""

    def __init__(self, **options: Any) -> None:
        super().__init__(formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False, **options)
        self._negative_number_matcher = re.compile(r"^-(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$|^-(inf|nan)$")

    def error(self, message: str) -> NoReturn:
        """Called by argparse with its sentence."""
        match = re.match(r"argument ([^:]+): (.*)", message, re.DOTALL)
        field, text = match.groups() if match else ("", message)
        raise InvalidInput(f"{text} (see {self.prog} --help)", source="command line", field=field)


def build_parser() -> Parser:
    """The parser of the whole program; `args.run` is the verb's function."""
    parser = Parser(prog="social_fleet", description=(
        "Socially consistent navigation of robot fleets: paths that keep to one side, schedules that never touch."),
        epilog="social_fleet VERB --help explains a verb and gives an example. "
               "Exit codes: 0 done, 1 a true negative answer (no path, a collision, …), 2 bad input.")
    parser.add_argument("--version", action="version", version=f"social_fleet {__version__}")
    verbs = parser.add_subparsers(metavar="VERB", dest="verb", parser_class=Parser)
    verbs.required = True
    for name, module in VERBS.items():
        verb = verbs.add_parser(name, help=module.SUMMARY, description=module.__doc__,
                                epilog=f"example:\n  {module.EXAMPLE}")
        module.add_arguments(verb)
        verb.add_argument("--json", action="store_true", help="print the result as JSON on stdout, and nothing else")
        verb.add_argument("--verbose", action="store_true", help="log what is done on stderr")
        verb.set_defaults(run=module.run)
    return parser
