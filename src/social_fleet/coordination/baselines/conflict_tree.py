"""The nodes of conflict-based search: sets of rules, the best motions that keep them, and how nodes come from nodes."""

import itertools
import math
from dataclasses import dataclass
from typing import Dict, FrozenSet, List, Optional, Sequence, Set, Tuple

import numpy as np

from social_fleet.coordination.baselines.conflicts import (
    Conflict, EdgeRule, LateRule, NodeRule, ParkedRule, Rule, first_conflict, split)
from social_fleet.coordination.baselines.deadline import Deadline
from social_fleet.coordination.baselines.fleet_planner import Ground
from social_fleet.coordination.baselines.sipp import Rules
from social_fleet.coordination.baselines.traffic import WAIT, Traffic, Trajectory, owned

EQUAL = 1e-5
"""Costs that differ by less are equal [s]."""

_WEIGHED = 24  # conflicts of a node, the earliest, of which it branches on the dearest
_TRIED = 8  # conflicts whose children are looked at where none is cardinal
_AFTER = 1e-6  # how much after a time an arrival counts as later [s]


@dataclass(frozen=True)
class Node:
    """Rules, a best motion for each robot that keeps them, where these touch, and their sum of arrivals [s]."""

    rules: FrozenSet[Rule]
    motions: Tuple[Trajectory, ...]
    conflicts: Tuple[Conflict, ...]
    cost: float


@dataclass(frozen=True)
class _Choice:
    """A conflict's two rules, and by how much each makes the two robots' arrivals later at least [s]."""

    conflict: Conflict
    rules: Tuple[Rule, Rule]
    rises: Tuple[float, float]

    @property
    def least(self) -> float:
        return min(self.rises)

    @property
    def worth(self) -> Tuple[float, float]:
        """To branch on the dearest is best: both ways first, then either."""
        return min(self.rises), max(self.rises)


class ConflictTree:
    """The tree of one fleet.

    Parameters
    ----------
    ground : Ground
    deadline : Deadline
        Searches end empty-handed when it has passed.
    """

    def __init__(self, ground: Ground, deadline: Deadline) -> None:
        self.ground = ground
        self.deadline = deadline
        self._arrivals: Dict[Tuple[int, FrozenSet[Rule]], float] = {}

    def root(self) -> List[Node]:
        """The node without rules, if every robot has a motion; each keeps clear of those before where that is free."""
        motions: List[Trajectory] = []
        for robot in range(len(self.ground.travellers)):
            motion = self._search(robot, frozenset(), self._traffic(motions, frozenset()))
            if motion is None:
                return []
            motions.append(motion)
        return [_node(frozenset(), motions, (), set(range(len(motions))))]

    def children(self, node: Node) -> Tuple[List[Node], float]:
        """The nodes that take the place of one with conflicts, and a lower bound for all of them [s].

        A node branches on a conflict that is cardinal, dearer both ways, if there is one. Else it may have a child
        that costs nothing and has fewer conflicts, which then takes its place with no more rules than before.
        """
        traffic = self._traffic(node.motions, node.rules)
        first = sorted(node.conflicts, key=lambda conflict: conflict.time)[:_WEIGHED]
        choices = sorted((self._choice(node, conflict, traffic) for conflict in first),
                         key=lambda choice: choice.worth, reverse=True)
        if self.deadline.stop[0]:
            return [], node.cost
        if choices[0].least > EQUAL:
            return self._branches(node, choices[0], traffic), node.cost + _disjoint(choices)
        best: List[Node] = []
        for choice in choices[:_TRIED]:
            children = self._branches(node, choice, traffic)
            for child in children:
                if child.cost < node.cost + EQUAL and len(child.conflicts) < len(node.conflicts):
                    return [Node(node.rules, child.motions, child.conflicts, node.cost)], node.cost
            best = best or children
        return best, node.cost

    def _choice(self, node: Node, conflict: Conflict, traffic: Traffic) -> _Choice:
        rules = split(conflict, node.motions)
        rises = [self._rise(node, conflict, rule, traffic) for rule in rules]
        return _Choice(conflict, rules, (rises[0], rises[1]))

    def _rise(self, node: Node, conflict: Conflict, rule: Rule, traffic: Traffic) -> float:
        """How much later a rule makes the one of the two robots that has to give way [s]."""
        robot = rule.robot
        if isinstance(rule, ParkedRule):
            robot = conflict.s if rule.robot == conflict.r else conflict.r
        rules = _concerning(robot, node.rules | {rule})
        if (robot, rules) not in self._arrivals:
            if isinstance(rule, ParkedRule):
                traffic = self._traffic(node.motions, node.rules | {rule})
            motion = self._search(robot, rules, traffic)
            self._arrivals[robot, rules] = math.inf if motion is None else motion.arrival
        return max(self._arrivals[robot, rules] - node.motions[robot].arrival, 0.0)

    def _branches(self, node: Node, choice: _Choice, traffic: Traffic) -> List[Node]:
        children = [self._child(node, rule, traffic) for rule, rise in zip(choice.rules, choice.rises)
                    if rise < math.inf]
        return [child for child in children if child is not None]

    def _child(self, node: Node, rule: Rule, traffic: Traffic) -> Optional[Node]:
        """The node with one more rule; None where some robot has no motion left."""
        rules = node.rules | {rule}
        motions = list(node.motions)
        if isinstance(rule, ParkedRule):
            traffic = self._traffic(motions, rules)
        changed = self._broken_by(rule, motions)
        for robot in changed:
            motion = self._search(robot, rules, traffic)
            if motion is None:
                return None
            motions[robot] = motion
        return _node(rules, motions, node.conflicts, changed)

    def _broken_by(self, rule: Rule, motions: Sequence[Trajectory]) -> Set[int]:
        """The robots whose motions do not keep a new rule."""
        if not isinstance(rule, ParkedRule):
            return {rule.robot}
        parked = self._parked(rule)
        broken = {robot for robot, motion in enumerate(motions)
                  if robot != rule.robot and first_conflict(0, 1, (motion, parked))}
        return broken | ({rule.robot} if motions[rule.robot].arrival > rule.time else set())

    def _search(self, robot: int, rules: FrozenSet[Rule], traffic: Traffic) -> Optional[Trajectory]:
        return self.ground.travellers[robot].search(traffic, self.deadline.stop, _as_arrays(robot, rules))

    def _parked(self, rule: ParkedRule) -> Trajectory:
        """A robot that stands at its goal from a time on, as a motion."""
        traveller = self.ground.travellers[rule.robot]
        graph = traveller.roadmap.graph
        piece = [rule.time, np.inf, graph.x[traveller.goal], graph.y[traveller.goal], 0.0, 0.0, traveller.goal, WAIT]
        return Trajectory(np.array([piece]), traveller.roadmap.radius)

    def _traffic(self, motions: Sequence[Trajectory], rules: FrozenSet[Rule]) -> Traffic:
        """All motions, to be counted, and the parked robots of the rules, to be kept clear of."""
        pieces = [owned(motion, robot, hard=False) for robot, motion in enumerate(motions)]
        pieces += [owned(self._parked(rule), rule.robot, hard=True) for rule in rules if isinstance(rule, ParkedRule)]
        return self.ground.traffic(pieces)


def _node(rules: FrozenSet[Rule], motions: Sequence[Trajectory], conflicts: Sequence[Conflict],
          changed: Set[int]) -> Node:
    """A node, given the conflicts before some motions changed."""
    motions = tuple(motions)
    kept = [conflict for conflict in conflicts if not {conflict.r, conflict.s} & changed]
    found = [conflict for r, s in itertools.combinations(range(len(motions)), 2) if r in changed or s in changed
             for conflict in first_conflict(r, s, motions)]
    return Node(rules, motions, tuple(kept + found), sum(motion.arrival for motion in motions))


def _disjoint(choices: Sequence[_Choice]) -> float:
    """What conflicts of pairs that share no robot cost together at least [s]; `choices` have the dearest first."""
    total = 0.0
    taken: Set[int] = set()
    for choice in choices:
        pair = {choice.conflict.r, choice.conflict.s}
        if not pair & taken:
            total += choice.least
            taken |= pair
    return total


def _concerning(robot: int, rules: FrozenSet[Rule]) -> FrozenSet[Rule]:
    """The rules that one robot's motion has to keep."""
    return frozenset(rule for rule in rules if rule.robot == robot or isinstance(rule, ParkedRule))


def _as_arrays(robot: int, rules: FrozenSet[Rule]) -> Rules:
    """One robot's rules as the search takes them."""
    own = [rule for rule in rules if rule.robot == robot]
    edges = sorted((float(rule.edge), rule.begin, rule.end) for rule in own if isinstance(rule, EdgeRule))
    nodes = sorted((float(rule.node), rule.begin, rule.end) for rule in own if isinstance(rule, NodeRule))
    late = max((rule.time + _AFTER for rule in own if isinstance(rule, LateRule)), default=-math.inf)
    by = min((rule.time for rule in own if isinstance(rule, ParkedRule)), default=math.inf)
    return Rules(np.array(edges).reshape(-1, 3), np.array(nodes).reshape(-1, 3), np.array([late, by]))
