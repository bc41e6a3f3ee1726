"""The node navigator, one per robot: goals as move_base takes them, driven on coordinated schedules."""

import math
import threading
import time
from dataclasses import dataclass
from functools import partial
from typing import Callable, Optional

import rospy
from geometry_msgs.msg import Pose2D, PoseStamped
from nav_msgs.srv import GetPlan, GetPlanRequest, GetPlanResponse
from std_msgs.msg import Bool

from social_fleet.errors import InvalidInput
from social_fleet.execution.navigation_state import Errand, Navigation, NavigationConfig, NavigationState, RobotNews
from social_fleet.geometry import Pose, compose
from social_fleet.msg import NavigationStatus, PlannedPath, Progress, Schedule
from social_fleet.parameters import from_mapping, parameter
from social_fleet.ros import conversions, parameters
from social_fleet.ros.diagnostics import Diagnostics, Health, Level
from social_fleet.ros.errands import ErrandRefused, FleetErrands
from social_fleet.ros.frames import Frames
from social_fleet.ros.goal_server import GoalServer
from social_fleet.ros.identity import robot_name

_LOOK = 0.1  # between two looks at what has come [s, wall time]
_PARKING = 2.0  # between two attempts to have the fleet plan round a robot [s, wall time]
_TF_PATIENCE = 2.0  # for the frame of a goal [s, wall time]


@dataclass(frozen=True)
class NavigatorParameters:
    """Parameters of the node; all others in its namespace are those of `NavigationConfig`."""

    robot: str = ""  # the robot's name in schedules; empty: the last part of the node's namespace
    map_frame: str = "map"
    radius: float = parameter(0.25, above=0.0)  # of the robot's disc while no path was planned for it [m]
    max_acceleration: float = parameter(0.0, minimum=0.0)  # 0: as trackers have it [m/s^2]
    max_turn_rate: float = parameter(0.0, minimum=0.0)  # [rad/s]
    max_turn_acceleration: float = parameter(0.0, minimum=0.0)  # [rad/s^2]
    time_limit: float = parameter(10.0, above=0.0)  # for the coordinator to find a schedule [s, wall time]
    answer_limit: float = parameter(60.0, above=0.0)  # for any answer of planner and coordinator [s, wall time]
    feedback_rate: float = parameter(5.0, above=0.0)  # [Hz, wall time]
    news_timeout: float = parameter(3.0, above=0.0)  # without news from the tracker it counts as lost [s, wall time]
    trouble_time: float = parameter(2.0, minimum=0.0)  # stopped for so long, a robot needs another path [s]


class Navigator:
    """Takes goals, has them planned and coordinated, lets the tracker drive, and reports.

    Subscribers
        move_base_simple/goal (geometry_msgs/PoseStamped); progress (Progress): of this robot's tracker;
        fleet/schedules, fleet/following (Schedule): what the others drive; tf, for goals in other frames.
    Publishers
        current_goal (geometry_msgs/PoseStamped), latched; fleet/navigation (NavigationStatus), latched;
        hold (std_msgs/Bool), latched: the tracker stands while it is true; /diagnostics.
    Actions
        move_base (move_base_msgs/MoveBaseAction).
    Services
        ~make_plan, move_base/make_plan (nav_msgs/GetPlan): at any time; nobody drives these plans.
    Services called
        social_planner/plan_path (PlanPath), fleet_coordinator/coordinate (Coordinate).
    Parameters
        `NavigatorParameters`; those of `NavigationConfig`, see config/navigator.yaml.
    """

    def __init__(self) -> None:
        self._config, others = parameters.split_private(NavigatorParameters)
        self._navigation = Navigation(from_mapping(NavigationConfig, others, prefix=parameters.private_prefix()))
        self.robot = robot_name(self._config.robot)
        self._wake = threading.Event()
        self._progress: Optional[Progress] = None
        self._heard = 0.0  # when the tracker last said anything [s, wall time]
        self._stopped_since: Optional[float] = None
        self._path: Optional[PlannedPath] = None
        self._errand: Optional[_Errand] = None
        self._told: tuple = ()
        self._held = False
        self._fed = self._parking_due = 0.0  # [s, wall time]
        self._frames: Optional[Frames] = None  # made when first needed: /tf is busy
        limits = {name: getattr(self._config, name)
                  for name in ("max_acceleration", "max_turn_rate", "max_turn_acceleration")}
        self._errands = FleetErrands(self.robot, self._config.map_frame, limits=limits,
                                     time_limit=self._config.time_limit)
        self._current_goal = rospy.Publisher("current_goal", PoseStamped, latch=True, queue_size=1)
        self._status = rospy.Publisher("fleet/navigation", NavigationStatus, latch=True, queue_size=10)
        self._hold = rospy.Publisher("hold", Bool, latch=True, queue_size=1)
        self._diagnostics = Diagnostics(self.robot, {"goal": self._diagnose})
        rospy.Subscriber("progress", Progress, self._hear_progress, queue_size=10)
        self._goals = GoalServer(self._wake.set)
        self._services = [rospy.Service(name, GetPlan, self._serve_make_plan)
                          for name in ("~make_plan", "move_base/make_plan")]
        rospy.on_shutdown(self._wake.set)

    def _hear_progress(self, message: Progress) -> None:
        self._progress, self._heard = message, time.monotonic()
        self._wake.set()

    def spin(self) -> int:
        """Look after the goals until shutdown; all that changes them happens in this thread."""
        while not rospy.is_shutdown():
            self._look()
            self._wake.wait(_LOOK)
            self._wake.clear()
        self._goals.abort("the navigator was shut down")
        return 0

    def _look(self) -> None:
        """Take in what has come, and do what is next."""
        now = rospy.get_time()
        self._take_goals(now)
        if self._errand is not None and self._errand.over(self._config.answer_limit):
            errand, self._errand = self._errand, None
            errand.conclude(now)
        self._navigation.hear(self._news(now), now, busy=self._errand is not None)
        self._tell_ends()
        self._begin_errand()
        self._tell(now)
        self._diagnostics.update()

    def _take_goals(self, now: float) -> None:
        target = self._goals.take()
        if target is not None:
            try:
                goal = self._in_map(target)
            except InvalidInput as error:
                self._navigation.cancel(now, "another goal took its place, which is unusable")
                rospy.logwarn("%s: the goal is refused: %s", self.robot, error)
                self._goals.abort(str(error))
                return
            rospy.loginfo("%s: goal (%.2f, %.2f, %.2f)", self.robot, *goal)
            self._navigation.accept(goal, now)
            self._current_goal.publish(conversions.pose_to_stamped(goal, self._config.map_frame, rospy.Time.now()))
        if self._goals.taken_back:
            self._navigation.cancel(now)

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

    def _news(self, now: float) -> RobotNews:
        """What the tracker says, and what its silence means."""
        progress = self._progress
        if progress is None or time.monotonic() - self._heard > self._config.news_timeout:
            return RobotNews(0 if progress is None else progress.schedule_version, True, False,
                             "its tracker says nothing")
        standing = progress.speed == 0.0 and progress.turn_rate == 0.0
        if progress.state != Progress.STOPPED or not standing:
            self._stopped_since = None
        elif self._stopped_since is None:
            self._stopped_since = now
        lasting = self._stopped_since is not None and now - self._stopped_since >= self._config.trouble_time
        return RobotNews(progress.schedule_version, standing, progress.state == Progress.ARRIVED,
                         progress.reason if lasting else "")

    def _begin_errand(self) -> None:
        """Have done what the state asks for, in a thread of its own; one errand at a time."""
        navigation, number = self._navigation, self._navigation.number
        errand = navigation.errand
        if self._errand is not None or errand is Errand.NOTHING:
            return
        if errand is Errand.PARK and time.monotonic() < self._parking_due:
            return
        self._parking_due = time.monotonic() + _PARKING
        start, goal, path = self._pose(), navigation.goal, self._path
        if start is None:
            navigation.refused(number, rospy.get_time(), "its pose is not known")
        elif errand is Errand.PLAN and goal is not None:
            self._errand = _Errand(partial(self._errands.plan, start, goal), partial(self._have_path, number),
                                   partial(self._refused, number))
        elif errand is Errand.COORDINATE and path is not None:
            self._errand = _Errand(partial(self._errands.coordinate, path), partial(self._have_schedule, number),
                                   partial(self._refused, number))
        else:
            radius = self._config.radius if path is None else path.radius
            self._errand = _Errand(partial(self._errands.park, start, radius),
                                   lambda schedule, now: navigation.parked(now), self._parking_refused)

    def _have_path(self, number: int, path: PlannedPath, now: float) -> None:
        if self._navigation.planned(number, now):
            self._path = path

    def _have_schedule(self, number: int, schedule: Schedule, now: float) -> None:
        self._navigation.scheduled(number, schedule.version, now)

    def _refused(self, number: int, error: ErrandRefused, now: float) -> None:
        self._navigation.refused(number, now, str(error), final=error.final)

    def _parking_refused(self, error: ErrandRefused, now: float) -> None:
        rospy.logwarn_throttle(30.0, "%s: the fleet does not plan round it yet: %s" % (self.robot, error))

    def _pose(self) -> Optional[Pose]:
        """Where the tracker last measured the robot; None when that is not known."""
        if self._progress is None or not math.isfinite(self._progress.pose.x):
            return None
        pose = self._progress.pose
        return Pose(pose.x, pose.y, pose.theta)

    def _tell_ends(self) -> None:
        """Tell the client when its goal is done with."""
        navigation = self._navigation
        if navigation.state is NavigationState.SUCCEEDED:
            self._goals.succeed("arrived")
        elif navigation.state is NavigationState.CANCELED:
            self._goals.cancel(navigation.reason)
        elif navigation.state is NavigationState.ABORTED:
            self._goals.abort(navigation.reason)

    def _tell(self, now: float) -> None:
        """Publish what has changed; feedback at its rate."""
        navigation = self._navigation
        what = navigation.state, navigation.reason, navigation.version, navigation.goal
        if what != self._told:
            self._told = what
            self._hold.publish(navigation.holds)
            self._publish_status()
            log = rospy.logwarn if navigation.state in (NavigationState.WAITING, NavigationState.ABORTED) \
                else rospy.loginfo
            log("%s: %s%s", self.robot, navigation.state.name.lower(),
                f": {navigation.reason}" if navigation.reason else "")
        elif navigation.holds != self._held:
            self._hold.publish(navigation.holds)
        self._held = navigation.holds
        pose, progress = self._pose(), self._progress
        due = time.monotonic() - self._fed >= 1.0 / self._config.feedback_rate
        if due and pose is not None and progress is not None:
            self._fed = time.monotonic()
            self._goals.tell(pose, self._config.map_frame, progress.header.stamp)

    def _publish_status(self) -> None:
        navigation = self._navigation
        message = NavigationStatus(robot=self.robot, state=int(navigation.state), reason=navigation.reason,
                                   schedule_version=navigation.version, replans=navigation.replans)
        message.header.stamp, message.header.frame_id = rospy.Time.from_sec(navigation.since), self._config.map_frame
        if navigation.goal is not None:
            message.goal = Pose2D(*navigation.goal)
        self._status.publish(message)

    def _diagnose(self) -> Health:
        navigation = self._navigation
        level = {NavigationState.WAITING: Level.WARN, NavigationState.ABORTED: Level.WARN}.get(
            navigation.state, Level.OK)
        return level, navigation.reason or navigation.state.name.lower(), {
            "state": navigation.state.name, "schedule": navigation.version, "replans": navigation.replans}

    def _serve_make_plan(self, request: GetPlanRequest) -> GetPlanResponse:
        """GetPlan has no field for a reason: the log has it. A start without a frame is where the robot is now."""
        start = request.start
        pose = self._pose()
        if not start.header.frame_id and pose is not None:
            start = conversions.pose_to_stamped(pose, self._config.map_frame)
        try:
            return GetPlanResponse(plan=self._errands.inquire(start, request.goal, request.tolerance))
        except ErrandRefused as error:
            rospy.logwarn("%s: make_plan: %s", self.robot, error)
            return GetPlanResponse()


class _Errand:
    """A call that may take long, in a thread of its own."""

    def __init__(self, call: Callable, done: Callable, refused: "Callable[[ErrandRefused, float], None]") -> None:
        self._call, self._done, self._refused = call, done, refused
        self._begun = time.monotonic()
        self._ended = threading.Event()
        self._conclusion: Callable[[float], None] = lambda now: refused(
            ErrandRefused("planner or coordinator did not answer in time"), now)
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self) -> None:
        try:
            answer = self._call()
            self._conclusion = lambda now: self._done(answer, now)
        except ErrandRefused as error:
            reason = error
            self._conclusion = lambda now: self._refused(reason, now)
        except Exception as error:
            rospy.logerr("a fault of the node itself: %s", error)
            fault = ErrandRefused(f"a fault of the node itself: {error}", final=True)
            self._conclusion = lambda now: self._refused(fault, now)
        self._ended.set()

    def over(self, limit: float) -> bool:
        """Whether it has ended, or taken more than `limit` [s, wall time]."""
        return self._ended.is_set() or time.monotonic() - self._begun > limit

    def conclude(self, now: float) -> None:
        """Hand on what has come of it."""
        self._conclusion(now)
