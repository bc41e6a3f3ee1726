"""How a tracker is: /diagnostics, and whether it keeps its control period."""

import time
from typing import Optional

import rospy

from social_fleet.execution.config import TrackerConfig
from social_fleet.execution.state import ProgressState
from social_fleet.execution.tracker import Tracker
from social_fleet.ros.diagnostics import Diagnostics, Health, Level

_LATE = 1.5  # periods without a command from which one counts as missed


class TrackerHealth:
    """Collects what `/diagnostics` shows of one tracker.

    Publishers
        /diagnostics: schedule (state, lag, tracking error), gate (whom it waits for), pose (age), control (missed
        periods).

    Parameters
    ----------
    robot
        Its name.
    tracker, config
        What is looked at.
    """

    def __init__(self, robot: str, tracker: Tracker, config: TrackerConfig) -> None:
        self._tracker, self._config = tracker, config
        self._now = 0.0
        self._pose_age: Optional[float] = None
        self._last: Optional[float] = None
        self.missed = 0  # control periods without a command
        self.periods = 0
        self.longest = 0.0  # between two commands [s, wall time]
        self._diagnostics = Diagnostics(robot, {"schedule": self._schedule, "gate": self._gate, "pose": self._pose,
                                                "control": self._control})
        self._told = 0

    def tick(self) -> None:
        """A control period begins: odometry has come."""
        now = time.monotonic()
        if self._tracker.arrived and self.missed > self._told:
            rospy.logwarn("%d of %d control periods had no command; the longest time between two was %.2f s",
                          self.missed, self.periods, self.longest)
            self._told = self.missed
        if self._last is not None and self._tracker.schedule is not None and not self._tracker.arrived:
            gap = now - self._last
            self.periods += 1
            self.longest = max(self.longest, gap)
            if gap > _LATE * self._config.period:
                self.missed += round(gap / self._config.period) - 1
        self._last = now

    def note(self, now: float, measured: Optional[float]) -> None:
        """A step was taken at `now` with a pose `measured` then [s, on the schedule's clock]."""
        self._now = now
        self._pose_age = None if measured is None else now - measured

    def update(self) -> None:
        """Publish when it is time to."""
        self._diagnostics.update()

    def _schedule(self) -> Health:
        tracker = self._tracker
        if tracker.schedule is None:
            return Level.OK, "has no schedule", {}
        lag = float(tracker.schedule.arc_length(self._now)) - tracker.progress
        values = {"state": tracker.state.name, "version": tracker.schedule.version, "lag [m]": lag,
                  "progress [m]": tracker.progress, "tracking error [m]": tracker.tracking_error,
                  "off its way [m]": tracker.excursion}
        if tracker.state is ProgressState.STOPPED:
            return Level.ERROR, tracker.reason, values
        return Level.OK, tracker.state.name.lower(), values

    def _gate(self) -> Health:
        waiting = self._tracker.waiting_for
        if waiting is None:
            return Level.OK, "waits for nobody", {}
        waited = self._now - waiting.since
        return Level.OK, f"waits for {waiting.other} at {waiting.at:.1f} m for {waited:.0f} s", {
            "robot": waiting.other, "at [m]": waiting.at, "until it has passed [m]": waiting.other_at,
            "for [s]": waited}

    def _pose(self) -> Health:
        if self._pose_age is None:
            return Level.ERROR, "the pose is not known", {}
        level = Level.WARN if self._pose_age > 0.5 * self._config.pose_timeout else Level.OK
        return level, f"{self._pose_age:.2f} s old", {"age [s]": self._pose_age}

    def _control(self) -> Health:
        values = {"periods": self.periods, "missed": self.missed, "longest [s]": self.longest}
        if self.missed:
            return Level.WARN, f"{self.missed} of {self.periods} control periods without a command", values
        return Level.OK, "every control period had its command", values
