"""The coordinator's conversation with the robots: reports in, directives out. The decisions are the dispatcher's."""

import threading
import time
from collections import deque
from typing import Any, Callable, Deque, Dict, Optional, Set, Tuple

import rosgraph
import rospy

from social_fleet.coordination.schedule import Schedule
from social_fleet.errors import InvalidInput
from social_fleet.execution.recovery.config import RecoveryConfig
from social_fleet.execution.recovery.dispatcher import Dispatcher
from social_fleet.execution.recovery.messages import Report
from social_fleet.execution.recovery.replanning import Options, Replanning
from social_fleet.msg import Directive as DirectiveMessage, RobotReport, Schedule as ScheduleMessage
from social_fleet.planning.planner import SocialPlanner
from social_fleet.ros import exchange_conversions as exchange
from social_fleet.ros.diagnostics import Health, Level
from social_fleet.ros.planner_notices import PlannerNotices

_PERIOD = 0.1  # between two looks at what has come [s, wall time]


class FleetDispatch:
    """Runs a dispatcher in a thread of its own, from the first goal of a navigator on.

    Until then schedules come from Coordinate requests alone, and nobody is told anything.

    Subscribers
        fleet/reports (RobotReport), fleet/following (Schedule).
    Publishers
        fleet/directives (Directive); and see `PlannerNotices`.

    Parameters
    ----------
    frame
        The map's frame.
    config
        Times.
    options
        Of coordination.
    planner_for
        The planner for robots of a radius [m]; raises NotReady while there is no map.
    ready
        Whether there is a map.
    told
        Called with the messages of schedules that have been made.
    """

    def __init__(self, frame: str, config: RecoveryConfig, options: Options,
                 planner_for: Callable[[float], SocialPlanner], *, ready: Callable[[], bool],
                 told: Callable[[Dict[str, ScheduleMessage]], None]) -> None:
        self.active = False
        self._frame, self._config, self._ready, self._told = frame, config, ready, told
        self._notices = PlannerNotices(frame)
        self._dispatcher = Dispatcher(Replanning(planner_for, options), config)
        self._clock = exchange.FleetClock(rospy.Time.now())
        self._inbox: Deque[RobotReport] = deque()
        self._heard: Dict[str, rospy.Time] = {}  # stamp of the latest report of each robot, also while planning
        self._callers: Set[str] = set()
        self._following: Dict[str, Dict[int, ScheduleMessage]] = {}  # by robot and version
        self._adopted: Dict[Tuple[str, int], Schedule] = {}
        self._given: Dict[str, int] = {}  # latest version that was made for each robot
        self._since = time.monotonic()
        self._complete = False
        self._last: Optional[DirectiveMessage] = None
        self._said = 0.0  # [s, wall time]
        self._lock = threading.Lock()  # of publishing
        self._directives = rospy.Publisher("fleet/directives", DirectiveMessage, queue_size=20)
        rospy.Subscriber("fleet/following", ScheduleMessage, self._hear_following, queue_size=100)
        rospy.Subscriber("fleet/reports", RobotReport, self._hear_report, queue_size=1000, tcp_nodelay=True)
        for work in (self._run, self._beat):
            threading.Thread(target=work, daemon=True).start()

    def _hear_report(self, message: RobotReport) -> None:
        self._inbox.append(message)
        if message.relayed:
            return
        self._callers.add(message._connection_header["callerid"])
        self._heard[message.robot] = message.header.stamp
        if message.errand.number and not message.errand.idle and message.errand.number != message.schedule_version \
                and not self.active:
            rospy.loginfo("%s has a goal: the fleet is kept supplied with schedules from now on", message.robot)
            self.active = True

    def _hear_following(self, message: ScheduleMessage) -> None:
        known = self._following.get(message.robot, {})
        latest = sorted([*known, message.version])[-2:]  # a report may still speak of the one before
        self._following[message.robot] = {version: item for version, item in (
            *known.items(), (message.version, message)) if version in latest}

    def _run(self) -> None:
        while not rospy.is_shutdown():
            try:
                self._step()
            except rospy.ROSInterruptException:
                return
            except Exception:
                rospy.logerr("a fault of the dispatcher:", exc_info=True)
            rospy.rostime.wallsleep(_PERIOD)

    def _step(self) -> None:
        """Hand the reports on, and say what comes of them."""
        known = self._take_reports()
        if not (self.active and known and self._ready() and self._all_heard()):
            return
        directive = self._dispatcher.step(self._clock.seconds(rospy.Time.now()))
        if directive is None:
            return
        message = exchange.directive_to_message(directive, self._frame, self._clock)
        self._say(message)
        self._notices.show(directive.obstacles)
        new = {item.schedule.robot: item.schedule for item in message.assignments
               if item.schedule.version > self._given.get(item.schedule.robot, 0)}
        for item in message.assignments:
            self._notices.announce(item)
        self._given.update((name, schedule.version) for name, schedule in new.items())
        if new:
            self._told(new)

    def _take_reports(self) -> bool:
        """Whether the dispatcher knows what every robot follows that it has heard of."""
        waiting = []
        while self._inbox:
            message = self._inbox.popleft()
            try:
                report = self._converted(message)
            except InvalidInput as error:
                rospy.logwarn_throttle(10.0, "a report is left out: %s" % error)
                continue
            if report is None:
                waiting.append(message)
            else:
                self._dispatcher.hear(report)
        latest = {message.robot: message for message in waiting}
        self._inbox.extendleft(latest.values())
        return not latest

    def _converted(self, message: RobotReport) -> Optional[Report]:
        """The report; None while the schedule that it speaks of is not known, and the robot not gone."""
        version, key = message.schedule_version, (message.robot, message.schedule_version)
        if message.relayed or version == 0 or version == self._given.get(message.robot):
            return exchange.report_from_message(message, self._clock)
        if key not in self._adopted:
            following = self._following.get(message.robot, {}).get(version)
            if following is None:
                age = (rospy.Time.now() - message.header.stamp).to_sec()
                return None if age <= self._config.gone else exchange.report_from_message(message, self._clock)
            self._adopted = {known: schedule for known, schedule in self._adopted.items() if known[0] != key[0]}
            self._adopted[key] = exchange.schedule_from_absolute(following, self._frame, self._clock)
        return exchange.report_from_message(message, self._clock, self._adopted[key])

    def _all_heard(self) -> bool:
        """Whether every tracker that the master knows was heard; one that is not after `gone` is gone."""
        if not self._complete:
            publishers = dict(rosgraph.Master(rospy.get_name()).getSystemState()[0])
            expected = set(publishers.get(rospy.resolve_name("fleet/reports"), ()))
            self._complete = expected <= self._callers or time.monotonic() - self._since > self._config.gone
        return self._complete

    def _beat(self) -> None:
        """Robots stand when they learn that nobody hears them: say that they are heard while a plan is made."""
        while not rospy.is_shutdown():
            rospy.rostime.wallsleep(0.5 * self._config.beat)
            last = self._last
            if last is not None and time.monotonic() - self._said > self._config.beat:
                names = sorted(self._heard)
                message = DirectiveMessage(robots=names, heard=[self._heard[name] for name in names],
                                           exchange=last.exchange, obstacles=last.obstacles)
                message.header.frame_id, message.header.stamp = self._frame, rospy.Time.now()
                self._say(message, keep=False)

    def _say(self, message: DirectiveMessage, *, keep: bool = True) -> None:
        with self._lock:
            if rospy.is_shutdown():
                return
            self._directives.publish(message)
            self._said = time.monotonic()
            if keep:
                self._last = message

    def diagnose(self) -> Health:
        """How the exchange of schedules goes."""
        dispatcher = self._dispatcher
        values: Dict[str, Any] = {"exchanges": dispatcher.exchanges, "robots": len(self._heard)}
        values.update((f"replans of {name}", count) for name, count in sorted(dispatcher.replans.items()))
        now = rospy.Time.now()
        silent = sorted(name for name, stamp in list(self._heard.items())
                        if (now - stamp).to_sec() > self._config.lapse)
        if not self.active:
            return Level.OK, "schedules come from requests", values
        if silent:
            return Level.ERROR, f"silent: {', '.join(silent)}", values
        return Level.OK, dispatcher.decisions[-1] if dispatcher.decisions else "nothing to decide", values
