"""What the coordinator tells the planner: obstacles that the fleet has seen, and paths that robots drive."""

import threading
from typing import Dict, Mapping

import rospy
from geometry_msgs.msg import Pose as PoseMessage

from social_fleet.msg import Assignment, PlannedPath
from social_fleet.planning.overlays.shapes import DiscObstacle
from social_fleet.ros.background import BackgroundWork
from social_fleet.srv import AddOverlay, AddOverlayRequest, AddOverlayResponse, ClearOverlay

_PRESENCE = 1.0  # that a service is waited for [s, wall time]


class PlannerNotices:
    """Keeps the planner's obstacles those of the fleet, and announces paths, for it learns from them.

    Publishers
        fleet/paths (PlannedPath): a robot's path to a new goal, and detours.
    Services called
        social_planner/add_overlay (AddOverlay), social_planner/clear_overlay (ClearOverlay).

    Parameters
    ----------
    frame
        The map's frame.
    """

    def __init__(self, frame: str) -> None:
        self._frame = frame
        self._lock = threading.Lock()
        self._wanted: Dict[str, DiscObstacle] = {}
        self._there: Dict[str, DiscObstacle] = {}
        self._announced: Dict[str, tuple] = {}
        self._add = rospy.ServiceProxy("social_planner/add_overlay", AddOverlay)
        self._clear = rospy.ServiceProxy("social_planner/clear_overlay", ClearOverlay)
        self._paths = rospy.Publisher("fleet/paths", PlannedPath, queue_size=100)
        self._mirroring = BackgroundWork(self._mirror, "telling the planner of obstacles")

    def show(self, obstacles: Mapping[str, DiscObstacle]) -> None:
        """The fleet's obstacles are these; returns at once."""
        with self._lock:
            changed = obstacles != self._wanted
            self._wanted = dict(obstacles)
        if changed:
            self._mirroring.request()

    def announce(self, assignment: Assignment) -> None:
        """Tell of the path of a schedule, once for each goal and for each detour on the way there."""
        schedule, key = assignment.schedule, (assignment.errand, assignment.temporary)
        if not assignment.errand or assignment.reason or self._announced.get(schedule.robot) == key:
            return
        self._announced[schedule.robot] = key
        message = PlannedPath(header=schedule.header, robot=schedule.robot, path=schedule.path,
                              start_orientation=schedule.start_orientation, temporary=assignment.temporary)
        for name in ("max_speed", "radius", "max_acceleration", "max_turn_rate", "max_turn_acceleration"):
            setattr(message, name, getattr(schedule, name))
        self._paths.publish(message)

    def _mirror(self) -> None:
        """In a thread of its own."""
        with self._lock:
            wanted = dict(self._wanted)
        try:
            for name in sorted(set(self._there) - set(wanted)):
                rospy.wait_for_service(self._clear.resolved_name, _PRESENCE)
                self._clear(name)
                del self._there[name]
            for name, shape in sorted(wanted.items()):
                if self._there.get(name) != shape:
                    rospy.wait_for_service(self._add.resolved_name, _PRESENCE)
                    self._put(name, shape)
        except (rospy.ROSException, rospy.ServiceException) as error:
            rospy.logwarn_throttle(30.0, "the planner does not hear of obstacles: %s" % error)

    def _put(self, name: str, shape: DiscObstacle) -> None:
        request = AddOverlayRequest(name=name, shape=AddOverlayRequest.DISC, pose=PoseMessage(), radius=shape.radius)
        request.header.frame_id = self._frame
        request.pose.position.x, request.pose.position.y, request.pose.orientation.w = shape.x, shape.y, 1.0
        answer = self._add(request)
        if answer.status == AddOverlayResponse.SUCCESS:
            self._there[name] = shape
