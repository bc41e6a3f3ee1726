"""Messages to core values and back: pure functions that raise on what they do not know.

Schedules carry absolute time once, as the stamp of their header; all else is seconds after that stamp.
"""

import math
from dataclasses import replace
from typing import Any, List, Optional, Sequence, Tuple, Type

import genpy
import numpy as np
from geometry_msgs.msg import Point, Pose as PoseMessage, PoseStamped, Quaternion, Transform, Twist
from nav_msgs.msg import OccupancyGrid as GridMessage, Path
from social_fleet.msg import EncounterWindow as WindowMessage
from social_fleet.msg import PlannedPath, Precedence as PrecedenceMessage, Schedule as ScheduleMessage
from std_msgs.msg import Header

from social_fleet.coordination.robot import MotionLimits, Robot
from social_fleet.coordination.schedule import EncounterWindow, Precedence, Schedule
from social_fleet.errors import InvalidInput, InvalidMap, InvalidOverlay, InvalidPose, InvalidScenario
from social_fleet.geometry import Polyline, Pose
from social_fleet.mapping.grid import OccupancyGrid, Points
from social_fleet.planning.overlays.shapes import Cells, DiscObstacle, Polygon, Rectangle, Shape
from social_fleet.planning.plan import Plan
from social_fleet.srv import AddOverlayRequest

UNIT_TOLERANCE = 1e-2  # of a quaternion's norm: what clients round to, far from what they get wrong

_KINDS = (("intersection", WindowMessage.INTERSECTION),
          ("opposite_direction", WindowMessage.OPPOSITE_DIRECTION),
          ("same_direction", WindowMessage.SAME_DIRECTION))
_LIMITS = ("max_acceleration", "max_turn_rate", "max_turn_acceleration")


def frame_name(frame: str) -> str:
    """A tf2 frame name: tf's old leading slash is dropped."""
    return frame.lstrip("/")


class UnknownFrame(InvalidInput):
    """A message in a frame that its receiver does not work in, or that tf does not know."""


def check_frame(frame: str, expected: str, what: str) -> None:
    """Raise UnknownFrame unless `frame` is the frame `expected`; `what` names the message in the sentence."""
    if frame_name(frame) != expected:
        raise UnknownFrame(f"{what} is in frame '{frame}'; give it in '{expected}'")


def yaw_to_quaternion(yaw: float) -> Quaternion:
    """The unit quaternion of a turn by `yaw` [rad] about z."""
    return Quaternion(0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw))


def quaternion_to_yaw(quaternion: Quaternion, what: str = "pose", refuse: Type[InvalidPose] = InvalidPose) -> float:
    """Heading [rad] of `quaternion`; raises `refuse` when it is not finite or not of unit length."""
    x, y, z, w = quaternion.x, quaternion.y, quaternion.z, quaternion.w
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if not abs(norm - 1.0) <= UNIT_TOLERANCE:
        raise refuse(f"the orientation ({x:g}, {y:g}, {z:g}, {w:g}) of the {what} is not a unit quaternion; "
                     "w = 1 is no turn")
    return math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)


def pose_from_message(message: PoseMessage, what: str = "pose", refuse: Type[InvalidPose] = InvalidPose) -> Pose:
    """A planar pose; raises `refuse` when a value is not finite or the quaternion is not one."""
    if not (math.isfinite(message.position.x) and math.isfinite(message.position.y)):
        raise refuse(f"the position ({message.position.x:g}, {message.position.y:g}) of the {what} is not finite")
    return Pose(message.position.x, message.position.y, quaternion_to_yaw(message.orientation, what, refuse))


def pose_to_message(pose: Pose) -> PoseMessage:
    """A pose at height 0."""
    return PoseMessage(Point(pose.x, pose.y, 0.0), yaw_to_quaternion(pose.yaw))


def pose_from_stamped(message: PoseStamped, frame: str, what: str, refuse: Type[InvalidPose] = InvalidPose) -> Pose:
    """The pose in `frame`; raises UnknownFrame when the message is in another one, otherwise `refuse`."""
    check_frame(message.header.frame_id, frame, f"the {what}")
    return pose_from_message(message.pose, what, refuse)


def pose_to_stamped(pose: Pose, frame: str, stamp: genpy.Time = genpy.Time()) -> PoseStamped:
    """The pose with its frame."""
    return PoseStamped(Header(stamp=stamp, frame_id=frame), pose_to_message(pose))


def pose_from_transform(message: Transform) -> Pose:
    """The planar part of a transform."""
    return Pose(message.translation.x, message.translation.y, quaternion_to_yaw(message.rotation, "transform"))


def twist_to_message(speed: float, turn_rate: float) -> Twist:
    """The command of a differential drive."""
    twist = Twist()
    twist.linear.x, twist.angular.z = speed, turn_rate
    return twist


def grid_from_message(message: GridMessage) -> OccupancyGrid:
    """The map; raises InvalidMap when its size and its data differ or its origin is no pose."""
    info = message.info
    if info.width * info.height != len(message.data) or len(message.data) == 0:
        raise InvalidMap(f"the map claims {info.width} x {info.height} cells and holds {len(message.data)}")
    try:
        origin = pose_from_message(info.origin, "map origin")
    except InvalidPose as error:
        raise InvalidMap(error.message) from error
    values = np.asarray(message.data, dtype=np.int8).reshape(info.height, info.width)
    return OccupancyGrid(values, float(round(info.resolution, 7)), origin)


def grid_to_message(grid: OccupancyGrid, frame: str, stamp: genpy.Time) -> GridMessage:
    """The map as map_server would publish it."""
    message = GridMessage(header=Header(stamp=stamp, frame_id=frame))
    message.info.map_load_time = stamp
    message.info.resolution = grid.resolution
    message.info.height, message.info.width = grid.shape
    message.info.origin = pose_to_message(grid.origin)
    message.data = np.asarray(grid.values, dtype=np.int8).ravel().tolist()
    return message


def path_to_message(points: np.ndarray, goal_yaw: Optional[float], frame: str, stamp: genpy.Time) -> Path:
    """Every pose looks along the path; the last one has the goal's heading."""
    line = Polyline(points)
    headings = line.segment_headings if len(line.points) > 1 else np.zeros(0)
    last = goal_yaw if goal_yaw is not None else (float(headings[-1]) if len(headings) else 0.0)
    yaws = np.append(headings, last)
    message = Path(header=Header(stamp=stamp, frame_id=frame))
    message.poses = [pose_to_stamped(Pose(float(x), float(y), float(yaw)), frame, stamp)
                     for (x, y), yaw in zip(line.points, yaws)]
    return message


def path_from_message(message: Path, frame: str, what: str = "path") -> Tuple[np.ndarray, float]:
    """Points (N, 2) [m, `frame`] and the heading at the goal [rad]; raises InvalidInput for an empty path."""
    check_frame(message.header.frame_id, frame, f"the {what}")
    if not message.poses:
        raise InvalidInput(f"the {what} is empty")
    points = np.array([(stamped.pose.position.x, stamped.pose.position.y) for stamped in message.poses])
    if not np.isfinite(points).all():
        raise InvalidInput(f"the {what} holds a position that is not finite")
    return points, quaternion_to_yaw(message.poses[-1].pose.orientation, f"last pose of the {what}")


def plan_to_planned_path(plan: Plan, robot: str, max_speed: float, frame: str, stamp: genpy.Time) -> PlannedPath:
    """What a planner tells the fleet about a plan."""
    message = PlannedPath(header=Header(stamp=stamp, frame_id=frame), robot=robot, max_speed=max_speed,
                          radius=plan.robot_radius, temporary=plan.temporary)
    message.path = path_to_message(plan.points, plan.goal_yaw, frame, stamp)
    if plan.start_yaw is not None:
        message.start_orientation = yaw_to_quaternion(plan.start_yaw)
    return message


def robot_from_planned_path(message: PlannedPath, frame: str) -> Robot:
    """Raises InvalidInput (or its InvalidScenario) that names the robot and the field."""
    return _robot_from(message, frame, message.depart)


def shape_from_request(request: AddOverlayRequest, frame: str, grid: OccupancyGrid) -> Shape:
    """The obstacle in a request; raises UnknownFrame, or InvalidOverlay by its field."""
    check_frame(request.header.frame_id, frame, f"the obstacle '{request.name}'")
    x, y = request.pose.position.x, request.pose.position.y
    if request.shape == AddOverlayRequest.DISC:
        return DiscObstacle(x, y, request.radius)
    if request.shape == AddOverlayRequest.RECTANGLE:
        try:
            yaw = _optional_yaw(request.pose.orientation, "rectangle") or 0.0
        except InvalidPose as error:
            raise InvalidOverlay(error.message, field="pose") from error
        return Rectangle(x, y, request.width, request.height, yaw)
    points = tuple((point.x, point.y) for point in request.points)
    if request.shape == AddOverlayRequest.POLYGON:
        return Polygon(points)
    if request.shape == AddOverlayRequest.CELLS:
        return Cells(points, grid.resolution)
    raise InvalidOverlay(f"{request.shape} is none of AddOverlay's shapes", field="shape")


def schedule_to_message(schedule: Schedule, frame: str, time_zero: genpy.Time) -> ScheduleMessage:
    """A schedule whose times count from `time_zero`."""
    message = ScheduleMessage(header=Header(stamp=time_zero, frame_id=frame), version=schedule.version,
                              arc_lengths=schedule.arc_lengths.tolist(), times=schedule.times.tolist())
    robot = schedule.robot
    message.robot, message.max_speed, message.radius = robot.name, robot.max_speed, robot.body_radius
    message.path = path_to_message(robot.path.points, robot.goal.yaw, frame, time_zero)
    if robot.start_yaw is not None:
        message.start_orientation = yaw_to_quaternion(robot.start_yaw)
    for name in (*_LIMITS, "weight"):
        setattr(message, name, getattr(robot, name))
    message.any_goal_heading, message.peers = robot.goal_yaw is None, list(schedule.peers)
    message.under_way, message.committed = robot.committed is not None, robot.committed or 0.0
    message.precedences = precedences_to_messages(schedule.precedences)
    return message


def precedences_to_messages(precedences: Sequence[Precedence]) -> List[PrecedenceMessage]:
    """What a schedule message holds of them."""
    return [PrecedenceMessage(at=item.at, other=item.other, other_at=item.other_at, other_version=item.other_version)
            for item in precedences]


def schedule_from_message(message: ScheduleMessage, frame: str) -> Schedule:
    """Times count from the header's stamp; raises InvalidInput or InvalidSchedule."""
    precedences = tuple(Precedence(item.at, item.other, item.other_at, item.other_version)
                        for item in message.precedences)
    robot = replace(_robot_from(message, frame, 0.0), weight=message.weight or 1.0,
                    committed=message.committed if message.under_way else None)
    if message.any_goal_heading:
        robot = replace(robot, goal_yaw=None)
    return Schedule(robot, np.array(message.arc_lengths), np.array(message.times), precedences, message.version,
                    tuple(message.peers))


def window_to_message(window: EncounterWindow, version: int) -> WindowMessage:
    """A window of coordination `version`; raises InvalidInput for a kind that the message has no constant for."""
    kinds = dict(_KINDS)
    if window.kind not in kinds:
        raise InvalidInput(f"an encounter window is one of {', '.join(kinds)}, not '{window.kind}'")
    return WindowMessage(robot_r=window.robot_r, robot_s=window.robot_s, kind=kinds[window.kind],
                         r_enter=window.r_enter, r_exit=window.r_exit, s_enter=window.s_enter,
                         s_exit=window.s_exit, first=window.first, version=version)


def window_from_message(message: WindowMessage) -> EncounterWindow:
    """Raises InvalidInput for a kind that is none of the message's constants."""
    names = {number: name for name, number in _KINDS}
    if message.kind not in names:
        raise InvalidInput(f"kind {message.kind} is none of an EncounterWindow's constants")
    return EncounterWindow(message.robot_r, message.robot_s, names[message.kind], message.r_enter, message.r_exit,
                           message.s_enter, message.s_exit, message.first)


def _robot_from(message: Any, frame: str, depart: float) -> Robot:
    what = f"path of robot '{message.robot}'"
    points, goal_yaw = path_from_message(message.path, frame, what)
    limits = {name: getattr(message, name) or getattr(MotionLimits, name) for name in _LIMITS}
    if message.robot != message.robot.strip("/") or not message.robot:
        raise InvalidScenario(f"'{message.robot}' is no robot's name: it must not be empty or start with a slash",
                              field="robot")
    return Robot(message.robot, points, message.max_speed, message.radius, depart,
                 _optional_yaw(message.start_orientation, f"start of the {what}"), goal_yaw, **limits)


def _optional_yaw(quaternion: Quaternion, what: str) -> Optional[float]:
    """None for the all-zero quaternion, which is what a field holds that nobody set."""
    if not any((quaternion.x, quaternion.y, quaternion.z, quaternion.w)):  # of a bag's own classes, too
        return None
    return quaternion_to_yaw(quaternion, what)


def points_to_messages(points: Points) -> List[Point]:
    """Points of a marker, at height 0."""
    return [Point(float(x), float(y), 0.0) for x, y in points]
