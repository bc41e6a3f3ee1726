"""Messages to core values and back; what a conversion does not know, it refuses."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("social_fleet.msg", reason="needs the built workspace's messages; tools/test has them")

import genpy  # noqa: E402
from geometry_msgs.msg import Point, PoseStamped, Quaternion  # noqa: E402
from nav_msgs.msg import OccupancyGrid as GridMessage  # noqa: E402

from social_fleet.coordination.robot import Robot  # noqa: E402
from social_fleet.coordination.schedule import EncounterWindow, Precedence, Schedule  # noqa: E402
from social_fleet.errors import (InvalidInput, InvalidMap, InvalidOverlay, InvalidPose, InvalidScenario,  # noqa: E402
                                 InvalidSchedule, InvalidStart)
from social_fleet.geometry import Pose  # noqa: E402
from social_fleet.mapping.grid import OccupancyGrid  # noqa: E402
from social_fleet.msg import PlannedPath  # noqa: E402
from social_fleet.planning.overlays.shapes import Cells, DiscObstacle, Polygon, Rectangle  # noqa: E402
from social_fleet.ros import conversions  # noqa: E402
from social_fleet.srv import AddOverlayRequest  # noqa: E402

STAMP = genpy.Time(7, 500_000_000)
CORNER = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 3.0)])


def sent(message: Any) -> Any:
    """The message as its receiver gets it, through the wire format."""
    from io import BytesIO
    buffer = BytesIO()
    message.serialize(buffer)
    return type(message)().deserialize(buffer.getvalue())


@pytest.mark.parametrize("yaw", [0.0, 1.0, -3.0, math.pi])
def test_yaw_survives(yaw: float) -> None:
    assert conversions.quaternion_to_yaw(conversions.yaw_to_quaternion(yaw)) == pytest.approx(yaw)


@pytest.mark.parametrize("values", [(0, 0, 0, 0), (0, 0, 0, 1.1), (1, 0, 0, 1), (0, 0, math.nan, 1),
                                    (0, 0, math.inf, 0)])
def test_what_is_no_unit_quaternion_is_refused(values: Any) -> None:
    with pytest.raises(InvalidStart, match="start is not a unit quaternion"):
        conversions.quaternion_to_yaw(Quaternion(*values), "start", InvalidStart)


def test_a_quaternion_rounded_by_hand_is_accepted() -> None:
    assert conversions.quaternion_to_yaw(Quaternion(0.0, 0.0, 0.707, 0.707)) == pytest.approx(math.pi / 2)


def test_a_pose_keeps_its_frame_and_loses_its_slash() -> None:
    message = conversions.pose_to_stamped(Pose(1.0, 2.0, 0.5), "map", STAMP)
    assert conversions.pose_from_stamped(message, "map", "goal") == pytest.approx((1.0, 2.0, 0.5))
    message.header.frame_id = "/map"
    assert conversions.pose_from_stamped(message, "map", "goal").x == 1.0


@pytest.mark.parametrize("frame", ["", "odom", "gold/map"])
def test_another_frame_is_refused_by_its_name(frame: str) -> None:
    message = conversions.pose_to_stamped(Pose(1.0, 2.0), frame)
    with pytest.raises(conversions.UnknownFrame, match=f"the goal is in frame '{frame}'; give it in 'map'"):
        conversions.pose_from_stamped(message, "map", "goal")


@pytest.mark.parametrize("x", [math.nan, math.inf])
def test_a_position_that_is_not_finite_is_refused(x: float) -> None:
    with pytest.raises(InvalidPose, match="not finite"):
        conversions.pose_from_message(conversions.pose_to_message(Pose(x, 0.0)))


def test_a_map_survives_with_its_yaw() -> None:
    grid = OccupancyGrid(np.array([[0, 100, -1], [50, 0, 0]], dtype=np.int8), 0.05, Pose(-3.0, 4.0, 0.3))
    back = conversions.grid_from_message(sent(conversions.grid_to_message(grid, "map", STAMP)))
    assert back.values.tolist() == grid.values.tolist()
    assert back.resolution == 0.05  # not the float32 that carried it
    assert tuple(back.origin) == pytest.approx(tuple(grid.origin))


def broken_map(**changes: Any) -> GridMessage:
    message = conversions.grid_to_message(OccupancyGrid(np.zeros((2, 3), dtype=np.int8), 0.1), "map", STAMP)
    for name, value in changes.items():
        setattr(message.info, name, value)
    return message


@pytest.mark.parametrize("changes", [{"width": 4}, {"height": 0, "width": 0}, {"resolution": 0.0},
                                     {"resolution": math.nan}])
def test_a_map_that_does_not_fit_together_is_refused(changes: Any) -> None:
    with pytest.raises(InvalidMap):
        conversions.grid_from_message(broken_map(**changes))


def test_a_map_whose_origin_is_no_pose_is_refused() -> None:
    message = broken_map()
    message.info.origin.orientation.w = 0.0
    with pytest.raises(InvalidMap, match="map origin"):
        conversions.grid_from_message(message)


def test_a_path_looks_ahead_and_ends_with_the_goals_heading() -> None:
    message = conversions.path_to_message(CORNER, -1.0, "map", STAMP)
    yaws = [conversions.quaternion_to_yaw(item.pose.orientation) for item in message.poses]
    assert yaws == pytest.approx([0.0, math.pi / 2, -1.0])
    points, goal_yaw = conversions.path_from_message(sent(message), "map")
    assert points.tolist() == CORNER.tolist()
    assert goal_yaw == pytest.approx(-1.0)


def test_a_path_without_a_goal_heading_ends_as_it_drives() -> None:
    _, goal_yaw = conversions.path_from_message(conversions.path_to_message(CORNER, None, "map", STAMP), "map")
    assert goal_yaw == pytest.approx(math.pi / 2)


def test_an_empty_path_is_refused() -> None:
    message = conversions.path_to_message(CORNER, None, "map", STAMP)
    message.poses = []
    with pytest.raises(InvalidInput, match="path of gold is empty"):
        conversions.path_from_message(message, "map", "path of gold")


def a_robot() -> Robot:
    return Robot("gold", CORNER, max_speed=0.6, radius=0.3, depart=2.0, start_yaw=0.5, goal_yaw=1.0,
                 max_acceleration=0.4, max_turn_rate=1.1, max_turn_acceleration=2.2)


def request(robot: Robot) -> PlannedPath:
    """What a client fills in: the fields that a schedule of the robot has, too."""
    schedule = conversions.schedule_to_message(Schedule(robot, np.zeros(1), np.zeros(1)), "map", STAMP)
    shared = {name: getattr(schedule, name) for name in PlannedPath.__slots__ if name in schedule.__slots__}
    return PlannedPath(depart=robot.depart, **shared)


def test_a_robot_survives_a_request() -> None:
    message = sent(request(a_robot()))
    back = conversions.robot_from_planned_path(message, "map")
    assert back.path.points.tolist() == CORNER.tolist()
    assert (back.name, back.max_speed, back.body_radius, back.depart) == ("gold", 0.6, 0.3, 2.0)
    assert (back.start_yaw, back.goal_yaw) == pytest.approx((0.5, 1.0))
    assert back.limits == a_robot().limits


def test_what_a_request_leaves_out_has_defaults() -> None:
    message = request(Robot("gold", CORNER))
    message.start_orientation = Quaternion()
    message.max_acceleration = message.max_turn_rate = message.max_turn_acceleration = 0.0
    back = conversions.robot_from_planned_path(message, "map")
    assert back.start_yaw is None
    assert back.limits == Robot("gold", CORNER).limits


def test_a_heading_left_out_in_a_recorded_message_is_none_either() -> None:
    message = request(Robot("gold", CORNER))
    message.start_orientation = SimpleNamespace(x=0.0, y=0.0, z=0.0, w=0.0)  # a bag has classes of its own
    assert conversions.robot_from_planned_path(message, "map").start_yaw is None


@pytest.mark.parametrize("name", ["", "/gold"])
def test_what_is_no_robots_name_is_refused(name: str) -> None:
    message = request(a_robot())
    message.robot = name
    with pytest.raises(InvalidScenario, match="no robot's name"):
        conversions.robot_from_planned_path(message, "map")


def a_schedule() -> Schedule:
    return Schedule(a_robot(), np.array([0.0, 1.5, 1.5, 5.0]), np.array([2.0, 4.0, 6.5, 13.0]),
                    (Precedence(1.5, "blue", 3.25, 4),), version=5)


def test_a_schedule_survives() -> None:
    message = sent(conversions.schedule_to_message(a_schedule(), "map", STAMP))
    assert message.header.stamp == STAMP
    back = conversions.schedule_from_message(message, "map")
    assert (back.name, back.version, back.precedences) == ("gold", 5, a_schedule().precedences)
    assert back.times.tolist() == a_schedule().times.tolist()
    assert back.arc_lengths.tolist() == a_schedule().arc_lengths.tolist()
    assert back.robot.limits == a_robot().limits


def test_a_schedule_whose_times_fall_is_refused() -> None:
    message = conversions.schedule_to_message(a_schedule(), "map", STAMP)
    message.times[1] = 1.0
    with pytest.raises(InvalidSchedule, match="gold"):
        conversions.schedule_from_message(message, "map")


@pytest.mark.parametrize("kind", ["intersection", "opposite_direction", "same_direction"])
def test_a_window_survives(kind: str) -> None:
    window = EncounterWindow("gold", "blue", kind, 1.0, 2.0, 3.0, 4.0, first="blue")
    message = sent(conversions.window_to_message(window, 9))
    assert message.version == 9
    assert conversions.window_from_message(message) == window


def test_a_window_of_no_known_kind_is_refused() -> None:
    window = EncounterWindow("gold", "blue", "sideways", 1.0, 2.0, 3.0, 4.0)
    with pytest.raises(InvalidInput, match="sideways"):
        conversions.window_to_message(window, 1)
    message = conversions.window_to_message(EncounterWindow("gold", "blue", "intersection", 1.0, 2.0, 3.0, 4.0), 1)
    message.kind = 17
    with pytest.raises(InvalidInput, match="17"):
        conversions.window_from_message(message)


def test_a_default_pose_message_is_refused() -> None:
    with pytest.raises(InvalidPose):
        conversions.pose_from_message(PoseStamped().pose)


def overlay(shape: int, **values: Any) -> AddOverlayRequest:
    """A request about (2, 3), in the map's frame."""
    request = AddOverlayRequest(name="cart", shape=shape, **values)
    request.header.frame_id = "map"
    request.pose.position.x, request.pose.position.y = 2.0, 3.0
    return request


GRID = OccupancyGrid(np.zeros((4, 4), dtype=np.int8), 0.5)
CORNERS = [Point(0.0, 0.0, 0.0), Point(1.0, 0.0, 0.0), Point(1.0, 1.0, 0.0)]
PAIRS = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0))


@pytest.mark.parametrize("request_, shape", [
    (overlay(AddOverlayRequest.DISC, radius=0.5), DiscObstacle(2.0, 3.0, 0.5)),
    (overlay(AddOverlayRequest.RECTANGLE, width=1.0, height=0.5), Rectangle(2.0, 3.0, 1.0, 0.5)),
    (overlay(AddOverlayRequest.POLYGON, points=CORNERS), Polygon(PAIRS)),
    (overlay(AddOverlayRequest.CELLS, points=CORNERS), Cells(PAIRS, 0.5)),
])
def test_obstacles(request_: AddOverlayRequest, shape: Any) -> None:
    assert conversions.shape_from_request(sent(request_), "map", GRID) == shape
    request_.header.frame_id = "odom"
    with pytest.raises(conversions.UnknownFrame, match="the obstacle 'cart' is in frame 'odom'"):
        conversions.shape_from_request(request_, "map", GRID)


def test_a_rectangle_turns_with_its_pose() -> None:
    request = overlay(AddOverlayRequest.RECTANGLE, width=1.0, height=0.5)
    request.pose.orientation = conversions.yaw_to_quaternion(0.7)
    shape = conversions.shape_from_request(request, "map", GRID)
    assert isinstance(shape, Rectangle) and shape.yaw == pytest.approx(0.7)


@pytest.mark.parametrize("wrong, field", [
    (overlay(17), "shape"), (overlay(AddOverlayRequest.DISC), "radius"),
    (overlay(AddOverlayRequest.RECTANGLE, width=1.0), "height"),
    (overlay(AddOverlayRequest.POLYGON, points=CORNERS[:2]), "vertices"), (overlay(AddOverlayRequest.CELLS), "points"),
])
def test_obstacles_that_are_none(wrong: AddOverlayRequest, field: str) -> None:
    with pytest.raises(InvalidOverlay) as caught:
        conversions.shape_from_request(wrong, "map", GRID)
    assert caught.value.field == field


def test_a_rectangle_needs_a_quaternion_or_none() -> None:
    request = overlay(AddOverlayRequest.RECTANGLE, width=1.0, height=0.5)
    request.pose.orientation.w = 0.5
    with pytest.raises(InvalidOverlay, match="not a unit quaternion"):
        conversions.shape_from_request(request, "map", GRID)
