"""The solver behind PuLP: HiGHS in process where SciPy brings it, CBC elsewhere, or any that the user names."""

import math
from typing import Optional

import numpy as np
import pulp

from social_fleet.errors import InvalidParameter, SolverFailed, TimedOut

try:
    from scipy.optimize import Bounds, LinearConstraint, milp
except ImportError:  # SciPy before 1.9, as on Ubuntu 20.04
    milp = None


class ScipyHighs(pulp.LpSolver):
    """PuLP's programs solved by `scipy.optimize.milp`.

    Parameters
    ----------
    time_limit : float
        Wall time after which the best solution so far is taken [s].
    gap : float
        Relative distance to the bound at which a solution is good enough.
    nodes : int, optional
        Nodes of branch and bound after which the best solution so far is taken.
    """

    name = "SCIPY_HIGHS"

    def __init__(self, time_limit: float, gap: float = 0.0, nodes: Optional[int] = None) -> None:
        super().__init__(mip=True, msg=False)
        self.time_limit = time_limit
        self.gap = gap
        self.nodes = nodes
        self.bound = -math.inf

    def available(self) -> bool:
        """Whether this SciPy has `milp`."""
        return milp is not None

    def actualSolve(self, lp: pulp.LpProblem, **_: object) -> int:  # noqa: N802 - PuLP's name
        """Solve `lp`, store the values in its variables and the proven bound in `bound`."""
        from scipy.sparse import csr_matrix
        variables = lp.variables()
        index = {variable: column for column, variable in enumerate(variables)}
        rows, columns, values, low, high = [], [], [], [], []
        for row, constraint in enumerate(lp.constraints.values()):
            for variable, value in constraint.items():
                rows.append(row)
                columns.append(index[variable])
                values.append(value)
            low.append(-math.inf if constraint.sense < 0 else -constraint.constant)
            high.append(math.inf if constraint.sense > 0 else -constraint.constant)
        costs = np.zeros(len(variables))
        for variable, value in lp.objective.items():
            costs[index[variable]] = value
        bounds = Bounds([-math.inf if variable.lowBound is None else variable.lowBound for variable in variables],
                        [math.inf if variable.upBound is None else variable.upBound for variable in variables])
        matrix = csr_matrix((values, (rows, columns)), shape=(len(low), len(variables)))
        options = {"time_limit": max(self.time_limit, 0.01), "mip_rel_gap": self.gap}
        if self.nodes is not None:
            options["node_limit"] = self.nodes
        result = milp(costs, constraints=LinearConstraint(matrix, low, high) if low else None, bounds=bounds,
                      integrality=[variable.cat == pulp.LpInteger for variable in variables], options=options)
        return self._store(lp, variables, result)

    def _store(self, lp: pulp.LpProblem, variables: list, result: object) -> int:
        bound = getattr(result, "mip_dual_bound", None)
        solved = getattr(result, "x", None) is not None
        if solved:
            lp.assignVarsVals({variable.name: value for variable, value in zip(variables, result.x)})  # type: ignore
            self.bound = lp.objective.constant + (result.fun if bound is None else bound)  # type: ignore
        codes = {0: pulp.LpStatusOptimal, 1: pulp.LpStatusNotSolved, 2: pulp.LpStatusInfeasible}
        status = codes.get(result.status, pulp.LpStatusUndefined)  # type: ignore
        if status == pulp.LpStatusNotSolved and solved:
            status = pulp.LpStatusOptimal
        lp.assignStatus(status)
        return status


def solve(program: pulp.LpProblem, *, solver: Optional[str], time_limit: float, gap: float = 0.0,
          nodes: Optional[int] = None) -> Optional[float]:
    """Solve `program` in place.

    Parameters
    ----------
    solver : str, optional
        ``highs``, ``cbc``, or any name that ``pulp.listSolvers()`` knows; by default HiGHS where there, else CBC.
    time_limit : float
        [s]
    gap : float
        Relative distance to the bound at which a solution is good enough; HiGHS in process only.
    nodes : int, optional
        Nodes of branch and bound after which the best solution so far will do; HiGHS in process only.

    Returns
    -------
    float or None
        The proven lower bound of the objective, minus infinity where a solver that was stopped tells none; None when
        the program is infeasible.

    Raises
    ------
    TimedOut
        When a limit passed without any solution.
    SolverFailed, InvalidParameter
        When the solver broke down, or is not there.
    """
    engine = find_solver(solver, time_limit)
    if isinstance(engine, ScipyHighs):
        engine.gap, engine.nodes = gap, nodes
    status = program.solve(engine)
    if status == pulp.LpStatusInfeasible:
        return None
    if status == pulp.LpStatusNotSolved:
        raise TimedOut(f"{engine.name} found no schedule within {time_limit:.1f} s; allow more time "
                       "or send fewer robots at once")
    if status != pulp.LpStatusOptimal:
        raise SolverFailed(f"{engine.name} ended with status '{pulp.LpStatus[status]}'")
    if isinstance(engine, ScipyHighs):
        return engine.bound
    proven = program.sol_status == pulp.LpSolutionOptimal
    return pulp.value(program.objective) if proven else -math.inf


def find_solver(solver: Optional[str], time_limit: float) -> pulp.LpSolver:
    """The solver of that name, see `solve`, or the best that is there; InvalidParameter when it is not."""
    if solver in (None, "highs") and milp is not None:
        return ScipyHighs(time_limit)
    if solver in (None, "cbc"):
        for name, options in (("COIN_CMD", {"path": "cbc"}), ("PULP_CBC_CMD", {})):
            engine = pulp.getSolver(name, msg=False, timeLimit=max(time_limit, 0.01), gapRel=0.0, **options)
            if engine.available():
                return engine
        raise InvalidParameter("CBC is not installed (Debian: coinor-cbc)", field="solver")
    if solver == "highs":
        raise InvalidParameter("this SciPy has no HiGHS (1.9 or later does); use 'cbc'", field="solver")
    if solver not in pulp.listSolvers(onlyAvailable=True):
        raise InvalidParameter(f"'{solver}' is not there; PuLP offers "
                               f"{', '.join(pulp.listSolvers(onlyAvailable=True))}", field="solver")
    return pulp.getSolver(solver, msg=False, timeLimit=max(time_limit, 0.01))
