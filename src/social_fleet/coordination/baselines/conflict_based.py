"""Conflict-based search in continuous time: each robot's best motion, and a search over the rules that part them."""

import heapq
import itertools
from dataclasses import dataclass
from typing import List, Optional, Sequence, Set, Tuple

import numpy as np

from social_fleet.coordination.baselines.conflicts import (
    Conflict, EdgeRule, LateRule, NodeRule, ParkedRule, Rule, first_conflict, split)
from social_fleet.coordination.baselines.deadline import Deadline
from social_fleet.coordination.baselines.fleet_planner import FleetPlanner, Ground
from social_fleet.coordination.baselines.sipp import Rules
from social_fleet.coordination.baselines.traffic import BEGIN, HARD, WAIT, EDGE, Traffic, Trajectory, owned
from social_fleet.errors import Infeasible

_EQUAL = 1e-5  # costs that differ by less are equal [s]
_LOOKED_AT = 8  # conflicts of a node, of which it branches on the best
_AFTER = 1e-6  # how much after a time an arrival counts as later [s]


@dataclass(frozen=True)
class _Node:
    """A node of the tree: rules, the best motions that keep them, and where these touch."""

    rules: Tuple[Rule, ...]
    motions: Tuple[Trajectory, ...]
    conflicts: Tuple[Conflict, ...]
    cost: float


class ConflictBasedSearch(FleetPlanner):
    """Least sum of arrival times on the roadmap, to within the margins that rounding asks for.

    Nodes are searched in the order of their cost. A node branches where both ways are dearer (a cardinal conflict)
    sooner than where one or none is; and where one way costs nothing and has fewer conflicts, it takes that without
    branching (bypass). It need not end where no schedule exists, but for its time limit.

    References
    ----------
    G. Sharon et al., "Conflict-based search for optimal multi-agent pathfinding", Artificial Intelligence 219, 2015.
    A. Andreychuk et al., "Multi-agent pathfinding with continuous time", Artificial Intelligence 305, 2022.
    E. Boyarski et al., "ICBS: Improved conflict-based search algorithm for multi-agent pathfinding", IJCAI 2015.
    """

    name = "conflict-based search"

    def _solve(self, ground: Ground, deadline: Deadline) -> Tuple[List[Trajectory], float]:
        tree = _Tree(ground, deadline)
        serial = itertools.count()
        queue = [(node.cost, len(node.conflicts), next(serial), node) for node in tree.root()]
        while queue:
            deadline.check(f"{self.name} of {len(ground.robots)} robots")
            node = heapq.heappop(queue)[-1]
            if not node.conflicts:
                return list(node.motions), 0.0
            for child in tree.children(node):
                heapq.heappush(queue, (child.cost, len(child.conflicts), next(serial), child))
        deadline.check(f"{self.name} of {len(ground.robots)} robots")
        raise Infeasible(f"{self.name}: there is no schedule for these robots on blocks of {self.coarsening} cells",
                         robots=[robot.name for robot in ground.robots])


class _Tree:
    """How nodes come from nodes."""

    def __init__(self, ground: Ground, deadline: Deadline) -> None:
        self.ground = ground
        self.deadline = deadline

    def root(self) -> List[_Node]:
        """Every robot's best motion, each avoiding those before it where that costs nothing."""
        motions: List[Trajectory] = []
        for traveller in self.ground.travellers:
            motion = traveller.search(self._traffic(motions, ()), self.deadline.stop)
            if motion is None:
                return []
            motions.append(motion)
        robots = range(len(motions))
        conflicts = [conflict for r, s in itertools.combinations(robots, 2)
                     for conflict in first_conflict(r, s, tuple(motions))]
        return [_Node((), tuple(motions), tuple(conflicts), sum(motion.arrival for motion in motions))]

    def children(self, node: _Node) -> List[_Node]:
        """The nodes that take the place of one with conflicts."""
        best: List[_Node] = []
        most = (-1.0, -1.0)
        parked = [rule for rule in node.rules if isinstance(rule, ParkedRule)]
        traffic = self._traffic(node.motions, parked)
        for conflict in sorted(node.conflicts, key=lambda conflict: conflict.time)[:_LOOKED_AT]:
            found = [self._child(node, rule, traffic) for rule in split(conflict, node.motions)]
            children = [child for child in found if child is not None]
            if self.deadline.stop[0] or len(children) < 2:
                return children
            for child in children:
                if child.cost < node.cost + _EQUAL and len(child.conflicts) < len(node.conflicts):
                    return [_Node(node.rules, child.motions, child.conflicts, node.cost)]
            rises = sorted(child.cost - node.cost for child in children)
            if rises[0] > _EQUAL:
                return children
            if (rises[0], rises[1]) > most:
                best, most = children, (rises[0], rises[1])
        return best

    def _child(self, node: _Node, rule: Rule, traffic: Traffic) -> Optional[_Node]:
        """The node with one more rule; None where some robot has no motion left."""
        rules = node.rules + (rule,)
        motions = list(node.motions)
        if isinstance(rule, ParkedRule):
            parked = [other for other in rules if isinstance(other, ParkedRule)]
            traffic = self._traffic(motions, parked)
        changed = self._broken_by(rule, motions)
        for robot in changed:
            motion = self.ground.travellers[robot].search(traffic, self.deadline.stop, _rules_of(robot, rules))
            if motion is None:
                return None
            motions[robot] = motion
        conflicts = [conflict for conflict in node.conflicts if not {conflict.r, conflict.s} & changed]
        for r, s in itertools.combinations(range(len(motions)), 2):
            if r in changed or s in changed:
                conflicts += first_conflict(r, s, tuple(motions))
        return _Node(rules, tuple(motions), tuple(conflicts), sum(motion.arrival for motion in motions))

    def _broken_by(self, rule: Rule, motions: Sequence[Trajectory]) -> Set[int]:
        """The robots whose motions do not keep a new rule."""
        if not isinstance(rule, ParkedRule):
            return {rule.robot}  # type: ignore[attr-defined]
        pair = (self._parked(rule), ) 
        others = {robot for robot in range(len(motions)) if robot != rule.robot and first_conflict(
            0, 1, (motions[robot], pair[0]))}
        return others | ({rule.robot} if motions[rule.robot].arrival > rule.time else set())

    def _parked(self, rule: ParkedRule) -> Trajectory:
        """A robot that stands at its goal from a time on, as a motion."""
        traveller = self.ground.travellers[rule.robot]
        graph = traveller.roadmap.graph
        piece = [rule.time, np.inf, graph.x[traveller.goal], graph.y[traveller.goal], 0.0, 0.0, traveller.goal, WAIT]
        return Trajectory(np.array([piece]), traveller.roadmap.radius)

    def _traffic(self, motions: Sequence[Trajectory], parked: Sequence[ParkedRule]) -> Traffic:
        """All motions to be counted, and parked robots to be kept clear of."""
        pieces = [owned(motion, robot, hard=False) for robot, motion in enumerate(motions)]
        pieces += [owned(self._parked(rule), rule.robot, hard=True) for rule in parked]
        return self.ground.traffic(pieces)


def _rules_of(robot: int, rules: Sequence[Rule]) -> Rules:
    """One robot's rules as the search takes them."""
    edges = sorted((float(rule.edge), rule.begin, rule.end) for rule in rules
                   if isinstance(rule, EdgeRule) and rule.robot == robot)
    nodes = sorted((float(rule.node), rule.begin, rule.end) for rule in rules
                   if isinstance(rule, NodeRule) and rule.robot == robot)
    late = [rule.time + _AFTER for rule in rules if isinstance(rule, LateRule) and rule.robot == robot]
    by = [rule.time for rule in rules if isinstance(rule, ParkedRule) and rule.robot == robot]
    return Rules(np.array(edges).reshape(-1, 3), np.array(nodes).reshape(-1, 3),
                 np.array([max(late, default=-np.inf), min(by, default=np.inf)]))
