"""Who searches which pairs of robots for encounter windows, so that the fleet shares the work (3.4.2).

R robots that plan at once have R (R - 1) / 2 pairs. Think of them in a circle, in the order of their names. Each
searches its pairs with the n robots that follow it, n = (R - 1) / 2 rounded down (Fig. 4). For odd R this is every
pair once: two robots are at most n steps apart one way round, and more than n the other way. For even R the R / 2
pairs of robots that face each other are left; each goes to the one in the first half of the circle. So half of the
robots search n + 1 pairs, the others n, and no two loads differ by more than one.

A robot whose schedule is under way searches its pairs with each robot that plans: the sequential protocol has one that
plans, the unified one several, which share the pairs among themselves as above. Two robots under way are no pair.

All of this follows from the names alone, so every robot works it out for itself, and nobody hands out work.
"""

from typing import Dict, List, Sequence, Tuple

from social_fleet.coordination.request import check_names
from social_fleet.errors import InvalidParameter

Pair = Tuple[str, str]
"""Two names in the coordinator's order: those that plan by name, before those under way."""


def circular_partners(count: int) -> List[List[int]]:
    """For each of `count` robots in a circle, the positions of those with which it searches its pairs.

    Parameters
    ----------
    count : int
        R, not negative.

    Returns
    -------
    list of list of int
        Every pair of positions occurs once; lengths differ by at most one.

    Raises
    ------
    InvalidParameter
        When `count` is negative.
    """
    if count < 0:
        raise InvalidParameter(f"must be zero or more, not {count}", field="count")
    partners = [[(robot + step) % count for step in range(1, (count - 1) // 2 + 1)] for robot in range(count)]
    if count % 2 == 0:
        for robot in range(count // 2):
            partners[robot].append(robot + count // 2)
    return partners


def share_pairs(planning: Sequence[str], fixed: Sequence[str] = ()) -> Dict[str, Tuple[Pair, ...]]:
    """The pairs that each robot searches.

    Parameters
    ----------
    planning : sequence of str
        Names of the robots to schedule, in any order.
    fixed : sequence of str
        Names of those whose schedules are under way, in any order.

    Returns
    -------
    dict of str to tuple of (str, str)
        For every name, in order; each pair of which at least one plans occurs once.

    Raises
    ------
    InvalidScenario
        When a name comes twice: the robots could not tell whose pairs are whose.
    """
    check_names([*planning, *fixed])
    circle = sorted(planning)
    shares = {}
    for place, partners in enumerate(circular_partners(len(circle))):
        pairs = [tuple(sorted((place, partner))) for partner in partners]
        shares[circle[place]] = tuple((circle[r], circle[s]) for r, s in pairs)
    for name in sorted(fixed):
        shares[name] = tuple((planned, name) for planned in circle)
    return shares
