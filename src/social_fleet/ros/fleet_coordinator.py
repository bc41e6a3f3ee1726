"""The node fleet_coordinator: schedules that keep the fleet apart, and their distribution."""

import copy
import threading
from dataclasses import dataclass, replace
from typing import Dict, List, Optional, Tuple

import genpy
import numpy as np
import rospy
from nav_msgs.msg import OccupancyGrid as GridMessage
from rospy.numpy_msg import numpy_msg

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.replanning import PlannerReplanner
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import FleetSchedule, Schedule
from social_fleet.errors import InvalidScenario
from social_fleet.execution.recovery.config import RecoveryConfig
from social_fleet.execution.recovery.replanning import Options
from social_fleet.msg import EncounterWindow, Progress, Schedule as ScheduleMessage
from social_fleet.parameters import parameter
from social_fleet.ros import conversions, parameters
from social_fleet.ros.admission import check_all_considered, check_clear, check_in_force, next_version
from social_fleet.ros.diagnostics import Diagnostics
from social_fleet.ros.fleet_dispatch import FleetDispatch
from social_fleet.ros.paths import resolve_path
from social_fleet.ros.planning_fleet import PlanningFleet, read_config
from social_fleet.ros.repeating_publisher import RepeatingPublisher
from social_fleet.ros.statuses import COORDINATE_STATUSES, status_of
from social_fleet.scenario.files import load_scenario
from social_fleet.srv import Coordinate, CoordinateRequest, CoordinateResponse


@dataclass(frozen=True)
class FleetCoordinatorParameters:
    """Parameters of the node; all others in its namespace are those of `PlannerConfig`, for repairs."""

    map_frame: str = "map"
    formulation: str = parameter("exact", choices=("exact",))  # paper schedules touch, and nothing holds robots to them
    time_margin: float = parameter(1.0, minimum=0.0)  # delta, for requests that leave theirs at 0 [s]
    time_limit: float = parameter(30.0, above=0.0)  # for requests that leave theirs at 0 [s, wall time]
    tracking_tolerance: float = parameter(0.1, minimum=0.0)  # how far a robot may be from its schedule [m]
    start_delay: float = parameter(2.0, minimum=0.0)  # from the answer to time zero, for schedules to arrive [s]
    replan_time_limit: float = parameter(4.0, above=0.0)  # for schedules of robots under way [s, wall time]
    repair: bool = True  # replan a robot where the given paths admit no schedule; needs the map
    scenario: str = ""  # a scenario file whose `coordination` and `planner` go before the parameters


class FleetCoordinator:
    """Coordinates on request; once a navigator has a goal, keeps robots supplied with schedules (`FleetDispatch`).

    Subscribers
        fleet/progress (Progress): a robot on an older schedule than its present one is sent that again; one that may
        move must be part of every request.
        map (nav_msgs/OccupancyGrid): for repairs. Those of `FleetDispatch`.
    Publishers
        fleet/schedules (Schedule), fleet/windows (EncounterWindow): sent again to late subscribers.
        fleet/directives (Directive), /diagnostics.
    Services
        ~coordinate (Coordinate).
    Parameters
        `FleetCoordinatorParameters`; those of `PlannerConfig`, see config/planner.yaml; `recovery`, a mapping of those
        of `RecoveryConfig`, see config/recovery.yaml.
    """

    def __init__(self) -> None:
        self._config, others = parameters.split_private(FleetCoordinatorParameters)
        if self._config.scenario:
            self._config = as_scenario(self._config)
        recovery = RecoveryConfig.from_mapping(others.pop("recovery", {}),
                                               prefix=f"{parameters.private_prefix()}recovery/")
        self._planner_config, _ = read_config(others, self._config.scenario, parameters.private_prefix())
        self._version = 0
        self._lock = threading.Lock()  # of the map, what is made of it, and progress
        self._progress: Dict[str, Progress] = {}
        self._map: Optional[GridMessage] = None
        self._planners: Optional[PlanningFleet] = None
        self._coordinating = threading.Lock()
        self._schedules = RepeatingPublisher("fleet/schedules", ScheduleMessage)
        self._windows = RepeatingPublisher("fleet/windows", EncounterWindow)
        config = self._config
        self._warm = threading.Event()
        threading.Thread(target=self._warm_up, daemon=True).start()
        options = Options(config.time_margin, config.tracking_tolerance, config.replan_time_limit)
        self._dispatch = FleetDispatch(config.map_frame, recovery, options, self._planner_for,
                                       ready=self._is_ready, told=self._schedules.publish)
        self._diagnostics = Diagnostics("fleet", {"exchange of schedules": self._dispatch.diagnose})
        rospy.Timer(rospy.Duration(0.5), lambda _: self._diagnostics.update(), reset=True)
        rospy.Subscriber("fleet/progress", Progress, self._hear_progress, queue_size=100)
        rospy.Subscriber("map", numpy_msg(GridMessage), self._hear_map, queue_size=1)
        self._service = rospy.Service("~coordinate", Coordinate, self._serve)

    def _warm_up(self) -> None:
        """Compile, or load, what the first coordination would wait for beyond its time limit."""
        coordinate([Robot("east", np.array([(0.0, 0.0), (6.0, 0.0)]), committed=0.5),
                    Robot("north", np.array([(3.0, -3.0), (3.0, 3.0)]))])
        self._warm.set()

    def _is_ready(self) -> bool:
        """Whether schedules can be made; builds the planner of most robots on the way."""
        if self._map is None or not self._warm.is_set():
            return False
        self._planner_for(self._planner_config.robot_radius)
        return True

    def _hear_map(self, message: GridMessage) -> None:
        """Keep the map; planners are built from it when a repair first needs one."""
        with self._lock:
            self._map, self._planners = message, None

    def _hear_progress(self, message: Progress) -> None:
        """Schedules are sent as they come into force; what got lost shows here."""
        with self._lock:
            self._progress[message.robot] = message
        schedule = self._schedules.last(message.robot)
        if not self._dispatch.active and schedule is not None and message.schedule_version < schedule.version \
                and (message.header.stamp - schedule.header.stamp).to_sec() > 0.0:
            rospy.logwarn_throttle(1.0, "robot %s has not taken up schedule %d; sending it again" % (
                message.robot, schedule.version))
            self._schedules.repeat(message.robot)

    def _serve(self, request: CoordinateRequest) -> CoordinateResponse:
        with self._coordinating:
            try:
                fleet, time_zero = self._coordinate(request)
            except Exception as error:
                rospy.logwarn("no schedule: %s", error)
                return CoordinateResponse(status=status_of(error, COORDINATE_STATUSES),
                                          message=str(error) or type(error).__name__)
            schedules, amended, windows = self._put_in_force(fleet, time_zero, request.fixed)
        rospy.loginfo("scheduled %d robots, %d windows: encounters %.3f s, program %.3f s%s", len(schedules),
                      len(windows), fleet.encounter_time, fleet.solve_time,
                      f", repairs {fleet.planning_time:.3f} s ({fleet.message})" if fleet.message else "")
        return CoordinateResponse(status=CoordinateResponse.SUCCESS, message=fleet.message, schedules=schedules,
                                  amended=amended, windows=windows, objective=fleet.objective, gap=fleet.gap,
                                  solve_time=fleet.encounter_time + fleet.solve_time)

    def _coordinate(self, request: CoordinateRequest) -> Tuple[FleetSchedule, Optional[genpy.Time]]:
        """Schedules that may come into force, and their time zero; None when nothing is fixed: it is decided then."""
        frame, config = self._config.map_frame, self._config
        if self._dispatch.active:
            raise InvalidScenario("robots drive to their navigators' goals; give the others theirs, or start the "
                                  "coordinator and the trackers anew", field="planning")
        with self._lock:
            progress = list(self._progress.values())
        check_all_considered(progress, [message.robot for message in [*request.planning, *request.fixed]],
                             self._schedules.last)
        check_in_force(request.fixed, self._schedules.last, rospy.Time.now())
        self._version = next_version([self._version, *(news.schedule_version for news in progress),
                                      *(message.version for message in request.fixed)])
        robots = [conversions.robot_from_planned_path(item, frame) for item in request.planning]
        time_zero, fixed = self._read_fixed(request.fixed)
        if time_zero is not None:
            earliest = (rospy.Time.now() - time_zero).to_sec() + config.start_delay
            robots = [replace(robot, depart=max(robot.depart, earliest)) for robot in robots]
        replanner = PlannerReplanner(self._planner_for) if config.repair and self._map is not None else None
        fleet = coordinate(robots, fixed=fixed, mode="unified" if fixed else "simultaneous",
                           formulation=config.formulation, time_margin=request.time_margin or config.time_margin,
                           tracking_tolerance=config.tracking_tolerance,
                           time_limit=request.time_limit or config.time_limit, replanner=replanner,
                           version=self._version)
        check_clear(fleet.schedules, fixed)
        return fleet, time_zero

    def _read_fixed(self, messages: List[ScheduleMessage]) -> Tuple[Optional[genpy.Time], List[Schedule]]:
        """The fixed schedules on one clock, and that clock's zero: the earliest of theirs."""
        if not messages:
            return None, []
        time_zero = min(message.header.stamp for message in messages)
        return time_zero, [
            conversions.schedule_from_message(message, self._config.map_frame).shifted(
                (message.header.stamp - time_zero).to_sec()) for message in messages]

    def _planner_for(self, radius: float):  # type: ignore[no-untyped-def]
        with self._lock:
            if self._planners is None:
                self._planners = PlanningFleet(conversions.grid_from_message(self._map), self._planner_config)
            return self._planners.planner(radius)

    def _put_in_force(self, fleet: FleetSchedule, time_zero: Optional[genpy.Time], fixed: List[ScheduleMessage]
                      ) -> Tuple[List[ScheduleMessage], List[ScheduleMessage], List[EncounterWindow]]:
        """Publish, remember and return the messages: schedules, amended ones, windows."""
        zero = time_zero or rospy.Time.now() + rospy.Duration(self._config.start_delay)
        schedules = [conversions.schedule_to_message(schedule, self._config.map_frame, zero)
                     for schedule in fleet.schedules]
        windows = [conversions.window_to_message(window, self._version) for window in fleet.windows]
        amended = _amended(fixed, fleet.amended)
        self._schedules.publish({message.robot: message for message in schedules + amended}, replace=time_zero is None)
        self._windows.publish({(self._version, index): message for index, message in enumerate(windows)},
                              replace=time_zero is None)
        return schedules, amended, windows


def as_scenario(config: FleetCoordinatorParameters) -> FleetCoordinatorParameters:
    """What the scenario file says of coordination, put before the parameters."""
    path = resolve_path(config.scenario)
    options = load_scenario(path).coordination
    if options.formulation != config.formulation:
        raise InvalidScenario(f"must be {config.formulation} to be put in force, not {options.formulation}, whose "
                              "schedules let robots touch", source=str(path), field="coordination.formulation")
    return replace(config, time_limit=options.time_limit, time_margin=options.time_margin,
                   tracking_tolerance=options.tracking_tolerance)


def _amended(given: List[ScheduleMessage], amended: Tuple[Schedule, ...]) -> List[ScheduleMessage]:
    """The given messages with the precedences that they have now; all else stays as it is to the last bit."""
    originals = {message.robot: message for message in given}
    messages = []
    for schedule in amended:
        message = copy.copy(originals[schedule.name])
        message.precedences = conversions.precedences_to_messages(schedule.precedences)
        messages.append(message)
    return messages
