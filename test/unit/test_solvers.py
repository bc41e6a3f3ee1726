"""Solvers behind PuLP: right answers, honest bounds, limits that are kept, and unknown names."""

import time
from typing import Optional

import numpy as np
import pulp
import pytest

from social_fleet.coordination import solvers
from social_fleet.coordination.solvers import solve
from social_fleet.errors import InvalidParameter, TimedOut

SOLVERS = [pytest.param("highs", marks=pytest.mark.skipif(solvers.milp is None, reason="SciPy without HiGHS")),
           pytest.param("cbc", marks=pytest.mark.skipif(
               not (pulp.COIN_CMD(path="cbc").available() or pulp.PULP_CBC_CMD().available()),
               reason="CBC is not installed"))]


def knapsack(items: int, rows: int, seed: int) -> pulp.LpProblem:
    """Leave out as little value as possible; hard to prove for many items."""
    rng = np.random.RandomState(seed)
    weights = rng.randint(100, 1000, (rows, items))
    out = [pulp.LpVariable(f"x_{item:03d}", cat=pulp.LpBinary) for item in range(items)]
    problem = pulp.LpProblem("knapsack", pulp.LpMinimize)
    problem.setObjective(pulp.lpSum(int(value) * item for value, item in zip(weights.sum(axis=0) + 500, out)))
    for row in weights:
        problem += pulp.lpSum(int(weight) * item for weight, item in zip(row, out)) >= int(row.sum() // 2)
    return problem


def market_split(rows: int, seed: int) -> pulp.LpProblem:
    """Equations that hardly any set of items fulfils: no solution comes quickly."""
    rng = np.random.RandomState(seed)
    items = [pulp.LpVariable(f"x_{item:03d}", cat=pulp.LpBinary) for item in range(10 * (rows - 1))]
    problem = pulp.LpProblem("market_split", pulp.LpMinimize)
    problem.setObjective(pulp.lpSum(items))
    for row in rng.randint(0, 100, (rows, len(items))):
        problem += pulp.lpSum(int(weight) * item for weight, item in zip(row, items)) == int(row.sum() // 2)
    return problem


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_program_by_hand(solver: str) -> None:
    x, y = pulp.LpVariable("x", 1.0, None), pulp.LpVariable("y", cat=pulp.LpInteger)
    problem = pulp.LpProblem("by_hand", pulp.LpMinimize)
    problem.setObjective(x + 2 * y + 10)
    problem += x + y >= 3.5
    problem += y >= 0.5
    problem += x - y <= 1.0
    assert solve(problem, solver=solver, time_limit=10.0) == pytest.approx(15.5)
    assert (x.value(), y.value()) == pytest.approx((1.5, 2.0))


@pytest.mark.parametrize("solver", SOLVERS)
def test_no_solution_is_an_answer(solver: str) -> None:
    z = pulp.LpVariable("z", cat=pulp.LpBinary)
    problem = pulp.LpProblem("contradiction", pulp.LpMinimize)
    problem.setObjective(z)
    problem += z >= 0.4
    problem += z <= 0.6
    assert solve(problem, solver=solver, time_limit=10.0) is None


def test_without_a_constraint_the_bounds_decide() -> None:
    x = pulp.LpVariable("x", 2.0, 5.0)
    problem = pulp.LpProblem("free", pulp.LpMinimize)
    problem.setObjective(3 * x)
    assert solve(problem, solver=None, time_limit=10.0) == pytest.approx(6.0)


@pytest.mark.parametrize("solver", SOLVERS)
def test_stopped_early_it_claims_no_more_than_it_knows(solver: str) -> None:
    problem = knapsack(100, 20, seed=1)
    begun = time.monotonic()
    bound = solve(problem, solver=solver, time_limit=0.5)
    assert time.monotonic() - begun < 60.0
    assert bound is not None and bound < pulp.value(problem.objective) - 1.0, "far from proven in half a second"


@pytest.mark.parametrize("solver", SOLVERS)
def test_no_solution_in_time_is_no_answer(solver: str) -> None:
    begun = time.monotonic()
    with pytest.raises(TimedOut, match="0.3 s"):
        solve(market_split(5, seed=2), solver=solver, time_limit=0.3)
    assert time.monotonic() - begun < 60.0


@pytest.mark.parametrize("solver", ["magic", "", "HiGHS "])
def test_an_unknown_solver_is_refused(solver: Optional[str]) -> None:
    with pytest.raises(InvalidParameter, match="solver"):
        solve(knapsack(3, 1, seed=0), solver=solver, time_limit=1.0)


def test_without_highs_cbc_takes_over(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solvers, "milp", None)
    with pytest.raises(InvalidParameter, match="HiGHS"):
        solve(knapsack(3, 1, seed=0), solver="highs", time_limit=1.0)
    try:
        assert solve(knapsack(3, 1, seed=0), solver=None, time_limit=5.0) is not None
    except InvalidParameter as error:
        assert "coinor-cbc" in str(error)
