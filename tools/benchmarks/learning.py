"""The learning fleet: detours, recovery and promotion on Environment 1; what adding a plan and an extraction cost."""

import threading
import time
from typing import Callable, List, Tuple

import numpy as np

from .worlds import map_files, planner
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.mapping.files import load_map
from social_fleet.mapping.walls import HEADINGS
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.overlays.overlay_set import OverlaySet
from social_fleet.planning.overlays.raster import drawn_on
from social_fleet.planning.overlays.shapes import Rectangle
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import random_pose_pairs
from social_fleet.planning.routes.fleet_routes import FleetRoutes
from social_fleet.planning.routes.social_graph import SocialGraph, learn

PATHS, DETOURS = 100, 40
START, GOAL = (2.0, 25.0), (97.0, 40.0)
LONGEST_ADD = 1e-3  # [s]
OBSTACLE = 1.0  # [m]


def run(say: Callable[[str], None]) -> bool:
    """Whether detours leave the graph alone, the old route is back at once, and promotion clears the obstacle."""
    held = _changes(say)
    for name in map_files():
        held &= _costs(name, say)
    return held


def _changes(say: Callable[[str], None]) -> bool:
    planning = SocialPlanner(load_map(map_files()["environment_1"]), PlannerConfig(promotion_threshold=DETOURS))
    learnt = learn(planning, paths=PATHS, seed=1)
    overlays = OverlaySet(planning.grid)
    routes = FleetRoutes(planning, overlays, graph=learnt)
    planning.graph = learnt
    old = planning.plan(START, GOAL)
    x, y = old.path.position(0.5 * old.length)
    obstacle = Rectangle(float(x), float(y), 1.2, 0.8, 0.3)
    judge = ConfigurationSpace(drawn_on(planning.grid, [obstacle]), planning.config.robot_radius)

    _detour(planning, routes, overlays, obstacle, DETOURS)
    routes.learn()
    assert routes.graph is not None
    untouched = bool(np.array_equal(routes.graph.edges, learnt.edges))
    planning.graph = routes.graph
    overlays.remove("obstacle")
    back = planning.plan(START, GOAL)
    same = bool(np.array_equal(back.points, old.points))
    say(f"environment_1: {DETOURS} detours: graph of {learnt.edge_count} edges {'un' if untouched else ''}touched; "
        f"obstacle gone: old route {'back at once' if same else 'NOT back'}")
    before = _crossing(learnt, judge)
    _detour(planning, routes, overlays, obstacle, DETOURS + 1)
    promoted = routes.learn()
    after = _crossing(routes.graph, judge)
    say(f"environment_1: {DETOURS + 1} detours: promoted {', '.join(promoted) or 'nothing'}; edges that cross it: "
        f"{before} before, {after} after, wanted 0")
    return untouched and same and bool(promoted) and before > 0 and after == 0


def _detour(planning: SocialPlanner, routes: FleetRoutes, overlays: OverlaySet, obstacle: Rectangle,
            count: int) -> None:
    overlays.add("obstacle", obstacle)
    for shift in np.linspace(-1.0, 1.0, count):
        routes.add(planning.plan((START[0], START[1] + shift), (GOAL[0], GOAL[1] + shift), overlays=overlays))


def _crossing(graph: SocialGraph, judge: ConfigurationSpace) -> int:
    """How many edges of the graph the robot cannot drive in that space."""
    crossing = 0
    for heading, (across, along) in enumerate(HEADINGS):
        cells = np.argwhere(graph.edges >> heading & 1)
        ends = np.stack([judge.grid.centres(cells), judge.grid.centres(cells + (along, across))], axis=1)
        crossing += sum(not judge.is_free_path(pair) for pair in ends)
    return crossing


def _costs(name: str, say: Callable[[str], None]) -> bool:
    """Times of adding plans and of an extraction, and of plans alone and beside extractions."""
    planning = planner(name)
    pairs = random_pose_pairs(planning, PATHS, seed=2)
    plans = [planning.plan(*pair) for pair in pairs]
    overlays = OverlaySet(planning.grid)
    routes = FleetRoutes(planning, overlays)
    adding = [_time(lambda plan=plan: routes.add(plan)) for plan in plans]  # type: ignore[misc]
    extracting = [_time(routes.learn) for _ in range(5)]
    shortest = [pair for pair, plan in sorted(zip(pairs, plans), key=lambda item: item[1].length)[:5]]
    alone, beside = _plan_beside(planning, routes, shortest)
    places = [plan.path.position(0.5 * plan.length) for plan in plans[:20]]
    shapes = [Rectangle(float(x), float(y), OBSTACLE, OBSTACLE, 0.3) for x, y in places]
    drawing = [_time(lambda shape=shape: planning.closed_cells([shape])) for shape in shapes]  # type: ignore[misc]
    stalled = np.array(beside) - alone
    say(f"{name}: adding a plan {1e3 * np.mean(adding):.2f} ms, at most {1e3 * max(adding):.2f} ms, wanted <= 1 ms; "
        f"extraction {1e3 * np.median(extracting):.0f} ms; a plan of {1e3 * np.median(alone):.1f} ms takes "
        f"{1e3 * np.median(stalled):+.1f} ms while one runs, at most {1e3 * max(stalled):+.1f} ms")
    say(f"{name}: drawing in an obstacle of {OBSTACLE:g} m {1e3 * np.median(drawing):.1f} ms, wanted << 10 ms")
    return bool(np.mean(adding) <= LONGEST_ADD)


def _plan_beside(planning: SocialPlanner, routes: FleetRoutes, pairs: List) -> Tuple[List[float], List[float]]:
    """Times of plans without and with another thread that extracts all the time."""
    plan_all = [lambda pair=pair: planning.plan(*pair) for pair in pairs]  # type: ignore[misc]
    alone = [_time(plan) for _ in range(6) for plan in plan_all]
    done = threading.Event()

    def keep_learning() -> None:
        while not done.is_set():
            routes.learn()

    background = threading.Thread(target=keep_learning)
    background.start()
    beside = [_time(plan) for _ in range(6) for plan in plan_all]
    done.set()
    background.join()
    return alone, beside


def _time(work: Callable[[], object]) -> float:
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun
