"""Where the robot really is beside its reference: progress, errors, and the way back."""

from social_fleet.execution.config import TrackerConfig
from social_fleet.execution.course import Course, distance
from social_fleet.geometry import Pose

_REJOIN = 2.0  # how far along the path a stopped robot may have been moved to drive on from there [m]
_WINDOW = 0.5  # how far around the reference the robot is looked for on its path [m]


class Whereabouts:
    """What the poses of one robot say of its way.

    Parameters
    ----------
    config : TrackerConfig
        Tolerances.

    Attributes
    ----------
    progress : float
        Arc length that the robot was measured to have reached [m]; never falls on one path.
    tracking_error : float
        Distance between the measured pose and the reference [m].
    excursion : float
        Distance between the measured pose and the way from the robot's progress to the reference [m]: what the robot
        is aside, ahead of its reference, or behind what it reported; mere lag is none.
    returning : bool
        Whether the robot is creeping back to its path.
    lost : bool
        Whether it stands where it cannot drive on on this path.
    """

    def __init__(self, config: TrackerConfig) -> None:
        self._config = config
        self.progress = 0.0
        self.tracking_error = 0.0
        self.excursion = 0.0
        self.returning = False
        self.lost = False

    def begin(self, progress: float = 0.0) -> None:
        """Another path begins."""
        self.progress = progress
        self.returning = False
        self.lost = False

    def observe(self, pose: Pose, course: Course) -> None:
        """Measure errors and progress."""
        self.tracking_error = distance(pose, course.reference)
        reference = course.governor.arc_length
        high = min(reference + _WINDOW, course.next_stop.arc_length)
        if high > self.progress:
            low = min(max(self.progress, reference - _WINDOW), high)
            reached = course.path.project(pose.x, pose.y, low, high)
            if (reached > self.progress and distance(pose, course.path.pose(course.driven_leg, reached))
                    <= 0.5 * self._config.deviation_limit):  # off its path it has reached nothing
                self.progress = reached
        low = min(max(self.progress, course.last_stop.arc_length), reference)
        arc_length = course.path.project(pose.x, pose.y, low, reference) if low < reference else reference
        self.excursion = distance(pose, course.path.pose(course.driven_leg, arc_length))

    def trouble(self) -> str:
        """Why the robot is not where it may be, as a sentence; empty when it is."""
        if self.returning or self.excursion > self._config.lateral_limit:
            return f"the robot is {self.excursion:.2f} m off its way"
        if self.tracking_error > self._config.deviation_limit:
            return f"the robot is {self.tracking_error:.2f} m off its reference"
        self.lost = False
        return ""

    def rejoin(self, pose: Pose, course: Course) -> str:
        """Bring the reference back to a robot that stands near its path, only not where it ought to be; or why not.

        A robot that is too far aside creeps to the reference before it drives on. None rejoins behind what it has
        reported: others rely on its having passed.
        """
        here = course.governor.arc_length
        low = max(course.last_stop.arc_length, here - _REJOIN)
        high = max(min(course.next_stop.arc_length, here + _REJOIN), low)
        arc_length = course.path.project(pose.x, pose.y, low, high)
        gap = distance(course.path.pose(course.driven_leg, arc_length), pose)
        behind = self.progress - arc_length
        self.lost = gap > 0.5 * self._config.deviation_limit or behind > self._config.release_tolerance
        if self.lost:
            self.returning = False
            if gap > 0.5 * self._config.deviation_limit:
                return f"the robot is {gap:.2f} m off its path"
            return f"the robot is {behind:.2f} m behind the progress that others rely on; it needs a new path"
        if not self.returning or gap <= 0.5 * self._config.lateral_limit:
            course.place(arc_length)
        self.returning = gap > 0.5 * self._config.lateral_limit
        self.tracking_error, self.excursion = distance(course.reference, pose), gap
        return ""
