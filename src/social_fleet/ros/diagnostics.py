"""/diagnostics of a node: functions that say how things are, asked once a second through diagnostic_updater."""

import time
from enum import IntEnum
from typing import Any, Callable, Dict, Tuple

import diagnostic_updater
import rospy
from diagnostic_msgs.msg import DiagnosticStatus


class Level(IntEnum):
    """Levels of a DiagnosticStatus."""

    OK = DiagnosticStatus.OK
    WARN = DiagnosticStatus.WARN
    ERROR = DiagnosticStatus.ERROR
    STALE = DiagnosticStatus.STALE


Health = Tuple[Level, str, Dict[str, Any]]
"""A level, a sentence, and values by name."""

_LOOK = 0.25  # between two looks at whether it is time [s, wall time]


class Diagnostics:
    """Publishes the health of several parts of a node.

    Parameters
    ----------
    hardware
        What the node belongs to: a robot's name, or ``fleet``.
    parts
        Functions that tell the health of a part, by its name.
    """

    def __init__(self, hardware: str, parts: Dict[str, Callable[[], Health]]) -> None:
        self._updater = diagnostic_updater.Updater()
        self._updater.setHardwareID(hardware)
        self._looked = 0.0
        for name, part in parts.items():
            self._updater.add(name, _task(part))

    def update(self) -> None:
        """Publish when it is time to; cheap otherwise."""
        now = time.monotonic()
        if now - self._looked >= _LOOK and not rospy.is_shutdown():
            self._looked = now
            self._updater.update()


def _task(part: Callable[[], Health]) -> Callable[[Any], Any]:
    def run(status: Any) -> Any:
        level, message, values = part()
        status.summary(int(level), message)
        for key, value in values.items():
            status.add(key, f"{value:.3f}" if isinstance(value, float) else str(value))
        return status
    return run
