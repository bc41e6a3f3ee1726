"""Where a frame is in the map, by tf2."""

from typing import Optional, Tuple

import genpy
import rospy
import tf2_ros

from social_fleet.geometry import Pose
from social_fleet.ros.conversions import UnknownFrame, pose_from_transform

POLL = 0.05  # [s] of wall time between two looks at a buffer that has not filled yet


class Frames:
    """A tf2 buffer with its listener."""

    def __init__(self, map_frame: str) -> None:
        self.map_frame = map_frame
        self._buffer = tf2_ros.Buffer(debug=False)
        self._listener = tf2_ros.TransformListener(self._buffer, queue_size=100, tcp_nodelay=True)

    def pose_of(self, frame: str) -> Pose:
        """The newest pose of `frame` in the map; raises UnknownFrame when tf knows none."""
        return self.stamped_pose_of(frame)[0]

    def stamped_pose_of(self, frame: str) -> Tuple[Pose, Optional[genpy.Time]]:
        """As `pose_of`, with the time of the oldest transform on the way; None when all of them are static."""
        try:
            transform = self._buffer.lookup_transform(self.map_frame, frame, rospy.Time())
            return pose_from_transform(transform.transform), transform.header.stamp or None
        except tf2_ros.TransformException as error:
            raise UnknownFrame(f"tf knows no way from '{self.map_frame}' to '{frame}': {error}") from error

    def between(self, parent: str, frame: str) -> Pose:
        """The newest pose of `frame` in `parent`; raises UnknownFrame when tf knows none."""
        try:
            return pose_from_transform(self._buffer.lookup_transform(parent, frame, rospy.Time()).transform)
        except tf2_ros.TransformException as error:
            raise UnknownFrame(f"tf knows no way from '{parent}' to '{frame}': {error}") from error

    def await_pose_of(self, frame: str, patience: float) -> Pose:
        """As `pose_of`, giving tf `patience` seconds of wall time to hear of the frame."""
        problem: Optional[UnknownFrame] = None
        for _ in range(max(1, round(patience / POLL))):
            try:
                return self.pose_of(frame)
            except UnknownFrame as error:
                problem = error
            rospy.rostime.wallsleep(POLL)
        assert problem is not None
        raise problem
