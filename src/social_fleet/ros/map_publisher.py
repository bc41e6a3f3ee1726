"""The node map_publisher: a map file on a latched topic, for machines without map_server."""

from dataclasses import dataclass
from typing import Sequence

import rospy
from nav_msgs.msg import MapMetaData, OccupancyGrid
from nav_msgs.srv import GetMap, GetMapRequest, GetMapResponse

from social_fleet.errors import InvalidParameter
from social_fleet.mapping.files import load_map
from social_fleet.ros import conversions, parameters
from social_fleet.ros.paths import resolve_path


@dataclass(frozen=True)
class MapPublisherParameters:
    """Parameters of the node."""

    map_file: str = ""  # the map's YAML file; the first command line argument, as map_server has it, goes before
    scenario: str = ""  # without map_file: publish the map that this scenario file names
    frame_id: str = "map"


class MapPublisher:
    """Publishes one map file for as long as it lives.

    Publishers
        map (nav_msgs/OccupancyGrid), map_metadata (nav_msgs/MapMetaData): latched.
    Services
        static_map (nav_msgs/GetMap).
    Parameters
        `MapPublisherParameters`.
    """

    def __init__(self, arguments: Sequence[str] = ()) -> None:
        config = parameters.read_private(MapPublisherParameters)
        path = self._path(config, arguments)
        grid = load_map(path)
        self._message = conversions.grid_to_message(grid, config.frame_id, rospy.Time.now())
        self._map = rospy.Publisher("map", OccupancyGrid, latch=True, queue_size=1)
        self._metadata = rospy.Publisher("map_metadata", MapMetaData, latch=True, queue_size=1)
        self._map.publish(self._message)
        self._metadata.publish(self._message.info)
        self._service = rospy.Service("static_map", GetMap, self._serve)
        rospy.loginfo("publishing %s: %d x %d cells of %g m", path, grid.shape[1], grid.shape[0], grid.resolution)

    @staticmethod
    def _path(config: MapPublisherParameters, arguments: Sequence[str]) -> str:
        if arguments:
            return resolve_path(arguments[0])
        if config.map_file:
            return resolve_path(config.map_file)
        if config.scenario:
            from social_fleet.scenario.files import load_scenario
            return load_scenario(resolve_path(config.scenario)).map_path
        raise InvalidParameter("is empty; name a map's YAML file", field=f"{parameters.private_prefix()}map_file")

    def _serve(self, request: GetMapRequest) -> GetMapResponse:
        return GetMapResponse(map=self._message)
