"""The node navigator, one per robot: goals as move_base takes them, driven on coordinated schedules."""

import math
import threading
import time
from dataclasses import dataclass
from typing import Optional, Tuple

import rospy
from geometry_msgs.msg import Pose2D, PoseStamped
from nav_msgs.srv import GetPlan, GetPlanRequest, GetPlanResponse

from social_fleet.errors import InvalidInput
from social_fleet.execution.navigation_state import Navigation, NavigationConfig, NavigationState, Order, RobotNews
from social_fleet.execution.recovery.messages import Errand
from social_fleet.geometry import Pose, compose
from social_fleet.msg import Errand as ErrandMessage, NavigationStatus, Progress, RobotReport
from social_fleet.parameters import from_mapping, parameter
from social_fleet.ros import conversions, parameters
from social_fleet.ros.background import BackgroundWork
from social_fleet.ros.diagnostics import Diagnostics, Health, Level
from social_fleet.ros.exchange_conversions import errand_to_message, pose_from_plane
from social_fleet.ros.frames import Frames
from social_fleet.ros.goal_server import GoalServer
from social_fleet.ros.identity import robot_name
from social_fleet.ros.planner_client import NoAnswer, PlannerClient

_LOOK = 0.1  # between two looks at what has come [s, wall time]
_TF_PATIENCE = 2.0  # for the frame of a goal [s, wall time]
_THERE = 0.25  # a robot that stands this close to its goal has arrived [m]
_ELSEWHERE = 5.0  # one that stands at the end of its schedule elsewhere asks anew after so long [s, wall time]


@dataclass(frozen=True)
class NavigatorParameters:
    """Parameters of the node; all others in its namespace are those of `NavigationConfig`."""

    robot: str = ""  # the robot's name in schedules; empty: the last part of the node's namespace
    map_frame: str = "map"
    feedback_rate: float = parameter(5.0, above=0.0)  # [Hz, wall time]
    news_timeout: float = parameter(3.0, above=0.0)  # without news from the tracker it counts as lost [s, wall time]


class Navigator:
    """Takes goals, asks the planner for a path, hands them to the fleet, and reports what becomes of them.

    The robot's tracker tells the coordinator of the goal, and drives the schedule that it gets for it.

    Subscribers
        move_base_simple/goal (geometry_msgs/PoseStamped); report (RobotReport): of this robot's tracker; tf, for goals
        in other frames.
    Publishers
        current_goal (geometry_msgs/PoseStamped), latched; fleet/navigation (NavigationStatus), latched;
        errand (Errand), latched: what the tracker is to do; /diagnostics.
    Actions
        move_base (move_base_msgs/MoveBaseAction).
    Services
        ~make_plan, move_base/make_plan (nav_msgs/GetPlan): at any time; nobody drives these plans.
    Services called
        social_planner/plan_path (PlanPath).
    Parameters
        `NavigatorParameters`; those of `NavigationConfig`, see config/navigator.yaml.
    """

    def __init__(self) -> None:
        self._config, others = parameters.split_private(NavigatorParameters)
        self._navigation = Navigation(from_mapping(NavigationConfig, others, prefix=parameters.private_prefix()))
        self.robot = robot_name(self._config.robot)
        self._wake = threading.Event()
        self._lock = threading.Lock()  # of the navigation
        self._report: Optional[RobotReport] = None
        self._heard = 0.0  # when the tracker last said anything [s, wall time]
        self._told: Tuple = ()
        self._logged: Tuple = ()
        self._ordered: Optional[Order] = None
        self._elsewhere_since: Optional[float] = None  # [s, wall time]
        self._fed = 0.0  # [s, wall time]
        self._frames: Optional[Frames] = None  # made when first needed: /tf is busy
        self._planner = PlannerClient(self.robot)
        self._asking = BackgroundWork(self._ask_planner, "planning")
        self._current_goal = rospy.Publisher("current_goal", PoseStamped, latch=True, queue_size=1)
        self._status = rospy.Publisher("fleet/navigation", NavigationStatus, latch=True, queue_size=10)
        self._errand = rospy.Publisher("errand", ErrandMessage, latch=True, queue_size=1)
        self._diagnostics = Diagnostics(self.robot, {"goal": self._diagnose})
        rospy.Subscriber("report", RobotReport, self._hear_report, queue_size=10)
        self._goals = GoalServer(self._wake.set)
        self._services = [rospy.Service(name, GetPlan, self._serve_make_plan)
                          for name in ("~make_plan", "move_base/make_plan")]
        rospy.on_shutdown(self._wake.set)

    def _hear_report(self, message: RobotReport) -> None:
        self._report, self._heard = message, time.monotonic()
        self._wake.set()

    def spin(self) -> int:
        """Look after the goals until shutdown."""
        while not rospy.is_shutdown():
            self._look()
            self._wake.wait(_LOOK)
            self._wake.clear()
        self._goals.abort("the navigator was shut down")
        return 0

    def _look(self) -> None:
        """Take in what has come, and tell what has come of it."""
        now = rospy.get_time()
        goal = self._take_goal()
        with self._lock:
            navigation = self._navigation
            if goal is not None:
                navigation.accept(goal, self._next_number(), now)
            elif self._goals.taken_back:
                navigation.cancel(now)
            navigation.hear(self._news(), now)
            if time.monotonic() - (self._elsewhere_since or math.inf) > _ELSEWHERE:
                self._elsewhere_since = None
                navigation.again(self._next_number(), now)
            if navigation.wants_path:
                self._asking.request()
            self._give_order()
            self._tell_end()
            self._tell_change()
        self._feed_back()
        self._diagnostics.update()

    def _take_goal(self) -> Optional[Pose]:
        """A new goal [m, rad, map frame]; one that is unusable is refused, with whatever was before."""
        target = self._goals.take()
        if target is None:
            return None
        try:
            goal = self._in_map(target)
        except InvalidInput as error:
            with self._lock:
                self._navigation.cancel(rospy.get_time(), "another goal took its place, which is unusable")
                self._give_order()
            rospy.logwarn("%s: the goal is refused: %s", self.robot, error)
            self._goals.abort(str(error))
            return None
        rospy.loginfo("%s: goal (%.2f, %.2f, %.2f)", self.robot, *goal)
        self._current_goal.publish(conversions.pose_to_stamped(goal, self._config.map_frame, rospy.Time.now()))
        return goal

    def _in_map(self, target: PoseStamped) -> Pose:
        """The goal in the map's frame; raises InvalidInput."""
        pose = conversions.pose_from_message(target.pose, "goal")
        frame = conversions.frame_name(target.header.frame_id)
        if frame == self._config.map_frame:
            return pose
        if not frame:
            raise conversions.UnknownFrame(f"the goal has no frame; give it in '{self._config.map_frame}'")
        if self._frames is None:
            self._frames = Frames(self._config.map_frame)
        return compose(self._frames.await_pose_of(frame, _TF_PATIENCE), pose)

    def _news(self) -> RobotNews:
        """What the robot says, and what its silence means."""
        report = self._report
        if report is None or time.monotonic() - self._heard > self._config.news_timeout:
            return RobotNews(trouble="its tracker says nothing")
        trouble = report.trouble if report.state == Progress.STOPPED else ""
        if report.blocked > self._config.news_timeout:
            trouble = "something that the map does not hold stands in its way"
        arrived = report.state == Progress.ARRIVED
        elsewhere = arrived and not report.unserved and report.serving == self._navigation.number and self._is_away()
        if not elsewhere:
            self._elsewhere_since = None
        elif self._elsewhere_since is None:
            self._elsewhere_since = time.monotonic()
        if elsewhere:
            trouble = "its schedule has ended elsewhere"
        return RobotNews(report.serving, report.unserved, report.final, arrived and not elsewhere, trouble)

    def _is_away(self) -> bool:
        """Whether the robot is not at its goal: whoever says that it has arrived."""
        pose, goal = self._pose(), self._navigation.goal
        return pose is not None and goal is not None and math.hypot(pose.x - goal.x, pose.y - goal.y) > _THERE

    def _next_number(self) -> int:
        """Greater than any before, also of a navigator that ran before."""
        return max(self._navigation.number + 1, int(1e3 * time.time()))

    def _ask_planner(self) -> None:
        """In a thread of its own: whether there is a path for the present goal."""
        with self._lock:
            number, goal, wanted = self._navigation.number, self._navigation.goal, self._navigation.wants_path
        if not wanted or goal is None:
            return
        frame = self._config.map_frame
        try:
            start = self._pose()
            if start is None:
                raise NoAnswer("the robot's pose is not known")
            self._planner.path(conversions.pose_to_stamped(start, frame), conversions.pose_to_stamped(goal, frame))
        except NoAnswer as error:
            with self._lock:
                self._navigation.refused(number, rospy.get_time(), str(error), final=error.final)
        else:
            with self._lock:
                self._navigation.planned(number, rospy.get_time())
        self._wake.set()

    def _pose(self) -> Optional[Pose]:
        """Where the robot last said to be; None when that is not known."""
        return None if self._report is None else pose_from_plane(self._report.pose)

    def _give_order(self) -> None:
        """Hand the robot's part of a change to its tracker."""
        order = self._navigation.order
        if order is not None and order != self._ordered:
            self._ordered = order
            errand = None if order.goal is None else Errand(order.number, tuple(order.goal))
            self._errand.publish(errand_to_message(errand, order.number))

    def _tell_end(self) -> None:
        """Tell the client when its goal is done with."""
        navigation = self._navigation
        if navigation.state is NavigationState.SUCCEEDED:
            self._goals.succeed("arrived")
        elif navigation.state is NavigationState.CANCELED:
            self._goals.cancel(navigation.reason)
        elif navigation.state is NavigationState.ABORTED:
            self._goals.abort(navigation.reason)

    def _tell_change(self) -> None:
        """A message and a line for every change."""
        navigation = self._navigation
        version = 0 if self._report is None else self._report.schedule_version
        if (navigation.number, navigation.state, navigation.reason, version) == self._told:
            return
        self._log_change()
        self._told = navigation.number, navigation.state, navigation.reason, version
        message = NavigationStatus(robot=self.robot, state=int(navigation.state), reason=navigation.reason,
                                   number=navigation.number, schedule_version=version)
        message.header.stamp, message.header.frame_id = rospy.Time.from_sec(navigation.since), self._config.map_frame
        if navigation.goal is not None:
            message.goal = Pose2D(*navigation.goal)
        self._status.publish(message)

    def _log_change(self) -> None:
        """A line for every change, but none for every attempt, nor for every number in a reason."""
        navigation = self._navigation
        what = navigation.number, navigation.state
        if what == self._logged or (navigation.wants_path and navigation.reason):
            return
        self._logged = what
        bad = navigation.state in (NavigationState.WAITING, NavigationState.ABORTED)
        (rospy.logwarn if bad else rospy.loginfo)("%s: %s%s", self.robot, navigation.state.name.lower(),
                                                  f": {navigation.reason}" if navigation.reason else "")

    def _feed_back(self) -> None:
        """Where the robot is, to the client."""
        pose, report = self._pose(), self._report
        due = time.monotonic() - self._fed >= 1.0 / self._config.feedback_rate
        if due and pose is not None and report is not None:
            self._fed = time.monotonic()
            self._goals.tell(pose, self._config.map_frame, report.header.stamp)

    def _diagnose(self) -> Health:
        navigation = self._navigation
        bad = navigation.state in (NavigationState.WAITING, NavigationState.ABORTED)
        return Level.WARN if bad else Level.OK, navigation.reason or navigation.state.name.lower(), {
            "state": navigation.state.name, "goal": navigation.number, "since [s]": navigation.since}

    def _serve_make_plan(self, request: GetPlanRequest) -> GetPlanResponse:
        """GetPlan has no field for a reason: the log has it. A start without a frame is where the robot is now."""
        start, pose = request.start, self._pose()
        if not start.header.frame_id and pose is not None:
            start = conversions.pose_to_stamped(pose, self._config.map_frame)
        try:
            return GetPlanResponse(plan=self._planner.path(start, request.goal, request.tolerance))
        except NoAnswer as error:
            rospy.logwarn("%s: make_plan: %s", self.robot, error)
            return GetPlanResponse()
