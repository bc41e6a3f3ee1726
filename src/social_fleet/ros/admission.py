"""What the coordinator makes sure of before schedules come into force: pure functions."""

import time
from typing import Callable, Iterable, Optional, Sequence

import genpy

from social_fleet.coordination.schedule import Schedule
from social_fleet.coordination.verification import verify
from social_fleet.errors import InvalidScenario, SolverFailed
from social_fleet.msg import Progress, Schedule as ScheduleMessage


def stands_for_good(news: Progress) -> bool:
    """Whether a robot will not move until it gets another schedule: it has arrived, or never had one."""
    return news.state == Progress.ARRIVED or (news.state == Progress.IDLE and news.schedule_version == 0)


def check_all_considered(progress: Iterable[Progress], names: Iterable[str],
                         held: Callable[[str], Optional[ScheduleMessage]] = lambda name: None) -> None:
    """Raise InvalidScenario when a robot that may move by its schedule is none of `names`.

    One that has not taken up what is in force for it, by `held`, may do so at any moment.
    """
    known = set(names)
    left_out = sorted(news.robot for news in progress if news.robot not in known and (
        not stands_for_good(news) or _is_behind(news, held(news.robot))))
    if left_out:
        raise InvalidScenario(f"{', '.join(left_out)} may move by an earlier schedule and is left out; give its "
                              "schedule in `fixed`, or plan it anew", field="fixed")


def _is_behind(news: Progress, schedule: Optional[ScheduleMessage]) -> bool:
    return schedule is not None and news.schedule_version < schedule.version


def check_in_force(given: Iterable[ScheduleMessage], held: Callable[[str], Optional[ScheduleMessage]],
                   now: genpy.Time) -> None:
    """Raise InvalidScenario when a robot drives by another schedule than the one given for it."""
    for message in given:
        own = held(message.robot)
        if own is None or own.version == message.version:
            continue
        if (own.header.stamp - now).to_sec() + own.times[-1] > 0.0:
            raise InvalidScenario(f"{message.robot} drives by schedule {own.version}, not by {message.version}; give "
                                  "the one that is in force", field="fixed")


def check_clear(planned: Sequence[Schedule], fixed: Sequence[Schedule]) -> None:
    """Raise SolverFailed when a planned schedule touches any other; all are on one clock.

    Fixed schedules among themselves are no business of the request's.
    """
    names = {schedule.name for schedule in planned}
    for r, s, clearance, when in verify([*planned, *fixed]).pairs:
        if clearance < 0.0 and names & {r, s}:
            raise SolverFailed(f"the schedules of {r} and {s} overlap by {-clearance:.3f} m at {when:.1f} s; "
                               "none was put in force")


def next_version(seen: Iterable[int]) -> int:
    """A version above all `seen`, and above those of any coordinator that ran before.

    Seconds since the epoch, of wall time: a coordinator that starts anew has forgotten what it gave before.
    """
    return max([int(time.time()), *(version + 1 for version in seen)])
