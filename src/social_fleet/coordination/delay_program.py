"""The program's master: which side goes first in each contested window, with the times projected out.

Its variables are a binary per window and the delay of every robot beyond what is unavoidable. What it knows of times
are cuts, each read off the longest paths of `order_state`: *these orders together delay that robot by so much*, or
*these orders cannot all be*. So every optimum of it, and every bound a solver proves for it, is a lower bound of the
full program (logic-based Benders decomposition; Hooker and Ottosson, doi:10.1007/s10107-003-0375-9).
"""

from typing import Dict, FrozenSet, List, Mapping, NamedTuple, Optional

import numpy as np
import pulp

from social_fleet.coordination.order_state import Choice
from social_fleet.coordination.solvers import solve


class Proposal(NamedTuple):
    """What the master proposes: a bound on the objective [s], the sides by window, and the delays (R,) [s]."""

    bound: float
    sides: Dict[int, int]
    delays: np.ndarray


class DelayProgram:
    """Least objective over the orders, as far as the cuts tell.

    Parameters
    ----------
    arrivals : (R,) array
        Arrivals that no order makes earlier [s].
    weights : (R,) array
        What a second of delay costs for each robot.
    longest : bool
        Whether the latest arrival counts, rather than the weighted sum.
    """

    def __init__(self, arrivals: np.ndarray, weights: np.ndarray, longest: bool) -> None:
        self.problem = pulp.LpProblem("delays", pulp.LpMinimize)
        self._delays = [pulp.LpVariable(f"d_{robot:04d}", 0.0) for robot in range(len(arrivals))]
        self._second: Dict[int, pulp.LpVariable] = {}
        if longest:
            latest = pulp.LpVariable("makespan", 0.0)
            self.problem.setObjective(pulp.LpAffineExpression(latest))
            for robot in np.flatnonzero(weights > 0.0):
                self.problem += latest - self._delays[robot] >= float(arrivals[robot])
        else:
            self.problem.setObjective(pulp.LpAffineExpression(
                [(delay, float(weight)) for delay, weight in zip(self._delays, weights)],
                constant=float(weights @ arrivals)))

    @property
    def windows(self) -> List[int]:
        """The windows that some cut speaks of."""
        return list(self._second)

    def add_delay(self, robot: int, delay: float, shares: Mapping[Choice, float]) -> None:
        """A cut: all the orders together delay a robot by `delay` [s]; without one, by its share less."""
        terms = [self._absent(choice) * share for choice, share in shares.items()]
        self.problem += self._delays[robot] + pulp.lpSum(terms) >= delay

    def exclude(self, choices: FrozenSet[Choice]) -> None:
        """A cut: not all of these orders."""
        self.problem += pulp.lpSum(self._absent(choice) for choice in sorted(choices)) >= 1

    def solve(self, *, solver: Optional[str], time_limit: float, gap: float,
              nodes: Optional[int]) -> Optional[Proposal]:
        """Solve to within `gap`, or over `nodes`; None when the cuts leave no orders."""
        if not self.problem.constraints:
            return Proposal(float(self.problem.objective.constant), {}, np.zeros(len(self._delays)))
        bound = solve(self.problem, solver=solver, time_limit=time_limit, gap=gap, nodes=nodes)
        if bound is None:
            return None
        sides = {window: int(round(variable.value() or 0.0)) for window, variable in self._second.items()}
        return Proposal(bound, sides, np.array([variable.value() or 0.0 for variable in self._delays]))

    def _absent(self, choice: Choice) -> pulp.LpAffineExpression:
        """1 where an order is not chosen, else 0."""
        window, side = choice
        if window not in self._second:
            self._second[window] = pulp.LpVariable(f"z_{window:05d}", cat=pulp.LpBinary)
        second = self._second[window]
        return pulp.LpAffineExpression(second) if side == 0 else 1 - second
