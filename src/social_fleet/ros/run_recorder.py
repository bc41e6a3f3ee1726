"""Listens to a run: true poses from the simulation, progress from the trackers."""

import threading
from typing import Dict, List, Optional, Sequence, Set, Tuple

import genpy
import numpy as np
import rospy
from geometry_msgs.msg import PoseArray

from social_fleet.msg import Progress
from social_fleet.ros.conversions import pose_from_message
from social_fleet.scenario.recording import Recording


class RunRecorder:
    """Records from `begin` on.

    Parameters
    ----------
    names
        The robots, in the order of fleet/ground_truth.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self.now = 0.0  # newest recorded time, on the clock of `begin` [s]
        self._lock = threading.Lock()
        self._time_zero: Optional[genpy.Time] = None
        self._truth: List[PoseArray] = []
        self._references: Dict[str, List[Tuple[float, float, float]]] = {name: [] for name in names}
        self._last: Dict[str, Progress] = {}
        rospy.Subscriber("fleet/ground_truth", PoseArray, self._hear_truth, queue_size=1000, tcp_nodelay=True)
        rospy.Subscriber("fleet/progress", Progress, self._hear_progress, queue_size=1000)

    def begin(self, time_zero: genpy.Time) -> None:
        """Times count from `time_zero`; what was before is left out."""
        with self._lock:
            self._time_zero = time_zero

    def _hear_truth(self, message: PoseArray) -> None:
        with self._lock:
            if self._time_zero is not None and message.header.stamp >= self._time_zero:
                self._truth.append(message)
                self.now = self._seconds(message.header.stamp)

    def _hear_progress(self, message: Progress) -> None:
        with self._lock:
            self._last[message.robot] = message
            if self._time_zero is not None and message.robot in self._references:
                self._references[message.robot].append((self._seconds(message.header.stamp), message.reference.x,
                                                        message.reference.y))

    def _seconds(self, stamp: genpy.Time) -> float:
        assert self._time_zero is not None
        return (stamp.secs - self._time_zero.secs) + 1e-9 * (stamp.nsecs - self._time_zero.nsecs)

    def following(self, version: int) -> Set[str]:
        """The robots whose trackers follow schedule `version`, or any later one."""
        with self._lock:
            return {name for name, message in self._last.items() if message.schedule_version >= version}

    @property
    def arrived(self) -> Set[str]:
        """The robots whose trackers say so."""
        with self._lock:
            return {name for name, message in self._last.items() if message.state == Progress.ARRIVED}

    def recording(self) -> Recording:
        """What was recorded; references are interpolated between the trackers' reports."""
        with self._lock:
            times = np.array([self._seconds(message.header.stamp) for message in self._truth])
            poses = np.array([[pose_from_message(pose) for pose in message.poses] for message in self._truth])
            references = np.full(poses.shape[:2] + (2,), np.nan)
            for index, name in enumerate(self.names):
                known = np.array(sorted(set(self._references[name]))).reshape(-1, 3)
                for axis in (1, 2):
                    if len(known):
                        references[:, index, axis - 1] = np.interp(times, known[:, 0], known[:, axis])
        rising = np.append(True, np.diff(times) > 0.0)
        return Recording(self.names, times[rising], poses[rising], references[rising])
