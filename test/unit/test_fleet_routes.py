"""The learning fleet: detours, recovery, promotion, threads."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from repository import ROOT
from worlds import grid_from_text

from social_fleet.errors import InvalidGraph, InvalidInput
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.mapping.files import load_map
from social_fleet.mapping.walls import HEADINGS
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.overlays.overlay_set import OverlaySet
from social_fleet.planning.overlays.raster import drawn_on
from social_fleet.planning.overlays.shapes import DiscObstacle, Rectangle
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import random_pose_pairs
from social_fleet.planning.routes.fleet_routes import FleetRoutes
from social_fleet.planning.routes.social_graph import SocialGraph, learn

HALL = grid_from_text("\n".join(["#" * 60] + ["#" + "." * 58 + "#"] * 20 + ["#" * 60]), 0.2)
CONFIG = PlannerConfig(heatmap_threshold=1, min_component=2, promotion_threshold=3, temporary_distance=1.0)
PLANNER = SocialPlanner(HALL, CONFIG)
CART, FAR = DiscObstacle(6.0, 0.6, 0.5), DiscObstacle(6.0, 3.7, 0.4)
WEST, EAST = (1.0, 0.6), (11.0, 0.6)


def made(**obstacles):
    overlays = OverlaySet(HALL)
    for name, shape in obstacles.items():
        overlays.add(name, shape)
    return FleetRoutes(PLANNER, overlays), overlays


def add(routes, overlays, times=1):
    plan = PLANNER.plan(WEST, EAST, overlays=overlays)
    for _ in range(times):
        routes.add(plan)
    return plan


def crossing(graph, judge):
    """Edges of a graph along which the disc of `judge` overlaps something."""
    bad = []
    for heading, (across, along) in enumerate(HEADINGS):
        for cell in np.argwhere(graph.edges >> heading & 1):
            if not judge.is_free_path(judge.grid.centres([cell, cell + (along, across)])):
                bad.append((heading, *cell))
    return bad


def test_a_fleet_learns_what_one_robot_would():
    routes, overlays = made()
    plans = [PLANNER.plan(*pair) for pair in random_pose_pairs(PLANNER, 30, seed=2)]
    for plan in plans:
        routes.add(plan)
    assert routes.graph is None and routes.counted == 30
    assert routes.learn() == ()
    expected = learn(PLANNER, paths=30, seed=2)
    np.testing.assert_array_equal(routes.graph.edges, expected.edges)
    assert routes.graph.counts == expected.counts


def test_detours_are_kept_apart_and_forgotten():
    routes, overlays = made()
    add(routes, overlays, 2)
    routes.learn()
    before = routes.graph
    overlays.add("cart", CART)
    detour = add(routes, overlays, 3)
    assert detour.temporary and routes.detours() == {"cart": 3} and routes.counted == 2
    assert routes.temporary_heatmaps("cart").counts.max() == 3
    routes.learn()
    np.testing.assert_array_equal(routes.graph.edges, before.edges)
    overlays.remove("cart")
    assert routes.detours() == {} and not len(routes.temporary_heatmaps("cart").edges)
    routes.learn()
    np.testing.assert_array_equal(routes.graph.edges, before.edges)


def test_an_obstacle_that_stays_becomes_part_of_the_routes():
    routes, overlays = made()
    add(routes, overlays, 2)
    routes.learn()
    overlays.add("cart", CART, expires=50.0)
    detour = add(routes, overlays, 3)
    assert routes.due() == () and routes.learn() == ()
    routes.add(detour)
    assert routes.due() == ("cart",)
    assert routes.learn() == ("cart",)
    assert routes.due() == () and routes.detours() == {}
    assert overlays.expire(1e9) == () and overlays.get("cart").permanent
    judge = ConfigurationSpace(drawn_on(HALL, [CART]), CONFIG.robot_radius + CONFIG.wall_margin)
    assert crossing(routes.graph, judge) == []
    # what the detours went is a route now
    headings = np.diff(detour.cells, axis=0)
    used = [routes.graph.edges[tuple(cell)] for cell in detour.cells[:-1]]
    assert len(headings) == len(used) and all(used)
    # and plans by it are no detours any more
    assert not PLANNER.plan(WEST, EAST, overlays=overlays).temporary
    add(routes, overlays)
    assert routes.counted == 3


def test_plans_that_cross_a_permanent_obstacle_are_not_learnt_from():
    routes, overlays = made()
    through = PLANNER.plan(WEST, EAST)
    overlays.add("cart", CART)
    overlays.make_permanent("cart")
    for _ in range(3):
        routes.add(through)  # of a robot that does not know of it
    routes.learn()
    judge = ConfigurationSpace(drawn_on(HALL, [CART]), CONFIG.robot_radius + CONFIG.wall_margin)
    assert routes.graph.edge_count and crossing(routes.graph, judge) == []


def test_promotion_can_be_turned_off():
    never = SocialPlanner(HALL, replace(CONFIG, promotion_threshold=0))
    overlays = OverlaySet(HALL)
    overlays.add("cart", CART)
    routes = FleetRoutes(never, overlays)
    for _ in range(100):
        routes.add(never.plan(WEST, EAST, overlays=overlays))
    assert routes.due() == () and routes.learn() == () and routes.detours() == {"cart": 100}


def test_a_detour_round_two_obstacles_waits_for_both():
    wide = SocialPlanner(HALL, replace(CONFIG, temporary_distance=3.0))
    overlays = OverlaySet(HALL)
    overlays.add("cart", CART)
    overlays.add("box", FAR)
    routes = FleetRoutes(wide, overlays)
    plan = wide.plan(WEST, EAST, overlays=overlays)
    assert set(plan.obstacles) == {"cart", "box"}
    routes.add(plan)
    overlays.make_permanent("cart")
    routes.learn()
    assert routes.detours() == {"box": 1} and not len(routes.graph.counts.edges)
    overlays.make_permanent("box")
    routes.learn()
    assert routes.detours() == {} and len(routes.graph.counts.edges)


def test_another_obstacle_of_the_same_name_begins_anew():
    routes, overlays = made(cart=CART)
    add(routes, overlays, 2)
    overlays.add("cart", CART, expires=9.0)  # seen again
    assert routes.detours() == {"cart": 2}
    overlays.add("cart", FAR)
    assert routes.detours() == {}


def test_a_detour_round_nothing_that_is_there_teaches_nothing():
    routes, overlays = made(cart=CART)
    plan = PLANNER.plan(WEST, EAST, overlays=overlays)
    overlays.remove("cart")
    routes.add(plan)
    routes.add_path(plan.cells, temporary=True)
    assert routes.counted == 0 and routes.detours() == {}


def test_what_is_no_path_is_refused():
    routes, _ = made()
    with pytest.raises(InvalidInput):
        routes.add_path(np.array([(3, 3), (3, 6)]))
    with pytest.raises(InvalidInput):
        routes.add_path(np.array([(3, 59), (3, 60)]))
    assert routes.counted == 0


def test_what_was_learnt_before_is_the_beginning():
    graph = learn(PLANNER, paths=20, seed=4)
    routes = FleetRoutes(PLANNER, OverlaySet(HALL), graph=graph)
    assert routes.graph is graph
    routes.learn()
    np.testing.assert_array_equal(routes.graph.edges, graph.edges)
    routes.take_over(graph)
    assert routes.graph.counts.counts.max() == 2 * graph.counts.counts.max()
    bare = FleetRoutes(PLANNER, OverlaySet(HALL), graph=SocialGraph(graph.edges, graph.digest, graph.resolution))
    bare.learn()
    np.testing.assert_array_equal(bare.graph.edges, graph.edges)
    with pytest.raises(InvalidGraph, match="another map"):
        routes.take_over(SocialGraph(np.zeros((3, 3), dtype=np.uint8), "x", 0.2))


def test_adding_while_learning_loses_nothing():
    routes, overlays = made()
    plan = PLANNER.plan(WEST, EAST)
    done = threading.Event()

    def keep_learning():
        while not done.is_set():
            routes.learn()

    background = threading.Thread(target=keep_learning)
    background.start()
    adders = [threading.Thread(target=lambda: [routes.add(plan) for _ in range(300)]) for _ in range(3)]
    for thread in adders:
        thread.start()
    for thread in adders:
        thread.join(timeout=60.0)
    done.set()
    background.join(timeout=60.0)
    routes.learn()
    assert routes.counted == 900 and routes.graph.counts.counts.max() == 900
    assert routes.graph.counts.counts.min() == 900


def test_nobody_waits_for_an_extraction():
    routes, _ = made()
    plan = PLANNER.plan(WEST, EAST)
    with routes._counting, routes._learning:  # as while the graph is extracted
        began = time.monotonic()
        for _ in range(100):
            routes.add(plan)
        assert routes.graph is None
        PLANNER.plan(WEST, EAST)
        assert time.monotonic() - began < 5.0
    routes.learn()
    assert routes.graph.counts.counts.min() == 100


def test_forty_detours_then_recovery_then_promotion_on_environment_1():
    planner = SocialPlanner(load_map(ROOT / "maps" / "environment_1.yaml"), PlannerConfig(promotion_threshold=40))
    graph = learn(planner, paths=60, seed=1)
    overlays = OverlaySet(planner.grid)
    routes = FleetRoutes(planner, overlays, graph=graph)
    planner.graph = graph
    start, goal = (2.0, 25.0), (97.0, 40.0)
    old = planner.plan(start, goal)
    x, y = old.path.position(0.5 * old.length)
    pallet = Rectangle(float(x), float(y), 1.2, 0.8, 0.3)

    def forty_detours():
        overlays.add("pallet", pallet)
        for shift in np.linspace(-1.0, 1.0, 40):
            detour = planner.plan((start[0], start[1] + shift), (goal[0], goal[1] + shift), overlays=overlays)
            assert detour.obstacles == ("pallet",)
            routes.add(detour)

    forty_detours()
    assert routes.learn() == ()
    planner.graph = routes.graph
    np.testing.assert_array_equal(routes.graph.edges, graph.edges)
    overlays.remove("pallet")
    np.testing.assert_array_equal(planner.plan(start, goal).points, old.points)
    assert routes.learn() == ()
    assert routes.graph.counts == graph.counts

    forty_detours()
    routes.add(planner.plan(start, goal, overlays=overlays))
    assert routes.learn() == ("pallet",)
    judge = ConfigurationSpace(drawn_on(planner.grid, [pallet]), planner.config.robot_radius)
    assert crossing(graph, judge) != []
    assert crossing(routes.graph, judge) == []
    planner.graph = routes.graph
    route = planner.plan(start, goal, overlays=overlays)
    assert not route.temporary and judge.is_free_path(route.points)
