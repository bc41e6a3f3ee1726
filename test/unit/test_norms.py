"""What the norms charge, by hand for cells of corridors, doors and open areas."""

import numpy as np
import pytest
from own_norms import KeepOff
from worlds import grid_from_text

from social_fleet.errors import InvalidParameter
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.social_cost.norms import KeepSide, NoNorm, norm_of

EAST, NORTH, WEST, SOUTH = 0, 2, 4, 6
CONFIG = PlannerConfig(robot_radius=0.25, standoff=0.35, open_area=7.0, lane_pull=2.0, buffer_distance=4.0)


def rate(config, right, left):
    """Cost per metre of driving east with walls so far away on either side."""
    walls = np.full((8, 1), 8.0, dtype=np.float32)
    walls[SOUTH], walls[NORTH] = right, left
    return float(norm_of(config).heading_cost(walls, EAST).rate[0])


def test_the_lane_costs_nothing():
    assert rate(CONFIG, 0.35, 9.0) == pytest.approx(0.0)


def test_distance_from_the_lane_costs_by_the_metre_up_to_the_pull():
    assert rate(CONFIG, 1.35, 9.0) == pytest.approx(1.0)
    assert rate(CONFIG, 0.25, 9.0) == pytest.approx(0.1)
    assert rate(CONFIG, 2.35, 9.0) == pytest.approx(2.0)
    assert rate(CONFIG, 6.0, 9.0) == pytest.approx(2.0)


def test_an_opening_is_dear_beside_a_far_wall_and_free_where_none_guides():
    assert rate(CONFIG, 7.5, 3.5) == pytest.approx(7.0 + 5.0 * 0.5)  # and half a metre of the buffer is missing
    assert rate(CONFIG, 7.5, 5.25) == pytest.approx(3.5)
    assert rate(CONFIG, 7.5, 8.0) == 0.0


def test_two_robots_in_a_corridor_of_one_and_a_half_metres_have_lanes_to_pass():
    rates = {right: rate(CONFIG, right, 1.5 - right) for right in (0.3, 0.35, 0.4, 0.5, 0.75)}
    assert min(rates, key=rates.get) == 0.35
    assert rates[0.3] == pytest.approx(0.05, abs=1e-6)
    assert rates[0.5] == pytest.approx(0.15 + 5.0 * 0.125, abs=1e-6)  # so far into the other's half


def test_the_middle_of_a_single_lane_costs_nothing():
    assert rate(CONFIG, 0.45, 0.45) == 0.0
    assert rate(CONFIG, 0.35, 0.55) == pytest.approx(0.1, abs=1e-6)


def test_the_lane_moves_smoothly_from_the_middle_to_the_wall():
    cheapest = []
    for width in np.arange(1.0, 1.6, 0.05):
        offsets = np.arange(0.25, width - 0.25, 0.01)
        cheapest.append(offsets[int(np.argmin([rate(CONFIG, right, width - right) for right in offsets]))])
    assert np.abs(np.diff(cheapest)).max() < 0.2
    assert cheapest[0] == pytest.approx(0.5, abs=0.011)
    assert cheapest[-1] == pytest.approx(0.35, abs=0.011)


def test_drift_costs_in_two_lanes_only():
    walls = np.full((8, 2), 0.5, dtype=np.float32)
    walls[NORTH, 1] = 1.5
    cost = KeepSide(CONFIG).heading_cost(walls, EAST)
    assert cost.change_weight.tolist() == [0.0, 2.0]
    np.testing.assert_array_equal(cost.followed, walls[SOUTH])


def test_left_mirrors_right():
    left = PlannerConfig(side="left")
    for near, far in ((0.4, 1.1), (2.0, 3.0), (7.5, 3.0)):
        assert rate(PlannerConfig(), near, far) == rate(left, far, near)


def test_none_charges_nothing():
    norm = norm_of(PlannerConfig(side="none"))
    assert isinstance(norm, NoNorm)
    cost = norm.heading_cost(np.ones((8, 3), dtype=np.float32), WEST)
    assert not cost.rate.any() and not cost.change_weight.any()


def test_it_sees_as_far_as_it_judges():
    assert KeepSide(CONFIG).reach > CONFIG.open_area


def test_a_norm_of_ones_own_is_found_by_name():
    norm = norm_of(PlannerConfig(norm="own_norms.KeepOff", w_right=3.0))
    assert isinstance(norm, KeepOff) and norm.weight == 3.0


@pytest.mark.parametrize("name, complaint", [
    ("KeepOff", "package.module.Class"), ("", "package.module.Class"), ("own norms.KeepOff", "package.module.Class"),
    ("no_such_module.KeepOff", "cannot be imported"), ("own_norms.Missing", "has no class Missing"),
    ("own_norms.PlannerConfig", "must derive from"), ("own_norms.NoNormAtAll", "must derive from"),
    ("own_norms.Unfinished", "must define heading_cost and reach"), ("own_norms.Picky", "the moon is not full"),
])
def test_a_name_that_is_no_norm_is_refused(name, complaint):
    with pytest.raises(InvalidParameter, match=complaint) as error:
        norm_of(PlannerConfig(norm=name))
    assert error.value.field == "norm"


def test_a_norm_of_ones_own_plans():
    grid = grid_from_text("\n".join(["#" * 60] + ["." * 60] * 15 + ["#" * 60]), 0.2)
    path = SocialPlanner(grid, PlannerConfig(norm="own_norms.KeepOff")).plan((1.0, 0.7), (11.0, 0.7)).path
    assert path.position(0.5 * path.length)[1] > 1.1
