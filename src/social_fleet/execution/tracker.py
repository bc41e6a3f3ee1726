"""Drives one robot along its schedule: what it commands at every control period. doc/execution.md has the reasons."""

import math
from typing import Mapping, Optional

from social_fleet.coordination.robot import MotionLimits
from social_fleet.coordination.schedule import Schedule
from social_fleet.execution.braking import approach, stopping_speed
from social_fleet.execution.config import TrackerConfig
from social_fleet.execution.course import Course, distance
from social_fleet.execution.flatness import ReferenceMotion, track
from social_fleet.execution.gate import PrecedenceGate, ReportedProgress, Waiting
from social_fleet.execution.itinerary import ALIGNED, Manoeuvres
from social_fleet.execution.pose_watch import PoseWatch
from social_fleet.execution.state import STANDSTILL, Command, ProgressState
from social_fleet.execution.whereabouts import Whereabouts
from social_fleet.geometry import Pose, wrap_angle

_MISALIGNED = 0.6  # the robot stops and turns in place when it points this far off its way [rad]
_STANDING = 0.03  # a standing robot is left where it is when it is this close to its reference [m]
_STALL = 0.5  # a moving robot brakes when its last command is older than this [s]
_SPARE = 0.05  # of a stopping distance: what tracking may be ahead by [m]


class Tracker:
    """Follows a schedule: reference, gate, turns in place, tracking law and limits.

    Call `step` once per control period. Commands keep to the robot's limits of speed, turn rate and both
    accelerations from one to the next, starting from standstill.

    Parameters
    ----------
    schedule : Schedule, optional
        What to drive; None stands.
    config : TrackerConfig
        Gains and tolerances.

    Attributes
    ----------
    state : ProgressState
        What it does.
    reason : str
        Why it is STOPPED, as a sentence; empty otherwise.
    waiting_for : Waiting, optional
        Whom it waits for when it is HOLDING.
    command : Command
        The last command.
    pose_believed : bool
        Whether the last pose was known and no jump.
    """

    def __init__(self, schedule: Optional[Schedule] = None, config: TrackerConfig = TrackerConfig()) -> None:
        self.config = config
        self.schedule: Optional[Schedule] = None
        self.state = ProgressState.IDLE
        self.reason = ""
        self.command = STANDSTILL
        self.pose_believed = False
        self.waiting_for: Optional[Waiting] = None
        self._gate = PrecedenceGate(standoff=config.standoff, release_tolerance=config.release_tolerance)
        self._watch = PoseWatch(jump=config.pose_jump, settle=config.pose_settle)
        self._where = Whereabouts(config)
        self._limits = MotionLimits()
        self._course: Course
        self._last: Optional[float] = None
        self._elapsed_truly = config.period
        self._stalled = 0.0  # how long ago the last step was, when that is too long for a moving robot [s]
        self._pose: Optional[Pose] = None
        self._correcting = False
        self._realigning = False
        if schedule is not None:
            self.follow(schedule)

    def follow(self, schedule: Schedule, *, origin: Optional[float] = None) -> None:
        """Drive `schedule` from the next step on.

        On the path that is driven already, only times and precedences change. Another path begins at its start, on
        the move where the robot drives along it already.

        Parameters
        ----------
        origin : float, optional
            The new path runs along the present one from this arc length on, at least to where the robot has come [m]:
            the robot goes on without a pause.
        """
        if self.schedule is not None and origin is not None:
            course = Course(schedule, moving=self._course.governor.speed > 0.0)
            course.continue_from(self._course, origin)
            self._begin(course, max(self._where.progress - origin, 0.0))
        elif self._drives_path_of(schedule):
            self._course.retime(schedule)
        else:
            moving = self._pose is not None and self.command.speed > 0.0
            course = Course(schedule, moving=moving)
            if moving and self._pose is not None:
                course.join(self._pose, self.command.speed, self.config.lateral_limit)
            self._begin(course, 0.0)
        self.schedule = schedule
        self._limits = schedule.robot.limits
        self._manoeuvres = Manoeuvres(self._limits)
        self._gate.follow(schedule)

    def cancel(self) -> None:
        """Brake to a standstill and follow nothing."""
        self.schedule = None
        self.state = ProgressState.IDLE
        self._where.begin()

    @property
    def reference(self) -> Optional[Pose]:
        """Where the robot ought to be [m, rad, map frame]; None without a schedule."""
        return None if self.schedule is None else self._course.reference

    @property
    def progress(self) -> float:
        """Arc length that the robot was measured to have reached [m]; never falls on one path."""
        return self._where.progress

    @property
    def tracking_error(self) -> float:
        """Distance between the measured pose and the reference at the last step [m]."""
        return self._where.tracking_error

    @property
    def excursion(self) -> float:
        """See `Whereabouts.excursion` [m]."""
        return self._where.excursion

    @property
    def needs_path(self) -> bool:
        """Whether the robot stands where it cannot drive on on its path."""
        return self.schedule is not None and self._where.lost

    @property
    def arrived(self) -> bool:
        """Whether the robot stands at its goal."""
        return self.state is ProgressState.ARRIVED

    @property
    def gate_bound(self) -> float:
        """The arc length that others do not yet let it pass [m]; infinite when nobody holds it."""
        return self._gate.bound

    def stopping_arc_length(self, lookahead: float = 0.0) -> float:
        """The arc length [m] at which the robot can stand after it has driven on for `lookahead` [s], goal at most."""
        if self.schedule is None:
            return 0.0
        governor = self._course.governor
        speed = max(governor.speed, self.command.speed)
        room = (speed * (lookahead + 2.0 * self.config.period)
                + speed * speed / (1.5 * self._limits.max_acceleration) + _SPARE)
        return min(max(governor.arc_length, self.progress) + room, self._course.path.length)

    def report(self, now: float) -> ReportedProgress:
        """What the other robots are to be told."""
        return ReportedProgress(0 if self.schedule is None else self.schedule.version, self.progress, now)

    def step(self, now: float, pose: Optional[Pose], others: Mapping[str, ReportedProgress], *,
             pose_stamp: Optional[float] = None, horizon: float = math.inf, ahead: float = math.inf,
             halt: str = "") -> Command:
        """The command for the period that begins at `now`.

        Parameters
        ----------
        now : float
            Time on the fleet's clock [s].
        pose : Pose, optional
            Where the robot is [m, rad, map frame]; None when that is not known.
        others : mapping of str to ReportedProgress
            The latest report of every other robot that was heard of.
        pose_stamp : float, optional
            When the pose was measured [s]; `now` by default.
        horizon : float
            Arc length that must not be passed for what the robot's sensors see [m].
        ahead : float
            How far the robot can drive straight on for what its sensors see [m].
        halt : str
            Why the robot must stand whatever its schedule says, as a sentence; empty when it need not.
        """
        if now == self._last:
            return self.command
        if self.arrived and self.command == STANDSTILL:
            self._last = now
            self.pose_believed = pose is not None and self._watch.believes(now, pose, self._limits)
            return STANDSTILL
        period = self._elapsed(now)
        self._gate.hear(others)
        self.waiting_for = None
        self.reason = self._trouble(now, pose, pose_stamp, halt)
        wanted = STANDSTILL
        if self.reason:
            self._course.brake(period)
            self.state = ProgressState.STOPPED
        elif self.schedule is not None and not self.arrived and pose is not None:
            wanted = self._act(now, period, pose, horizon)
        if ahead < math.inf:
            braking = 0.8 * self._limits.max_acceleration
            wanted = Command(min(wanted.speed, stopping_speed(ahead, braking, period)), wanted.turn_rate)
        self.command = self._limited(wanted, self._elapsed_truly)
        return self.command

    def _elapsed(self, now: float) -> float:
        """Time since the last step [s], as far as it can be believed: clocks start anew, and processes stall."""
        elapsed = self.config.period if self._last is None else now - self._last
        self._last = now
        self._stalled = elapsed if elapsed > _STALL and self.command != STANDSTILL else 0.0
        if elapsed < 0.0:
            elapsed = self.config.period
        self._elapsed_truly = min(elapsed, 4.0 * self.config.period)
        return max(self._elapsed_truly, 0.2 * self.config.period)

    def _drives_path_of(self, schedule: Schedule) -> bool:
        if self.schedule is None:
            return False
        old, new = self.schedule.robot, schedule.robot
        return old.goal_yaw == new.goal_yaw and old.path.points.tolist() == new.path.points.tolist()

    def _begin(self, course: Course, progress: float) -> None:
        self._course = course
        self._where.begin(progress)
        self._correcting = False
        self._realigning = False
        self.state = ProgressState.IDLE

    def _trouble(self, now: float, pose: Optional[Pose], stamp: Optional[float], halt: str) -> str:
        """Why the robot must not move, as a sentence; looks at the pose on the way."""
        known = pose is not None and all(map(math.isfinite, pose))
        self.pose_believed = known and pose is not None and self._watch.believes(now, pose, self._limits)
        if self.schedule is None or self.arrived:
            return ""
        if pose is None or not known:
            return "the pose is not known"
        if stamp is not None and now - stamp > self.config.pose_timeout:
            return f"the pose is {now - stamp:.2f} s old"
        if not self.pose_believed:
            return self._watch.reason
        self._pose = pose
        self._where.observe(pose, self._course)
        if self._stalled:
            return f"the last command was {self._stalled:.2f} s ago"
        trouble = self._where.trouble()
        if trouble and (self._where.returning or self.command == STANDSTILL):
            trouble = self._where.rejoin(pose, self._course)
        return trouble or halt

    def _act(self, now: float, period: float, pose: Pose, horizon: float) -> Command:
        """The wanted command, before limits."""
        assert self.schedule is not None
        course = self._course
        if course.turning and course.leg == 0 and now < self.schedule.times[0]:
            self.state = ProgressState.IDLE
            return STANDSTILL
        if self._where.returning:
            self.state = ProgressState.DRIVING
            return self._manoeuvres.creep(course.reference, pose, self.command.turn_rate, period)
        if self._correcting:
            return self._correct(pose, period)
        if course.turning:
            target = course.last_stop.heading
            if target is not None and not self._manoeuvres.turned(target, pose, self.command.turn_rate, period):
                self.state = ProgressState.TURNING
                course.reference = course.reference._replace(yaw=target)
                return Command(0.0, self._manoeuvres.turn(target, pose, self.command.turn_rate, period))
            if course.at_goal:
                return self._finish(pose, period)
            course.turning = False
            course.reference = course.path.pose(course.leg, course.governor.arc_length)
        if self._misaligned(pose):
            course.brake(period)
            self.state = ProgressState.TURNING
            return Command(0.0, self._manoeuvres.turn(course.reference.yaw, pose, self.command.turn_rate, period))
        return self._drive(now, period, pose, horizon)

    def _drive(self, now: float, period: float, pose: Pose, horizon: float) -> Command:
        """Follow the reference to the next stop."""
        course = self._course
        old, old_speed = course.reference, course.reference_speed
        lag = math.cos(old.yaw) * (old.x - pose.x) + math.sin(old.yaw) * (old.y - pose.y)
        patience = (self.config.lag_end - lag) / (self.config.lag_end - self.config.lag_begin)
        course.advance(now, period, bound=min(self._gate.bound, horizon), patience=min(max(patience, 0.0), 1.0))
        self._tell_holding(now)
        if course.reference_speed == 0.0 and old_speed == 0.0 and lag < _STANDING:
            if (course.governor.arc_length == course.next_stop.arc_length
                    and self.command.speed <= self._limits.max_acceleration * period):
                course.leg += 1
                course.turning = True
            return STANDSTILL
        turn_rate = wrap_angle(course.reference.yaw - old.yaw) / period
        motion = ReferenceMotion(old.x, old.y, old.yaw, old_speed, course.reference_speed, turn_rate)
        return Command(*track(pose, self.command.speed, motion, period, self.config))

    def _tell_holding(self, now: float) -> None:
        """Tell driving from holding at the gate."""
        governor = self._course.governor
        held = (governor.speed == 0.0 and governor.arc_length >= self._gate.bound - 1e-3
                and governor.scheduled(now) > governor.arc_length + 1e-3)
        self.state = ProgressState.HOLDING if held else ProgressState.DRIVING
        if held:
            self.waiting_for = self._gate.waiting_for(now)
        else:
            self._gate.moving()

    def _misaligned(self, pose: Pose) -> bool:
        """Whether the robot must turn in place before it can follow, with hysteresis."""
        error = abs(wrap_angle(self._course.reference.yaw - pose.yaw))
        self._realigning = error > (5.0 * ALIGNED if self._realigning else _MISALIGNED)
        return self._realigning

    def _finish(self, pose: Pose, period: float) -> Command:
        """At the end of the path, turned: arrived, or to be corrected."""
        if distance(self._course.goal, pose) <= self.config.position_tolerance:
            self.state = ProgressState.ARRIVED
            self._where.progress = self._course.path.length
            return STANDSTILL
        self._correcting = True
        return self._correct(pose, period)

    def _correct(self, pose: Pose, period: float) -> Command:
        """Creep to the goal's position; its heading comes after."""
        goal = self._course.goal
        self.state = ProgressState.DRIVING
        if distance(goal, pose) <= 0.5 * self.config.position_tolerance:
            self._correcting = False
            return STANDSTILL
        return self._manoeuvres.creep(goal, pose, self.command.turn_rate, period)

    def _limited(self, wanted: Command, period: float) -> Command:
        """The nearest command to `wanted` that the robot can carry out."""
        limits = self._limits
        speed = min(max(wanted.speed, 0.0), limits.max_speed)
        turn_rate = min(max(wanted.turn_rate, -limits.max_turn_rate), limits.max_turn_rate)
        return Command(approach(self.command.speed, speed, limits.max_acceleration * period),
                       approach(self.command.turn_rate, turn_rate, limits.max_turn_acceleration * period))
