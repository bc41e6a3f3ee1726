"""Whom to plan anew, and with whom: the late one alone, those affected with it, or all (5.4)."""

from dataclasses import dataclass, field
from typing import Dict, FrozenSet, Mapping, Optional, Sequence, Set, Tuple

from social_fleet.coordination.schedule import Schedule

SEQUENTIAL, UNIFIED, SIMULTANEOUS = "sequential", "unified", "simultaneous"


@dataclass(frozen=True)
class Need:
    """A replan.

    Attributes
    ----------
    mode : str
        ``sequential``: one robot is fitted in anew between the others, who keep their order; ``unified``: several are;
        ``simultaneous``: nobody keeps an order that is not begun.
    robots : frozenset of str
        Those that are fitted in anew.
    new_paths : frozenset of str
        Those among them whose paths do not do any longer.
    reason : str
        Why, as a sentence.
    """

    mode: str
    robots: FrozenSet[str]
    new_paths: FrozenSet[str] = field(default_factory=frozenset)
    reason: str = ""


def replan_for_paths(causes: Mapping[str, str], fleet: Sequence[str]) -> Optional[Need]:
    """The replan for robots that need other paths, by name with the reason; None when there are none."""
    if not causes:
        return None
    mode = SEQUENTIAL if len(causes) == 1 else SIMULTANEOUS if len(causes) == len(fleet) else UNIFIED
    names = sorted(causes)
    return Need(mode, frozenset(names), frozenset(names), "; ".join(f"{name} {causes[name]}" for name in names))


def replan_for_delays(delays: Mapping[str, float], late: Sequence[str], schedules: Mapping[str, Schedule],
                      progress: Mapping[str, float]) -> Optional[Need]:
    """The replan for robots that are late; None when nobody waits for them.

    Parameters
    ----------
    delays : mapping of str to float
        Of all robots [s].
    late : sequence of str
        Robots that count as late through no fault of others.
    schedules, progress : mappings
        Of all robots: what they follow, and how far they have come on it [m].
    """
    waiting = affected_by(late, schedules, progress)
    if not late or not waiting:
        return None
    worst = max(late, key=lambda name: delays[name])
    reason = f"{worst} is {delays[worst]:.0f} s late, {', '.join(sorted(waiting))} would wait"
    delayed = {name for name in waiting if delays[name] > 0.5 * delays[worst]}
    if 2 * len(set(late) | delayed) > len(schedules):
        return Need(SIMULTANEOUS, frozenset(schedules), reason=reason)
    if delayed or len(late) > 1:
        return Need(UNIFIED, frozenset(late) | waiting, reason=reason)
    return Need(SEQUENTIAL, frozenset(late), reason=reason)


def affected_by(robots: Sequence[str], schedules: Mapping[str, Schedule],
                progress: Mapping[str, float]) -> Set[str]:
    """Those that still have to wait for any of `robots`, or for one that does; without `robots`."""
    followers: Dict[str, Set[str]] = {}
    for name, schedule in schedules.items():
        for rule in schedule.precedences:
            leader = schedules.get(rule.other)
            if (leader is not None and leader.version == rule.other_version
                    and progress[rule.other] < rule.other_at and progress[name] <= rule.at):
                followers.setdefault(rule.other, set()).add(name)
    found: Set[str] = set()
    queue: Tuple[str, ...] = tuple(robots)
    while queue:
        new = set().union(*(followers.get(name, set()) for name in queue)) - found - set(robots)
        found |= new
        queue = tuple(new)
    return found
