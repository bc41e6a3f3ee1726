"""A run that rosbag recorded, as the core's values: who drove where, by which schedules, and what happened when."""

from dataclasses import dataclass, field
from typing import Any, Dict, Iterator, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np
import rosbag
from rosbag.bag import ROSBagException
from scipy.optimize import linear_sum_assignment

from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import FleetSchedule, Schedule
from social_fleet.errors import InvalidInput
from social_fleet.files import PathLike
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.msg import NavigationStatus, Progress
from social_fleet.ros import conversions
from social_fleet.scenario.recording import Recording

_TOPICS = ("fleet/ground_truth", "fleet/progress", "fleet/schedules", "fleet/following", "fleet/navigation",
           "fleet/waiting", "map")
_SAMPLING = 0.1  # between two moments of the recording [s]
_SAME = 1.0  # as far as the true pose may be from the measured one for a robot to be recognised [m]
_GOAL_STATES = {value: name.lower() for name, value in vars(NavigationStatus).items() if name.isupper()}


class Event(NamedTuple):
    """Something that an operator would have seen."""

    time: float  # [s]
    robot: str
    what: str


@dataclass
class _Heard:
    """The messages of a bag that matter, sorted by what they are."""

    progress: Dict[str, List[Progress]] = field(default_factory=dict)
    schedules: Dict[str, Dict[int, Any]] = field(default_factory=dict)
    truth: List[Any] = field(default_factory=list)
    states: List[Any] = field(default_factory=list)
    waits: List[Any] = field(default_factory=list)
    map: Any = None


class RecordedRun:
    """Reads a bag.

    Parameters
    ----------
    path
        The bag's file; it must hold fleet/progress.

    Attributes
    ----------
    recording : Recording
        True poses where the bag holds fleet/ground_truth, measured ones otherwise.
    is_true : bool
        Which of both.
    fleet : FleetSchedule
        The last schedule of each robot, on the recording's clock; one without any stands where it was first seen.
    grid : OccupancyGrid, optional
        The map, where the bag holds it.
    schedules : mapping of str to int
        How many schedules each robot followed.
    events : tuple of Event
        In the order of time.

    Raises
    ------
    InvalidInput
        When the file is no bag, or holds no run.
    """

    def __init__(self, path: PathLike) -> None:
        heard = _read(path)
        if not heard.progress:
            raise InvalidInput("holds no message of fleet/progress; record that, fleet/schedules, fleet/waiting, "
                               "fleet/navigation, and map", source=str(path))
        self._zero = min(item.header.stamp for items in heard.progress.values() for item in items)
        names = sorted(heard.progress)
        self.grid: Optional[OccupancyGrid] = None if heard.map is None else conversions.grid_from_message(heard.map)
        self.schedules = {name: len(heard.schedules.get(name, ())) for name in names}
        self.recording, self.is_true = self._recording(names, heard)
        self.fleet = FleetSchedule(tuple(self._schedule(name, heard) for name in names))
        self.events = tuple(sorted(self._events(heard)))

    def _seconds(self, stamp: Any) -> float:
        return (stamp.secs - self._zero.secs) + 1e-9 * (stamp.nsecs - self._zero.nsecs)

    def _recording(self, names: Sequence[str], heard: _Heard) -> Tuple[Recording, bool]:
        tracks = {name: self._track(heard.progress[name]) for name in names}
        end = max(float(track[-1, 0]) for track in tracks.values())
        times = np.arange(0.0, max(end, _SAMPLING), _SAMPLING)
        measured = np.stack([_sampled(times, tracks[name][:, :4]) for name in names], axis=1)
        references = np.stack([_sampled(times, tracks[name][:, [0, 4, 5]]) for name in names], axis=1)
        truth = self._truth(times, measured, heard)
        return Recording(tuple(names), times, measured if truth is None else truth, references), truth is not None

    def _track(self, messages: Sequence[Progress]) -> np.ndarray:
        """Time, measured pose and reference, (N, 6)."""
        rows = np.array([(self._seconds(item.header.stamp), item.pose.x, item.pose.y, item.pose.theta,
                          item.reference.x, item.reference.y) for item in messages])
        known = rows[np.isfinite(rows).all(axis=1)]
        if not len(known):
            raise InvalidInput(f"robot {messages[0].robot} never knew where it was", source="fleet/progress")
        return known[np.unique(known[:, 0], return_index=True)[1]]

    def _truth(self, times: np.ndarray, measured: np.ndarray, heard: _Heard) -> Optional[np.ndarray]:
        """True poses in the robots' order, (T, R, 3); None without any. Who is who shows where they began."""
        messages = [item for item in heard.truth if len(item.poses) == measured.shape[1]]
        if not messages:
            return None
        stamps = np.array([self._seconds(item.header.stamp) for item in messages])
        stamps, first = np.unique(stamps, return_index=True)
        poses = np.array([[conversions.pose_from_message(pose) for pose in messages[index].poses] for index in first])
        sampled = np.stack([_sampled(times, np.column_stack((stamps, poses[:, robot])))
                            for robot in range(poses.shape[1])], axis=1)
        begin = int(np.searchsorted(times, max(stamps[0], 0.0)))
        begin = min(begin, len(times) - 1)
        gaps = np.hypot(*(measured[begin, :, None, :2] - sampled[begin, None, :, :2]).transpose(2, 0, 1))
        rows, columns = linear_sum_assignment(gaps)
        return sampled[:, columns] if gaps[rows, columns].max() < _SAME else None

    def _schedule(self, name: str, heard: _Heard) -> Schedule:
        messages = heard.schedules.get(name)
        if messages:
            last = messages[max(messages)]
            schedule = conversions.schedule_from_message(last, conversions.frame_name(last.header.frame_id))
            return schedule.shifted(self._seconds(last.header.stamp))
        x, y, yaw = self.recording.poses[0, self.recording.index(name)]
        radius = next((item.radius for item in heard.progress[name] if item.radius > 0.0), 0.25)
        return Schedule(Robot(name, np.array([[x, y]]), radius=radius, start_yaw=yaw, goal_yaw=yaw), np.zeros(1),
                        np.zeros(1))

    def _events(self, heard: _Heard) -> Iterator[Event]:
        for item in heard.states:
            why = f": {item.reason}" if item.reason else ""
            yield Event(self._seconds(item.header.stamp), item.robot,
                        f"{_GOAL_STATES.get(item.state, item.state)}{why}")
        for item in heard.waits:
            yield Event(self._seconds(item.header.stamp), item.robot, f"waits at {item.at:.1f} m: {item.reason}"
                        if item.waits else "goes on")
        for name, messages in heard.schedules.items():
            for version, message in messages.items():
                length = message.arc_lengths[-1] if message.arc_lengths else 0.0
                yield Event(self._seconds(message.header.stamp), name, f"schedule {version} begins, {length:.1f} m")
        for name, reports in heard.progress.items():
            for before, item in zip(reports, reports[1:]):
                if item.state == Progress.STOPPED and before.state != Progress.STOPPED:
                    yield Event(self._seconds(item.header.stamp), name, f"is stopped: {item.reason}")


def _read(path: PathLike) -> _Heard:
    """Sort the messages of a bag; raises InvalidInput when it is none."""
    heard = _Heard()
    try:
        with rosbag.Bag(str(path)) as bag:
            topics = [topic for topic in bag.get_type_and_topic_info().topics
                      if topic.strip("/").endswith(_TOPICS)]
            for topic, message, _ in bag.read_messages(topics=topics or ["fleet/progress"]):
                _sort(heard, topic, message)
    except (ROSBagException, OSError, UnicodeDecodeError) as error:
        raise InvalidInput(f"cannot be read as a bag: {error}", source=str(path)) from error
    return heard


def _sort(heard: _Heard, topic: str, message: Any) -> None:
    if topic.endswith("fleet/progress"):
        heard.progress.setdefault(message.robot, []).append(message)
    elif topic.endswith(("fleet/schedules", "fleet/following")):
        heard.schedules.setdefault(message.robot, {})[message.version] = message
    elif topic.endswith("fleet/ground_truth"):
        heard.truth.append(message)
    elif topic.endswith("fleet/navigation"):
        heard.states.append(message)
    elif topic.endswith("fleet/waiting"):
        heard.waits.append(message)
    else:
        heard.map = message


def _sampled(times: np.ndarray, track: np.ndarray) -> np.ndarray:
    """A track (N, 1 + K) of times and values at other times, (T, K); a third value is an angle."""
    columns = []
    for column in range(1, track.shape[1]):
        values = np.unwrap(track[:, column]) if column == 3 else track[:, column]
        columns.append(np.interp(times, track[:, 0], values))
    return np.stack(columns, axis=1)
