"""Social paths along walls at any angle: in their lane, without a zigzag, within the free space."""

import math

import numpy as np
import pytest

from social_fleet.mapping.drawing import draw
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.planner import SocialPlanner

WIDTH = 3.0  # [m] of the corridor
LENGTH = 24.0


def corridor(angle, resolution):
    """A corridor through the middle of a solid map of 30 x 30 m, at `angle` [degrees]."""
    shape = {"fill": "free", "x": [15.0 - 0.5 * LENGTH, 15.0 + 0.5 * LENGTH],
             "y": [15.0 - 0.5 * WIDTH, 15.0 + 0.5 * WIDTH]}
    return draw({"size": [30.0, 30.0], "resolution": resolution,
                 "shapes": [{"fill": "wall", "x": [-1.0, 31.0], "y": [-1.0, 31.0]},
                            {"turn": angle, "about": [15.0, 15.0], "shapes": [shape]}]})


@pytest.mark.parametrize("resolution", [0.05, 0.2])
@pytest.mark.parametrize("angle", [0.0, 10.0, 20.0, 30.0, 45.0, 63.0, 80.0, 100.0, 150.0])
def test_along_a_wall_at_any_angle(angle, resolution):
    planner = SocialPlanner(corridor(angle, resolution), PlannerConfig())
    along = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    across = np.array([-along[1], along[0]])
    plan = planner.plan(np.array([15.0, 15.0]) - 10.5 * along, np.array([15.0, 15.0]) + 10.5 * along)
    assert planner.space.is_free_path(plan.points)
    path = plan.path
    turns = np.abs(np.angle(np.exp(1j * np.diff(path.segment_headings))))
    # Into the lane and out of it: one turn each, by no more than the slant of a diagonal step.
    assert turns.sum() < math.radians(2 * 45.0)
    middle = (path.position(np.linspace(0.3, 0.7, 50) * path.length) - 15.0) @ across
    # The right-hand lane, as exactly as the cells of the wall show it.
    assert (middle < 0.0).all()
    assert abs(np.mean(middle) + 0.5 * WIDTH - PlannerConfig().lane_standoff) < 0.1 + 2.0 * resolution
    headings = path.segment_headings[(path.arc_lengths[:-1] > 0.3 * path.length)
                                     & (path.arc_lengths[1:] < 0.7 * path.length)]
    offsets = np.angle(np.exp(1j * (headings - math.radians(angle))))
    assert np.abs(offsets).max(initial=0.0) < math.radians(12.0)
