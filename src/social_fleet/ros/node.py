"""The life of every node: start, parameters, log, and an end that says in one line what went wrong."""

import logging
import sys
from typing import Callable, Optional

import rospy

from social_fleet.errors import SocialFleetError


class RosoutHandler(logging.Handler):
    """Hands what the core logs to rospy's log: console, file and /rosout."""

    def emit(self, record: logging.LogRecord) -> None:
        """Pass `record` on."""
        logging.getLogger("rosout").handle(record)


def bridge_log() -> None:
    """Route the core's stdlib log to rospy's, once."""
    core = logging.getLogger("social_fleet")
    if not any(isinstance(handler, RosoutHandler) for handler in core.handlers):
        core.addHandler(RosoutHandler())
        core.setLevel(logging.getLogger("rosout").getEffectiveLevel())
        core.propagate = False


def run(name: str, build: Callable[[], object], spin: Optional[Callable[[object], int]] = None) -> None:
    """Start node `name`, build what it consists of, and spin until shutdown.

    Leaves the process with 2 and one logged line when `build` refuses its parameters or files; otherwise with what
    `spin`, given the built object, returns.
    """
    rospy.init_node(name)
    bridge_log()
    try:
        node = build()
        code = spin(node) if spin is not None else _spin()
    except SocialFleetError as error:
        rospy.logfatal("%s", error)
        code = 2
    except rospy.ROSInterruptException:
        code = 0
    rospy.signal_shutdown("done")
    sys.exit(code)


def _spin() -> int:
    rospy.spin()
    return 0
