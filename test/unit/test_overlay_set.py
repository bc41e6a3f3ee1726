"""Obstacles under names, for a time or for good."""

import math
import threading

import numpy as np
import pytest

from social_fleet.errors import InvalidOverlay
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.planning.overlays.overlay_set import Overlay, OverlaySet, as_overlays
from social_fleet.planning.overlays.shapes import DiscObstacle

GRID = OccupancyGrid(np.zeros((20, 20), dtype=np.int8), 0.5)
CART, BOX = DiscObstacle(2.0, 2.0, 0.5), DiscObstacle(8.0, 8.0, 0.5)


def names(overlays):
    return [overlay.name for overlay in overlays.all]


def test_obstacles_come_are_replaced_and_go():
    overlays = OverlaySet(GRID)
    overlays.add("cart", CART)
    overlays.add("box", BOX)
    assert names(overlays) == ["cart", "box"] and overlays.version == 2
    overlays.add("cart", BOX)
    assert overlays.get("cart") == Overlay("cart", BOX) and overlays.version == 3
    overlays.remove("cart")
    assert names(overlays) == ["box"] and overlays.get("cart") is None and overlays.version == 4
    assert overlays.clear() == ("box",) and not len(overlays) and overlays.version == 5
    assert overlays.clear() == () and overlays.version == 5


def test_obstacles_expire():
    overlays = OverlaySet(GRID)
    overlays.add("cart", CART, expires=10.0)
    overlays.add("box", BOX)
    assert overlays.expire(9.9) == ()
    overlays.add("cart", CART, expires=20.0)  # seen again
    assert overlays.version == 2 and overlays.expire(10.0) == ()
    assert overlays.expire(20.0) == ("cart",)
    assert overlays.expire(1e9) == () and names(overlays) == ["box"]


def test_what_is_permanent_stays():
    overlays = OverlaySet(GRID)
    overlays.add("cart", CART, expires=10.0)
    overlays.make_permanent("cart")
    overlays.add("cart", CART, expires=12.0)
    overlays.make_permanent("nobody")
    assert overlays.expire(100.0) == () and overlays.all == (Overlay("cart", CART, None, True),)
    overlays.add("cart", BOX)  # another obstacle of that name
    assert overlays.all == (Overlay("cart", BOX),)


@pytest.mark.parametrize("name, shape, expires, field", [
    ("", CART, None, "name"), (" ", CART, None, "name"), ("cart", CART, math.nan, "expires"),
    ("cart", DiscObstacle(50.0, 2.0, 0.5), None, ""),
])
def test_wrong_obstacles_are_refused_and_nothing_changes(name, shape, expires, field):
    overlays = OverlaySet(GRID)
    overlays.add("cart", BOX)
    with pytest.raises(InvalidOverlay) as caught:
        overlays.add(name, shape, expires=expires)
    assert caught.value.field == field
    assert overlays.all == (Overlay("cart", BOX),) and overlays.version == 1


def test_removing_what_is_not_there_says_what_is():
    overlays = OverlaySet(GRID)
    with pytest.raises(InvalidOverlay, match="none at all"):
        overlays.remove("cart")
    overlays.add("box", BOX)
    with pytest.raises(InvalidOverlay, match="no obstacle 'cart'; there is box"):
        overlays.remove("cart")


def test_a_map_of_another_size_keeps_what_lies_on_it():
    overlays = OverlaySet(GRID)
    overlays.add("cart", CART, expires=5.0)
    overlays.add("box", BOX)
    moved, lost = overlays.moved_to(OccupancyGrid(np.zeros((8, 8), dtype=np.int8), 0.5))
    assert moved.all == (Overlay("cart", CART, 5.0),) and lost == ("box",)


def test_what_a_planner_takes():
    assert as_overlays([CART, BOX]) == (Overlay("obstacle 1", CART), Overlay("obstacle 2", BOX))
    assert as_overlays({"cart": CART}) == (Overlay("cart", CART),)
    assert as_overlays(OverlaySet(GRID)) == ()


def test_threads_lose_nothing():
    overlays = OverlaySet(GRID)

    def work(first):
        for index in range(first, first + 200):
            overlays.add(f"box {index}", BOX)
            if index % 2:
                overlays.remove(f"box {index}")

    threads = [threading.Thread(target=work, args=(1000 * number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=60.0)
    assert len(overlays) == 400 and overlays.version == 1200


def test_an_obstacle_may_concern_one_robot_only():
    overlays = OverlaySet(GRID)
    overlays.add("box", BOX)
    overlays.add("cart", CART, robot="gold")
    assert [overlay.name for overlay in overlays.of("gold")] == ["box", "cart"]
    assert [overlay.name for overlay in overlays.of("blue")] == ["box"] == [overlay.name for overlay in overlays.of("")]
    assert as_overlays(overlays.of("gold")) == overlays.all
    overlays.add("cart", CART)
    assert overlays.of("blue") == overlays.all and overlays.version == 3


def test_a_longer_life_is_the_same_obstacle():
    overlays = OverlaySet(GRID)
    overlays.add("cart", CART, expires=10.0)
    before = overlays.all
    overlays.add("cart", CART, expires=20.0)
    assert overlays.all == before  # so that nothing is drawn anew for it
