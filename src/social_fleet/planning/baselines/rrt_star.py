"""RRT*: a sampling planner to compare with. It rewires until its budget is spent, not until its first solution.

Samples are drawn from the free cells evenly. A new vertex takes the cheapest parent of its neighbourhood and becomes
the parent of those that it makes cheaper; what they gain goes down to all their descendants. The neighbourhood shrinks
as the tree grows, by the law that makes the method optimal in the limit.

References
----------
Karaman and Frazzoli, Sampling-based algorithms for optimal motion planning, IJRR 30(7), 2011.
"""

import math
from typing import NamedTuple, Optional, Tuple

import numpy as np
from numba import njit

from social_fleet.planning.driven_path.chords import Ground, is_free

GOAL_SHARE = 0.05  # of the samples are the goal itself
PATIENCE = 25  # budgets after which a tree that has not found the goal is given up


class Tree(NamedTuple):
    """Vertices with parent and cost; children as linked lists; and vertices by square of the plane, linked too."""

    x: np.ndarray
    y: np.ndarray
    cost: np.ndarray
    parent: np.ndarray
    child: np.ndarray
    sibling: np.ndarray
    first: np.ndarray  # (rows, cols) newest vertex of a square
    following: np.ndarray
    square: float


def rrt_star(ground: Ground, free: np.ndarray, start: Tuple[float, float], goal: Tuple[float, float], *,
             samples: int, step: float, seed: int) -> Optional[np.ndarray]:
    """A path by RRT*.

    Parameters
    ----------
    ground : Ground
        Where the robot fits.
    free : (M, 2) array
        Centres (x, y) of the free cells in cells: samples are drawn from these cells.
    start, goal : (x, y)
        In cells along the grid's axes.
    samples : int
        Budget. A tree that needs more to find the goal gets it, up to PATIENCE times as many, and then as many again to
        rewire.
    step : float
        Longest edge of the tree [cells].
    seed : int
        The same seed gives the same path.

    Returns
    -------
    (N, 2) array or None
        Vertices in cells from start to goal; None when the tree did not reach the goal.
    """
    tree, _, end = grown(ground, free, start, goal, samples=samples, step=step, seed=seed)
    if end < 0:
        return None
    chain = [end]
    while tree.parent[chain[-1]] >= 0:
        chain.append(int(tree.parent[chain[-1]]))
    points = np.column_stack([tree.x[chain[::-1]], tree.y[chain[::-1]]])
    return points if tuple(points[-1]) == tuple(goal) else np.vstack([points, goal])


def grown(ground: Ground, free: np.ndarray, start: Tuple[float, float], goal: Tuple[float, float], *,
          samples: int, step: float, seed: int) -> Tuple[Tree, int, int]:
    """The tree that `rrt_star` takes its path from, its number of vertices, and the last one before the goal or -1."""
    rows, cols = ground.blocked.shape
    size = 2 * PATIENCE * samples + 2
    squares = (int(rows / step) + 1, int(cols / step) + 1)
    # Filled as the tree grows, so that a small tree costs little.
    x, y, cost = (np.empty(size) for _ in range(3))
    parent, child, sibling, following = (np.empty(size, dtype=np.int32) for _ in range(4))
    tree = Tree(x, y, cost, parent, child, sibling, np.full(squares, -1, dtype=np.int32), following, step)
    count, end = _grow(ground, tree, free, start, goal, samples, PATIENCE * samples, seed)
    return tree, count, end


@njit(cache=True)
def _grow(ground: Ground, tree: Tree, free: np.ndarray, start: Tuple[float, float], goal: Tuple[float, float],
          samples: int, limit: int, seed: int) -> Tuple[int, int]:
    """Grow the tree; how many vertices it has, and from which the goal is cheapest to reach in one edge, or -1."""
    np.random.seed(seed)
    step = tree.square
    _insert(tree, 0, start[0], start[1], -1, 0.0)
    count = 1
    near = np.empty(len(tree.x), dtype=np.int64)
    reached = False
    sample, end = 0, limit
    while sample < end:
        sample += 1
        x, y = goal
        if reached or np.random.random() >= GOAL_SHARE:
            cell = np.random.randint(len(free))
            x, y = free[cell, 0] + np.random.random() - 0.5, free[cell, 1] + np.random.random() - 0.5
        origin = _nearest(tree, x, y)
        gap = math.hypot(x - tree.x[origin], y - tree.y[origin])
        if gap < 1e-9:
            continue
        share = min(1.0, step / gap)
        x, y = tree.x[origin] + share * (x - tree.x[origin]), tree.y[origin] + share * (y - tree.y[origin])
        if not is_free(ground, tree.x[origin], tree.y[origin], x, y):
            continue
        found = _within(tree, x, y, neighbourhood(count + 1, len(free), step), near)
        parent, cost = _best_parent(ground, tree, x, y, origin, near[:found])
        _insert(tree, count, x, y, parent, cost)
        _rewire(ground, tree, count, near[:found])
        count += 1
        if not reached and math.hypot(goal[0] - x, goal[1] - y) <= step and is_free(ground, x, y, goal[0], goal[1]):
            reached = True
            end = max(samples, 2 * sample)
    return count, _best_end(ground, tree, goal, step, near)


@njit(cache=True)
def neighbourhood(count: int, area: float, step: float) -> float:
    """Radius within which a tree of `count` vertices in `area` square cells of free space rewires [cells].

    gamma (log n / n)^(1/2), at most `step`; gamma is a tenth above 2 (1 + 1/2)^(1/2) (area / pi)^(1/2), which Karaman
    and Frazzoli show to be enough.
    """
    gamma = 1.1 * 2.0 * math.sqrt(1.5 * area / math.pi)
    return min(gamma * math.sqrt(math.log(count) / count), step)


@njit(cache=True)
def _best_end(ground: Ground, tree: Tree, goal: Tuple[float, float], step: float, near: np.ndarray) -> int:
    """The vertex through which the goal is cheapest, once all costs are final."""
    best, end = np.inf, -1
    for i in range(_within(tree, goal[0], goal[1], step, near)):
        v = near[i]
        cost = tree.cost[v] + math.hypot(goal[0] - tree.x[v], goal[1] - tree.y[v])
        if cost < best and is_free(ground, tree.x[v], tree.y[v], goal[0], goal[1]):
            best, end = cost, v
    return end


@njit(cache=True)
def _insert(tree: Tree, v: int, x: float, y: float, parent: int, cost: float) -> None:
    tree.x[v], tree.y[v], tree.cost[v] = x, y, cost
    tree.parent[v] = tree.child[v] = tree.sibling[v] = -1
    row, col = int(y / tree.square), int(x / tree.square)
    tree.following[v] = tree.first[row, col]
    tree.first[row, col] = v
    _adopt(tree, v, parent)


@njit(cache=True)
def _adopt(tree: Tree, v: int, parent: int) -> None:
    """Make `v` a child of `parent`."""
    old = tree.parent[v]
    if old >= 0:
        if tree.child[old] == v:
            tree.child[old] = tree.sibling[v]
        else:
            brother = tree.child[old]
            while tree.sibling[brother] != v:
                brother = tree.sibling[brother]
            tree.sibling[brother] = tree.sibling[v]
    tree.parent[v] = parent
    if parent >= 0:
        tree.sibling[v] = tree.child[parent]
        tree.child[parent] = v


@njit(cache=True)
def _within(tree: Tree, x: float, y: float, radius: float, near: np.ndarray) -> int:
    """Fill `near` with the vertices within `radius`; returns how many."""
    rows, cols = tree.first.shape
    found = 0
    for row in range(max(int((y - radius) / tree.square), 0), min(int((y + radius) / tree.square) + 1, rows)):
        for col in range(max(int((x - radius) / tree.square), 0), min(int((x + radius) / tree.square) + 1, cols)):
            v = tree.first[row, col]
            while v >= 0:
                if math.hypot(x - tree.x[v], y - tree.y[v]) <= radius:
                    near[found] = v
                    found += 1
                v = tree.following[v]
    return found


@njit(cache=True)
def _nearest(tree: Tree, x: float, y: float) -> int:
    """The nearest vertex, looked for in growing squares."""
    rows, cols = tree.first.shape
    row, col = int(y / tree.square), int(x / tree.square)
    best, nearest = np.inf, 0
    for ring in range(max(rows, cols)):
        for r in range(max(row - ring, 0), min(row + ring + 1, rows)):
            for c in range(max(col - ring, 0), min(col + ring + 1, cols)):
                if max(abs(r - row), abs(c - col)) != ring:
                    continue
                v = tree.first[r, c]
                while v >= 0:
                    gap = math.hypot(x - tree.x[v], y - tree.y[v])
                    if gap < best:
                        best, nearest = gap, v
                    v = tree.following[v]
        if best <= ring * tree.square:
            break
    return nearest


@njit(cache=True)
def _best_parent(ground: Ground, tree: Tree, x: float, y: float, origin: int,
                 near: np.ndarray) -> Tuple[int, float]:
    """The vertex through which (x, y) is cheapest, and at what cost."""
    parent = origin
    cost = tree.cost[origin] + math.hypot(x - tree.x[origin], y - tree.y[origin])
    for v in near:
        through = tree.cost[v] + math.hypot(x - tree.x[v], y - tree.y[v])
        if through < cost and is_free(ground, tree.x[v], tree.y[v], x, y):
            parent, cost = v, through
    return parent, cost


@njit(cache=True)
def _rewire(ground: Ground, tree: Tree, new: int, near: np.ndarray) -> None:
    """Lead near vertices through the new one where that is cheaper, and hand the gain down to their descendants."""
    for v in near:
        cost = tree.cost[new] + math.hypot(tree.x[new] - tree.x[v], tree.y[new] - tree.y[v])
        if cost < tree.cost[v] - 1e-9 and is_free(ground, tree.x[new], tree.y[new], tree.x[v], tree.y[v]):
            _adopt(tree, v, new)
            _lower(tree, v, tree.cost[v] - cost)


@njit(cache=True)
def _lower(tree: Tree, root: int, gain: float) -> None:
    """Take `gain` off the cost of a vertex and of all its descendants."""
    v = root
    tree.cost[v] -= gain
    while True:
        if tree.child[v] >= 0:
            v = tree.child[v]
        else:
            while v != root and tree.sibling[v] < 0:
                v = tree.parent[v]
            if v == root:
                return
            v = tree.sibling[v]
        tree.cost[v] -= gain
