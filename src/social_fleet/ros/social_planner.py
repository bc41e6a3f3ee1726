"""The node social_planner: plans for the fleet on the map that it hears, and learns from what the fleet plans."""

import threading
from dataclasses import dataclass
from typing import Any, Optional, Sequence, Tuple

import rospy
from nav_msgs.msg import OccupancyGrid as GridMessage, Path
from nav_msgs.srv import GetPlan, GetPlanRequest, GetPlanResponse
from rospy.numpy_msg import numpy_msg
from visualization_msgs.msg import Marker

from social_fleet.errors import InvalidGoal, InvalidInput, InvalidOverlay, InvalidStart, NotReady, SocialFleetError
from social_fleet.geometry import Pose
from social_fleet.msg import PlannedPath
from social_fleet.parameters import parameter
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.overlays.discs import Disc
from social_fleet.planning.plan import Plan
from social_fleet.ros import conversions, parameters
from social_fleet.ros.background import BackgroundWork
from social_fleet.ros.frames import Frames
from social_fleet.ros.markers import graph_marker
from social_fleet.ros.planning_fleet import PlanningFleet, RobotEntry, read_config, read_zones
from social_fleet.ros.reconfigure import PlannerReconfigure
from social_fleet.ros.statuses import OVERLAY_STATUSES, PLAN_STATUSES, status_of
from social_fleet.srv import (AddOverlay, AddOverlayRequest, AddOverlayResponse, ClearOverlay, ClearOverlayRequest,
                              ClearOverlayResponse, PlanPath, PlanPathRequest, PlanPathResponse)

EXPIRY_PERIOD = 0.5  # [s, ROS time] between looks at which obstacles have expired, beside the one before every plan


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
        fleet/paths (PlannedPath): every plan for a robot that the request names, unless that is an inquiry.
    Services
        ~plan_path (PlanPath), ~make_plan (nav_msgs/GetPlan).
        ~add_overlay (AddOverlay), ~clear_overlay (ClearOverlay): obstacles that the map does not hold.
        ~set_parameters (dynamic_reconfigure/Reconfigure): weights and other parameters, for all plans from then on.
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
        self._learner = BackgroundWork(self._learn, "learning")
        rospy.on_shutdown(self._learner.stop)
        self._preparer = BackgroundWork(self._prepare, "preparing")
        rospy.on_shutdown(self._preparer.stop)
        self._services = [rospy.Service("~plan_path", PlanPath, self._serve_plan_path),
                          rospy.Service("~make_plan", GetPlan, self._serve_make_plan),
                          rospy.Service("~add_overlay", AddOverlay, self._serve_add_overlay),
                          rospy.Service("~clear_overlay", ClearOverlay, self._serve_clear_overlay)]
        self._reconfigure = PlannerReconfigure(self._planner_config, self._use_config)
        self._timer = rospy.Timer(rospy.Duration(EXPIRY_PERIOD), self._expire, reset=True)

    def _hear_map(self, message: GridMessage) -> None:
        """Build what planning needs; requests wait meanwhile."""
        with self._lock:
            try:
                grid = conversions.grid_from_message(message)
                if self._fleet is not None and self._fleet.grid.digest == grid.digest:
                    return
                previous, self._fleet, self._frame, self._frames = self._fleet, None, "", None
                fleet = PlanningFleet(grid, self._planner_config, self._config.graph_file, previous,
                                      zones=self._zones)
                if self._config.learn_at_start and fleet.graph is None:
                    fleet.learn_at_random(self._config.learn_at_start)
                self._fleet = fleet
                self._frame = conversions.frame_name(message.header.frame_id)
            except SocialFleetError as error:
                self._trouble = error
                rospy.logerr("the map cannot be used: %s", error)
                return
            self._publish_graph(fleet)
        self._preparer.request()
        rospy.loginfo("ready to plan on a map of %d x %d cells of %g m", grid.shape[1], grid.shape[0],
                      grid.resolution)

    def _use_config(self, config: PlannerConfig) -> None:
        """Plan with other parameters from now on."""
        with self._lock:
            self._planner_config = config
            self._any_robot = RobotEntry(config.robot_radius, self._config.max_speed)
            if self._fleet is not None:
                self._fleet.reconfigure(config)
        self._preparer.request()

    def _prepare(self) -> None:
        fleet = self._fleet
        if fleet is not None:
            fleet.prepare()

    def _hear_path(self, message: PlannedPath) -> None:
        """What this node planned itself comes back here, too; it has been counted."""
        if message._connection_header["callerid"] == rospy.get_name():
            return
        with self._lock:
            if self._fleet is None:
                return
            try:
                points, _ = conversions.path_from_message(message.path, self._frame, f"path of {message.robot}")
                self._fleet.count_path(points, temporary=message.temporary)
                self._learn_in_time(self._fleet)
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
        return PlanPathResponse(status=PlanPathResponse.SUCCESS, message=plan.message, path=message.path,
                                length=plan.length, social_cost=plan.social_cost, planning_time=plan.search_time,
                                temporary=plan.temporary, radius=message.radius, max_speed=message.max_speed)

    def _serve_make_plan(self, request: GetPlanRequest) -> GetPlanResponse:
        """GetPlan has no field for a reason: the log has it."""
        answer = self._serve_plan_path(PlanPathRequest(start=request.start, goal=request.goal,
                                                       tolerance=request.tolerance))
        if answer.status != PlanPathResponse.SUCCESS:
            rospy.logwarn_throttle(1.0, "make_plan: %s" % answer.message)
        return GetPlanResponse(plan=answer.path)

    def _serve_add_overlay(self, request: AddOverlayRequest) -> AddOverlayResponse:
        try:
            with self._lock:
                fleet = self._ready_fleet()
                shape = conversions.shape_from_request(request, self._frame, fleet.grid)
                fleet.overlays.add(request.name, shape, expires=_expiry(request.lifetime), robot=request.robot)
        except Exception as error:
            rospy.logwarn("the obstacle '%s' is not taken: %s", request.name, error)
            return AddOverlayResponse(status=status_of(error, OVERLAY_STATUSES),
                                      message=str(error) or type(error).__name__)
        rospy.loginfo("plans go round the obstacle '%s'", request.name)
        return AddOverlayResponse(status=AddOverlayResponse.SUCCESS)

    def _serve_clear_overlay(self, request: ClearOverlayRequest) -> ClearOverlayResponse:
        try:
            with self._lock:
                overlays = self._ready_fleet().overlays
                cleared = (request.name,) if request.name else overlays.clear()
                if request.name:
                    overlays.remove(request.name)
        except Exception as error:
            return ClearOverlayResponse(status=status_of(error, OVERLAY_STATUSES),
                                        message=str(error) or type(error).__name__)
        rospy.loginfo("obstacles cleared: %s", ", ".join(cleared) or "none")
        return ClearOverlayResponse(status=ClearOverlayResponse.SUCCESS, cleared=cleared)

    def _expire(self, _: Any = None) -> None:
        fleet = self._fleet
        if fleet is not None:
            for name in fleet.overlays.expire(rospy.Time.now().to_sec()):
                rospy.loginfo("the obstacle '%s' has expired", name)

    def _ready_fleet(self) -> PlanningFleet:
        if self._fleet is None:
            raise self._trouble
        return self._fleet

    def _answer(self, request: PlanPathRequest, avoid: Sequence[Disc]) -> Tuple[Plan, PlannedPath]:
        fleet = self._ready_fleet()
        self._expire()
        goal = conversions.pose_from_stamped(request.goal, self._frame, "goal", InvalidGoal)
        start = self._start(request)
        robot = self._robots.get(request.robot, self._any_robot)
        plan = fleet.plan(robot.radius, start, goal, robot=request.robot, avoid=avoid, tolerance=request.tolerance,
                          start_tolerance=request.start_tolerance)
        message = conversions.plan_to_planned_path(plan, request.robot, robot.max_speed, self._frame,
                                                   rospy.Time.now())
        self._plan.publish(message.path)
        if request.robot and not request.inquiry:
            self._paths.publish(message)
            fleet.count(plan)
            self._learn_in_time(fleet)
        return plan, message

    def _start(self, request: PlanPathRequest) -> Pose:
        """The requested start, or where the robot is now."""
        if request.start.header.frame_id:
            return conversions.pose_from_stamped(request.start, self._frame, "start", InvalidStart)
        if self._frames is None:
            self._frames = Frames(self._frame)
        frame = "/".join(part for part in (request.robot, self._config.base_frame) if part)
        return self._frames.await_pose_of(frame, self._config.pose_patience)

    def _learn_in_time(self, fleet: PlanningFleet) -> None:
        """Have the graph extracted anew when enough has been counted."""
        if self._config.learn_every and fleet.has_to_learn(self._config.learn_every):
            self._learner.request()

    def _learn(self) -> None:
        """In a thread of its own, and without the lock that serves plans."""
        fleet = self._fleet
        if fleet is not None:
            fleet.learn()
            self._publish_graph(fleet)

    def _publish_graph(self, fleet: PlanningFleet) -> None:
        if fleet.graph is not None and fleet is self._fleet:
            self._graph.publish(graph_marker(fleet.graph, fleet.grid, self._frame, rospy.Time.now()))


def _expiry(lifetime: rospy.Duration) -> Optional[float]:
    """When an obstacle that has come just now goes [s, ROS time]; None: not by itself."""
    if lifetime < rospy.Duration(0):
        raise InvalidOverlay(f"must be zero or more seconds, not {lifetime.to_sec():g}", field="lifetime")
    return (rospy.Time.now() + lifetime).to_sec() if lifetime else None
