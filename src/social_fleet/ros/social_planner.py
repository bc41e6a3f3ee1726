"""The node social_planner: plans for the fleet on the map that it hears, and learns from what the fleet plans."""

import threading
from dataclasses import dataclass
from typing import Optional, Sequence, Tuple

import numpy as np
import rospy
from nav_msgs.msg import OccupancyGrid as GridMessage, Path
from nav_msgs.srv import GetPlan, GetPlanRequest, GetPlanResponse
from rospy.numpy_msg import numpy_msg
from visualization_msgs.msg import Marker

from social_fleet.errors import InvalidGoal, InvalidInput, InvalidStart, NotReady, SocialFleetError
from social_fleet.geometry import Pose
from social_fleet.msg import PlannedPath
from social_fleet.parameters import parameter
from social_fleet.planning.overlay import Disc
from social_fleet.planning.plan import Plan
from social_fleet.ros import conversions, parameters
from social_fleet.ros.frames import Frames
from social_fleet.ros.markers import graph_marker
from social_fleet.ros.planning_fleet import PlanningFleet, RobotEntry, read_config, read_zones
from social_fleet.ros.statuses import PLAN_STATUSES, status_of
from social_fleet.srv import PlanPath, PlanPathRequest, PlanPathResponse


@dataclass(frozen=True)
class SocialPlannerParameters:
    """Parameters of the node; all others in its namespace are those of `PlannerConfig`, and `robots`."""

    max_speed: float = parameter(0.7, above=0.0)  # announced for robots that `robots` does not list [m/s]
    base_frame: str = "base_link"  # of a robot, below its name
    pose_patience: float = parameter(2.0, above=0.0)  # wait for the robot's present pose [s, wall time]
    graph_file: str = ""  # a social graph to begin with; empty: none
    learn_at_start: int = parameter(0, minimum=0)  # paths between random poses to learn a social graph from
    learn_every: int = parameter(0, minimum=0)  # extract the social graph anew after so many paths; 0: never
    zones_file: str = ""  # parts of the map with norms of their own; empty: beside the scenario's map; none: none
    scenario: str = ""  # a scenario file whose `planner` and robots go before the parameters


class SocialPlannerNode:
    """Plans one robot's path at a time.

    Subscribers
        map (nav_msgs/OccupancyGrid): may come late and change; plans are made on the last one.
        fleet/paths (PlannedPath): what others planned, for the social graph.
    Publishers
        ~plan (nav_msgs/Path): the last plan.
        ~social_graph (visualization_msgs/Marker), latched.
        fleet/paths (PlannedPath): every plan for a robot that the request names.
    Services
        ~plan_path (PlanPath), ~make_plan (nav_msgs/GetPlan).
    Parameters
        `SocialPlannerParameters`; those of `PlannerConfig`, see config/planner.yaml; `robots`, a mapping of names to
        {radius, max_speed} for robots that differ from `robot_radius` and `max_speed`.
    """

    def __init__(self) -> None:
        self._config, others = parameters.split_private(SocialPlannerParameters)
        self._planner_config, self._robots = read_config(others, self._config.scenario, parameters.private_prefix())
        self._zones = read_zones(self._config.zones_file, self._config.scenario)
        self._any_robot = RobotEntry(self._planner_config.robot_radius, self._config.max_speed)
        self._lock = threading.Lock()
        self._fleet: Optional[PlanningFleet] = None
        self._frame = ""
        self._trouble: SocialFleetError = NotReady("no map has come yet; is something publishing "
                                                   f"{rospy.resolve_name('map')}?")
        self._frames: Optional[Frames] = None  # made when first asked: /tf is busy
        self._plan = rospy.Publisher("~plan", Path, queue_size=1)
        self._graph = rospy.Publisher("~social_graph", Marker, latch=True, queue_size=1)
        self._paths = rospy.Publisher("fleet/paths", PlannedPath, queue_size=100)
        rospy.Subscriber("fleet/paths", PlannedPath, self._hear_path, queue_size=100)
        rospy.Subscriber("map", numpy_msg(GridMessage), self._hear_map, queue_size=1)
        self._services = [rospy.Service("~plan_path", PlanPath, self._serve_plan_path),
                          rospy.Service("~make_plan", GetPlan, self._serve_make_plan)]

    def _hear_map(self, message: GridMessage) -> None:
        """Build what planning needs; requests wait meanwhile."""
        with self._lock:
            try:
                grid = conversions.grid_from_message(message)
                if self._fleet is not None and self._fleet.grid.digest == grid.digest:
                    return
                self._fleet, self._frame, self._frames = None, "", None
                fleet = PlanningFleet(grid, self._planner_config, self._config.graph_file, zones=self._zones)
                if self._config.learn_at_start:
                    fleet.learn_at_random(self._config.learn_at_start)
                self._fleet = fleet
                self._frame = conversions.frame_name(message.header.frame_id)
            except SocialFleetError as error:
                self._trouble = error
                rospy.logerr("the map cannot be used: %s", error)
                return
            self._publish_graph()
        rospy.loginfo("ready to plan on a map of %d x %d cells of %g m", grid.shape[1], grid.shape[0],
                      grid.resolution)

    def _hear_path(self, message: PlannedPath) -> None:
        """What this node planned itself comes back here, too; it has been counted."""
        if message._connection_header["callerid"] == rospy.get_name():
            return
        with self._lock:
            if self._fleet is None:
                return
            try:
                points, _ = conversions.path_from_message(message.path, self._frame, f"path of {message.robot}")
                self._count(self._fleet.cells_of(points))
            except InvalidInput as error:
                rospy.logwarn_throttle(10.0, "a path was not learnt from: %s" % error)

    def _serve_plan_path(self, request: PlanPathRequest) -> PlanPathResponse:
        try:
            avoid = [Disc(disc.x, disc.y, disc.z) for disc in request.avoid]
            with self._lock:
                plan, message = self._answer(request, avoid)
        except Exception as error:
            status = status_of(error, PLAN_STATUSES)
            rospy.loginfo("no path for robot '%s': %s", request.robot, error)
            return PlanPathResponse(status=status, message=str(error) or type(error).__name__)
        return PlanPathResponse(status=PlanPathResponse.SUCCESS, path=message.path, length=plan.length,
                                social_cost=plan.social_cost, planning_time=plan.search_time,
                                temporary=plan.temporary)

    def _serve_make_plan(self, request: GetPlanRequest) -> GetPlanResponse:
        """GetPlan has no field for a reason: the log has it."""
        answer = self._serve_plan_path(PlanPathRequest(start=request.start, goal=request.goal,
                                                       tolerance=request.tolerance))
        if answer.status != PlanPathResponse.SUCCESS:
            rospy.logwarn_throttle(1.0, "make_plan: %s" % answer.message)
        return GetPlanResponse(plan=answer.path)

    def _answer(self, request: PlanPathRequest, avoid: Sequence[Disc]) -> Tuple[Plan, PlannedPath]:
        if self._fleet is None:
            raise self._trouble
        goal = conversions.pose_from_stamped(request.goal, self._frame, "goal", InvalidGoal)
        start = self._start(request)
        robot = self._robots.get(request.robot, self._any_robot)
        plan = self._fleet.plan(robot.radius, start, goal, avoid=avoid, tolerance=request.tolerance)
        message = conversions.plan_to_planned_path(plan, request.robot, robot.max_speed, self._frame,
                                                   rospy.Time.now())
        self._plan.publish(message.path)
        if request.robot:
            self._paths.publish(message)
            self._count(plan.cells)
        return plan, message

    def _start(self, request: PlanPathRequest) -> Pose:
        """The requested start, or where the robot is now."""
        if request.start.header.frame_id:
            return conversions.pose_from_stamped(request.start, self._frame, "start", InvalidStart)
        if self._frames is None:
            self._frames = Frames(self._frame)
        frame = "/".join(part for part in (request.robot, self._config.base_frame) if part)
        return self._frames.await_pose_of(frame, self._config.pose_patience)

    def _count(self, cells: np.ndarray) -> None:
        """Add a path to the heatmaps, and from time to time the heatmaps to the graph."""
        assert self._fleet is not None
        self._fleet.count(cells)
        if self._config.learn_every and self._fleet.counted % self._config.learn_every == 0:
            self._fleet.learn()
            self._publish_graph()

    def _publish_graph(self) -> None:
        assert self._fleet is not None
        if self._fleet.graph is not None:
            self._graph.publish(graph_marker(self._fleet.graph, self._fleet.grid, self._frame, rospy.Time.now()))
