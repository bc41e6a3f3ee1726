"""RViz markers of a fleet, built from core values and messages."""

import colorsys
from typing import Sequence, Tuple

import genpy
import numpy as np
import rospy
from geometry_msgs.msg import Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker

from social_fleet.geometry import Polyline, Pose
from social_fleet.mapping.grid import OccupancyGrid, Points
from social_fleet.mapping.walls import HEADINGS
from social_fleet.planning.routes.social_graph import SocialGraph
from social_fleet.ros import conversions

HEIGHT = 0.4  # of a robot's disc [m]
WINDOW_COLOURS = {"intersection": (0.90, 0.60, 0.0, 0.7), "opposite_direction": (0.85, 0.1, 0.1, 0.7),
                  "same_direction": (0.0, 0.55, 0.75, 0.7)}  # r, g, b, alpha


def colour_of(code: str, alpha: float = 1.0) -> ColorRGBA:
    """``#rrggbb`` as a message."""
    red, green, blue = (int(code[at:at + 2], 16) / 255.0 for at in (1, 3, 5))
    return ColorRGBA(red, green, blue, alpha)


def marker(kind: int, namespace: str, number: int, frame: str, stamp: genpy.Time, *, colour: ColorRGBA,
           scale: Tuple[float, float, float], pose: Pose = Pose(0.0, 0.0, 0.0)) -> Marker:
    """A marker with what all markers need."""
    result = Marker(header=Header(stamp=stamp, frame_id=frame), ns=namespace, id=number, type=kind, action=Marker.ADD,
                    color=colour, scale=Vector3(*scale), lifetime=rospy.Duration(0))
    result.pose = conversions.pose_to_message(pose)
    return result


def disc_marker(number: int, position: Sequence[float], radius: float, colour: ColorRGBA, frame: str,
                stamp: genpy.Time, *, namespace: str = "robots") -> Marker:
    """A robot's body to scale, or an obstacle's."""
    result = marker(Marker.CYLINDER, namespace, number, frame, stamp, colour=colour,
                    scale=(2.0 * radius, 2.0 * radius, HEIGHT), pose=Pose(float(position[0]), float(position[1])))
    result.pose.position.z = 0.5 * HEIGHT
    return result


def text_marker(namespace: str, number: int, position: Sequence[float], text: str, colour: ColorRGBA, height: float,
                frame: str, stamp: genpy.Time) -> Marker:
    """Text of `height` [m] that faces the viewer, beside `position` seen from above."""
    result = marker(Marker.TEXT_VIEW_FACING, namespace, number, frame, stamp, colour=colour, scale=(0.0, 0.0, height),
                    pose=Pose(float(position[0]), float(position[1]) + height))
    result.pose.position.z = 1.0
    result.text = text
    return result


def line_marker(namespace: str, number: int, points: Points, colour: ColorRGBA, width: float,
                frame: str, stamp: genpy.Time) -> Marker:
    """A chain of straight segments through `points` [m]."""
    result = marker(Marker.LINE_STRIP, namespace, number, frame, stamp, colour=colour, scale=(width, 0.0, 0.0))
    result.points = conversions.points_to_messages(points)
    return result


def window_marker(number: int, kind: str, path: Polyline, enter: float, leave: float, frame: str,
                  stamp: genpy.Time) -> Marker:
    """The stretch of one robot's path that lies in an encounter window, coloured by its kind."""
    points = path.slice(enter, max(leave, enter + 0.05)).points
    if len(points) == 1:
        points = np.vstack([points, points + 1e-3])
    return line_marker("windows", number, points, ColorRGBA(*WINDOW_COLOURS[kind]), 0.35, frame, stamp)


def graph_marker(graph: SocialGraph, grid: OccupancyGrid, frame: str, stamp: genpy.Time) -> Marker:
    """All edges of a social graph, coloured by heading, from a cell's centre a good half of the way to the next."""
    result = marker(Marker.LINE_LIST, "social_graph", 0, frame, stamp, colour=ColorRGBA(0.0, 0.0, 0.0, 1.0),
                    scale=(0.6 * grid.resolution, 0.0, 0.0))
    for heading, step in enumerate(HEADINGS):
        cells = np.argwhere(graph.edges & (1 << heading))
        if not len(cells):
            continue
        ends = cells + 0.7 * np.array([step[1], step[0]])
        pairs = np.stack([grid.centres(cells), grid.centres(ends)], axis=1).reshape(-1, 2)
        colour = ColorRGBA(*colorsys.hsv_to_rgb(heading / 8.0, 0.9, 0.8), 0.8)
        result.points.extend(conversions.points_to_messages(pairs))
        result.colors.extend([colour] * len(pairs))
    return result
