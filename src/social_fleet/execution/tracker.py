"""Drives one robot along its schedule: what it commands at every control period. doc/execution.md has the reasons."""

import math
from typing import Mapping, Optional

from social_fleet.coordination.robot import MotionLimits
from social_fleet.coordination.schedule import Schedule
from social_fleet.execution.braking import approach
from social_fleet.execution.config import TrackerConfig
from social_fleet.execution.flatness import ReferenceMotion, track
from social_fleet.execution.gate import PrecedenceGate, ReportedProgress, Waiting
from social_fleet.execution.governor import Governor
from social_fleet.execution.itinerary import ALIGNED, Manoeuvres, Stop, itinerary
from social_fleet.execution.reference_path import ReferencePath
from social_fleet.execution.state import STANDSTILL, Command, ProgressState
from social_fleet.geometry import Pose, wrap_angle

_MISALIGNED = 0.6  # the robot stops and turns in place when it points this far off its way [rad]
_STANDING = 0.03  # a standing robot is left where it is when it is this close to its reference [m]
_JOIN_ANGLE = 0.2  # a new path is joined on the move by a robot that points this well along it [rad]
_REJOIN = 2.0  # how far along the path a stopped robot may have been moved to drive on from there [m]
_STALL = 0.5  # a moving robot brakes when its last command is older than this [s]
_WINDOW = 0.5  # how far around the reference the robot is looked for on its path [m]


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
    progress : float
        Arc length that the robot was measured to have reached [m]; never falls on one path.
    state : ProgressState
        What it does.
    reason : str
        Why it is STOPPED, as a sentence; empty otherwise.
    waiting_for : Waiting, optional
        Whom it waits for when it is HOLDING.
    tracking_error : float
        Distance between the measured pose and the reference at the last step [m].
    excursion : float
        Distance between the measured pose and the way from the robot's progress to the reference [m]: what the robot
        is aside, ahead of its reference, or behind what it reported; mere lag is none.
    command : Command
        The last command.
    """

    def __init__(self, schedule: Optional[Schedule] = None, config: TrackerConfig = TrackerConfig()) -> None:
        self.config = config
        self.schedule: Optional[Schedule] = None
        self.state = ProgressState.IDLE
        self.reason = ""
        self.progress = 0.0
        self.tracking_error = 0.0
        self.excursion = 0.0
        self.command = STANDSTILL
        self.waiting_for: Optional[Waiting] = None
        self._gate = PrecedenceGate(standoff=config.standoff, release_tolerance=config.release_tolerance)
        self._limits = MotionLimits()
        self._governor: Governor
        self._last: Optional[float] = None
        self._stalled = 0.0  # how long ago the last step was, when that is too long for a moving robot [s]
        self._pose: Optional[Pose] = None
        if schedule is not None:
            self.follow(schedule)

    def follow(self, schedule: Schedule) -> None:
        """Drive `schedule` from the next step on.

        On the path that is driven already, only times and precedences change. Another path begins at its start, on
        the move where the robot drives along it already.
        """
        known = self._drives_path_of(schedule)
        if not known:
            self._begin(schedule)
        governor = Governor(schedule, self._path)
        if known:
            governor.arc_length, governor.speed = self._governor.arc_length, self._governor.speed
        else:
            self._join(governor)
        self._governor = governor
        self.schedule = schedule
        self._limits = schedule.robot.limits
        self._manoeuvres = Manoeuvres(self._limits)
        self._gate.follow(schedule)

    def cancel(self) -> None:
        """Brake to a standstill and follow nothing."""
        self.schedule = None
        self.state = ProgressState.IDLE
        self.progress = 0.0

    @property
    def reference(self) -> Optional[Pose]:
        """Where the robot ought to be [m, rad, map frame]; None without a schedule."""
        return None if self.schedule is None else self._reference

    @property
    def arrived(self) -> bool:
        """Whether the robot stands at its goal."""
        return self.state is ProgressState.ARRIVED

    def report(self, now: float) -> ReportedProgress:
        """What the other robots are to be told."""
        return ReportedProgress(0 if self.schedule is None else self.schedule.version, self.progress, now)

    def step(self, now: float, pose: Optional[Pose], others: Mapping[str, ReportedProgress], *,
             pose_stamp: Optional[float] = None, horizon: float = math.inf) -> Command:
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
        """
        if now == self._last:
            return self.command
        period = self._elapsed(now)
        self._gate.hear(others)
        self.waiting_for = None
        self.reason = self._trouble(now, pose, pose_stamp)
        wanted = STANDSTILL
        if self.reason:
            self._brake(period)
            self.state = ProgressState.STOPPED
        elif self.schedule is not None and not self.arrived and pose is not None:
            wanted = self._act(now, period, pose, horizon)
        self.command = self._limited(wanted, period)
        return self.command

    def _elapsed(self, now: float) -> float:
        """Time since the last step [s], as far as it can be believed: clocks start anew, and processes stall."""
        elapsed = self.config.period if self._last is None else now - self._last
        self._last = now
        self._stalled = elapsed if elapsed > _STALL and self.command != STANDSTILL else 0.0
        if elapsed < 0.0:
            return self.config.period
        return min(max(elapsed, 0.2 * self.config.period), 4.0 * self.config.period)

    def _drives_path_of(self, schedule: Schedule) -> bool:
        if self.schedule is None:
            return False
        old, new = self.schedule.robot, schedule.robot
        return old.goal_yaw == new.goal_yaw and old.path.points.tolist() == new.path.points.tolist()

    def _begin(self, schedule: Schedule) -> None:
        """Stand before a new path."""
        self._path = ReferencePath(schedule.robot)
        self._stops = itinerary(schedule.robot, self._path)
        self._leg = 0  # index of the stop that was reached last
        self._turning = True  # at that stop
        self._correcting = False
        self._returning = False
        self._realigning = False
        self._reference = self._path.pose(0, 0.0)
        self._reference_speed = 0.0
        self.progress = 0.0
        self.state = ProgressState.IDLE

    def _join(self, governor: Governor) -> None:
        """Begin the new path on the move where the robot drives along its beginning already."""
        if self._pose is None or self.command.speed == 0.0:
            return
        pose = self._pose
        arc_length = self._path.project(pose.x, pose.y, 0.0, min(self._next_stop.arc_length, _WINDOW))
        nearest = self._path.pose(0, arc_length)
        if (_distance(nearest, pose) <= self.config.lateral_limit
                and abs(wrap_angle(nearest.yaw - pose.yaw)) <= _JOIN_ANGLE):
            governor.arc_length, governor.speed = arc_length, self.command.speed
            self._reference, self._reference_speed = nearest, self.command.speed
            self._turning = False

    def _trouble(self, now: float, pose: Optional[Pose], stamp: Optional[float]) -> str:
        """Why the robot must not move, as a sentence; looks at the pose on the way."""
        if self.schedule is None or self.arrived:
            return ""
        if pose is None or not all(map(math.isfinite, pose)):
            return "the pose is not known"
        if stamp is not None and now - stamp > self.config.pose_timeout:
            return f"the pose is {now - stamp:.2f} s old"
        self._observe(pose)
        if self._stalled:
            return f"the last command was {self._stalled:.2f} s ago"
        if self._returning or self.excursion > self.config.lateral_limit:
            trouble = f"the robot is {self.excursion:.2f} m off its way"
        elif self.tracking_error > self.config.deviation_limit:
            trouble = f"the robot is {self.tracking_error:.2f} m off its reference"
        else:
            return ""
        return self._rejoin(pose) if self._returning or self.command == STANDSTILL else trouble

    def _observe(self, pose: Pose) -> None:
        """Measure tracking error and progress."""
        self._pose = pose
        self.tracking_error = _distance(pose, self._reference)
        high = min(self._governor.arc_length + _WINDOW, self._next_stop.arc_length)
        if high > self.progress:
            low = min(max(self.progress, self._governor.arc_length - _WINDOW), high)
            self.progress = max(self.progress, self._path.project(pose.x, pose.y, low, high))
        self.excursion = self._excursion(pose)

    def _excursion(self, pose: Pose) -> float:
        reference = self._governor.arc_length
        low = min(max(self.progress, self._stops[self._leg].arc_length), reference)
        arc_length = self._path.project(pose.x, pose.y, low, reference)
        return _distance(pose, self._path.pose(self._driven_leg, arc_length))

    def _rejoin(self, pose: Pose) -> str:
        """Bring the reference back to a robot that stands near its path, only not where it ought to be; or why not.

        A robot that is too far aside creeps to the reference before it drives on. None rejoins behind what it has
        reported: others rely on its having passed.
        """
        here = self._governor.arc_length
        low = max(self._stops[self._leg].arc_length, here - _REJOIN)
        high = max(min(self._next_stop.arc_length, here + _REJOIN), low)
        arc_length = self._path.project(pose.x, pose.y, low, high)
        nearest = self._path.pose(self._driven_leg, arc_length)
        distance = _distance(nearest, pose)
        behind = self.progress - arc_length
        if distance > 0.5 * self.config.deviation_limit:
            self._returning = False
            return f"the robot is {distance:.2f} m off its path"
        if behind > self.config.release_tolerance:
            self._returning = False
            return f"the robot is {behind:.2f} m behind the progress that others rely on; it needs a new path"
        if not self._returning or distance <= 0.5 * self.config.lateral_limit:
            self._governor.arc_length, self._governor.speed = arc_length, 0.0
            self._reference, self._reference_speed = nearest, 0.0
        self._returning = distance > 0.5 * self.config.lateral_limit
        self.tracking_error, self.excursion = _distance(self._reference, pose), distance
        return ""

    @property
    def _next_stop(self) -> Stop:
        return self._stops[min(self._leg + 1, len(self._stops) - 1)]

    @property
    def _driven_leg(self) -> int:
        """Number of the leg that the reference is on."""
        return min(self._leg, len(self._path.legs) - 1)

    @property
    def _goal(self) -> Pose:
        return self._path.pose(len(self._path.legs) - 1, self._path.length)

    def _act(self, now: float, period: float, pose: Pose, horizon: float) -> Command:
        """The wanted command, before limits."""
        assert self.schedule is not None
        if self._turning and self._leg == 0 and now < self.schedule.times[0]:
            self.state = ProgressState.IDLE
            return STANDSTILL
        if self._returning:
            self.state = ProgressState.DRIVING
            return self._manoeuvres.creep(self._reference, pose, self.command.turn_rate, period)
        if self._correcting:
            return self._correct(pose, period)
        if self._turning:
            target = self._stops[self._leg].heading
            if target is not None and not self._manoeuvres.turned(target, pose, self.command.turn_rate, period):
                self.state = ProgressState.TURNING
                self._reference = self._reference._replace(yaw=target)
                return Command(0.0, self._manoeuvres.turn(target, pose, self.command.turn_rate, period))
            if self._leg == len(self._stops) - 1:
                return self._finish(pose, period)
            self._turning = False
            self._reference = self._path.pose(self._leg, self._governor.arc_length)
        if self._misaligned(pose):
            self._brake(period)
            self.state = ProgressState.TURNING
            return Command(0.0, self._manoeuvres.turn(self._reference.yaw, pose, self.command.turn_rate, period))
        return self._drive(now, period, pose, horizon)

    def _drive(self, now: float, period: float, pose: Pose, horizon: float) -> Command:
        """Follow the reference to the next stop."""
        old, old_speed = self._reference, self._reference_speed
        lag = math.cos(old.yaw) * (old.x - pose.x) + math.sin(old.yaw) * (old.y - pose.y)
        patience = (self.config.lag_end - lag) / (self.config.lag_end - self.config.lag_begin)
        stop = self._next_stop.arc_length
        self._governor.advance(now, period, self._driven_leg, stop=stop, bound=min(self._gate.bound, horizon),
                               patience=min(max(patience, 0.0), 1.0))
        self._move_reference(period)
        self._tell_holding(now)
        if self._reference_speed == 0.0 and old_speed == 0.0 and lag < _STANDING:
            if self._governor.arc_length == stop and self.command.speed <= self._limits.max_acceleration * period:
                self._leg += 1
                self._turning = True
            return STANDSTILL
        turn_rate = wrap_angle(self._reference.yaw - old.yaw) / period
        motion = ReferenceMotion(old.x, old.y, old.yaw, old_speed, self._reference_speed, turn_rate)
        return Command(*track(pose, self.command.speed, motion, period, self.config))

    def _brake(self, period: float) -> None:
        """Let the reference brake along with the robot."""
        if not self._turning:
            self._governor.brake(period, self._next_stop.arc_length)
            self._move_reference(period)

    def _move_reference(self, period: float) -> None:
        """Bring the reference pose to where the governor is, and measure its speed on the rounded path."""
        old = self._reference
        self._reference = self._path.pose(self._driven_leg, self._governor.arc_length)
        self._reference_speed = _distance(self._reference, old) / period

    def _tell_holding(self, now: float) -> None:
        """Tell driving from holding at the gate."""
        governor = self._governor
        held = (governor.speed == 0.0 and governor.arc_length >= self._gate.bound - 1e-3
                and governor.scheduled(now) > governor.arc_length + 1e-3)
        self.state = ProgressState.HOLDING if held else ProgressState.DRIVING
        if held:
            self.waiting_for = self._gate.waiting_for(now)
        else:
            self._gate.moving()

    def _misaligned(self, pose: Pose) -> bool:
        """Whether the robot must turn in place before it can follow, with hysteresis."""
        error = abs(wrap_angle(self._reference.yaw - pose.yaw))
        self._realigning = error > (5.0 * ALIGNED if self._realigning else _MISALIGNED)
        return self._realigning

    def _finish(self, pose: Pose, period: float) -> Command:
        """At the end of the path, turned: arrived, or to be corrected."""
        if _distance(self._goal, pose) <= self.config.position_tolerance:
            self.state = ProgressState.ARRIVED
            self.progress = self._path.length
            return STANDSTILL
        self._correcting = True
        return self._correct(pose, period)

    def _correct(self, pose: Pose, period: float) -> Command:
        """Creep to the goal's position; its heading comes after."""
        goal = self._goal
        self.state = ProgressState.DRIVING
        if _distance(goal, pose) <= 0.5 * self.config.position_tolerance:
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


def _distance(one: Pose, other: Pose) -> float:
    return math.hypot(one.x - other.x, one.y - other.y)
