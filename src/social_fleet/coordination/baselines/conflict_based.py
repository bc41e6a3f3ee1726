"""Conflict-based search in continuous time: each robot's best motion, and a search over the rules that part them."""

from dataclasses import dataclass
from typing import List, Sequence, Tuple

from social_fleet.coordination.baselines.conflict_tree import EQUAL, ConflictTree, Node
from social_fleet.coordination.baselines.deadline import Deadline
from social_fleet.coordination.baselines.fleet_planner import FleetPlanner, Ground
from social_fleet.coordination.baselines.frontier import Frontier
from social_fleet.coordination.baselines.traffic import Trajectory
from social_fleet.errors import Infeasible, InvalidParameter


@dataclass(frozen=True)
class _Open:
    """A node of the frontier; with its children once they are known."""

    node: Node
    bound: float
    children: Sequence[Node] = ()


class ConflictBasedSearch(FleetPlanner):
    """Least sum of arrival times on the roadmap, to within the margins that rounding asks for.

    Nodes come in the order of their lower bound, which counts in what the conflicts of disjoint pairs will cost at
    least. It need not end where no schedule exists, but for its time limit.

    Parameters
    ----------
    coarsening : int
        Cells along the edge of a roadmap's block.
    suboptimality : float
        From 1 on: the result is at most so many times the least; above 1, nodes with fewer conflicts come first among
        those that promise that.

    References
    ----------
    G. Sharon et al., "Conflict-based search for optimal multi-agent pathfinding", Artificial Intelligence 219, 2015.
    A. Andreychuk et al., "Multi-agent pathfinding with continuous time", Artificial Intelligence 305, 2022.
    J. Li et al., "Improved heuristics for multi-agent path finding with conflict-based search", IJCAI 2019.
    """

    name = "conflict-based search"

    def __init__(self, *, coarsening: int = 4, suboptimality: float = 1.0) -> None:
        super().__init__(coarsening=coarsening)
        if not 1.0 <= suboptimality < float("inf"):
            raise InvalidParameter(f"must be a number from 1 on, not {suboptimality!r}", field="suboptimality")
        self.suboptimality = suboptimality

    def _solve(self, ground: Ground, deadline: Deadline) -> Tuple[List[Trajectory], float]:
        tree = ConflictTree(ground, deadline)
        frontier: Frontier[_Open] = Frontier(self.suboptimality, EQUAL)
        for root in tree.root():
            frontier.push(_Open(root, root.cost), root.cost, len(root.conflicts))
        while frontier:
            bound = frontier.bound
            entry = frontier.pop()
            node = entry.node
            if not node.conflicts:
                return list(node.motions), max(node.cost - bound, 0.0) / node.cost if node.cost > 0.0 else 0.0
            children = entry.children
            if not children:
                children, least = tree.children(node)
                deadline.check(f"{self.name} of {len(ground.robots)} robots")
                if children and least > entry.bound + EQUAL:
                    frontier.push(_Open(node, least, children), least, len(node.conflicts))
                    continue
            for child in children:
                least = max(child.cost, entry.bound)
                frontier.push(_Open(child, least), least, len(child.conflicts))
        deadline.check(f"{self.name} of {len(ground.robots)} robots")
        raise Infeasible(f"{self.name}: there is no schedule for these robots on blocks of {self.coarsening} cells",
                         robots=[robot.name for robot in ground.robots])
