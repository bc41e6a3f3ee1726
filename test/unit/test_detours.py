"""Temporary heatmaps of several obstacles."""

import numpy as np

from social_fleet.planning.overlays.shapes import DiscObstacle
from social_fleet.planning.routes.detours import Detours
from social_fleet.planning.routes.heatmaps import EdgeCounts

SHAPE = (4, 5)
CART, BOX = DiscObstacle(1.0, 1.0, 0.5), DiscObstacle(3.0, 1.0, 0.5)


def counts(**paths):
    """Counts by edge, as e3=2."""
    edges = sorted(int(name[1:]) for name in paths)
    return EdgeCounts(SHAPE, np.array(edges, dtype=np.int64),
                      np.array([paths[f"e{edge}"] for edge in edges], dtype=np.uint16))


def made():
    detours = Detours(SHAPE)
    detours.add({"cart": CART}, np.array([3, 4]))
    detours.add({"cart": CART}, np.array([4, 5]))
    detours.add({"cart": CART, "box": BOX}, np.array([4, 9]))
    detours.add({"box": BOX}, np.array([9]))
    return detours


def test_heatmaps_of_each_obstacle():
    detours = made()
    assert detours.obstacles == {"cart": CART, "box": BOX}
    assert (detours.paths("cart"), detours.paths("box"), detours.paths("moon")) == (3, 2, 0)
    assert detours.counts("cart") == counts(e3=1, e4=3, e5=1, e9=1)
    assert detours.counts("box") == counts(e4=1, e9=2)
    assert detours.counts("moon") == EdgeCounts.none(SHAPE)


def test_what_went_round_an_obstacle_that_goes_is_forgotten():
    detours = made()
    detours.forget(["box"])
    assert detours.obstacles == {"cart": CART} and detours.paths("cart") == 2
    detours.forget(["cart", "moon"])
    assert detours.obstacles == {}


def test_what_went_round_another_too_stays_a_detour():
    detours = made()
    assert detours.release("cart") == counts(e3=1, e4=2, e5=1)
    assert detours.obstacles == {"box": BOX} and detours.paths("box") == 2
    assert detours.release("box") == counts(e4=1, e9=2)
    assert detours.obstacles == {} and detours.release("box") == EdgeCounts.none(SHAPE)


def test_many_detours():
    detours = Detours(SHAPE)
    for index in range(500):
        detours.add({"cart": CART}, np.array([index % 2, 30]))
    assert detours.paths("cart") == 500
    assert detours.counts("cart") == counts(e0=250, e1=250, e30=500)
