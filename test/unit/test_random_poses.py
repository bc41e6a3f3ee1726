"""Random starts and goals."""

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.errors import InvalidInput
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.planner import SocialPlanner
from social_fleet.planning.random_poses import random_pose_pairs

SPACE = ConfigurationSpace(grid_from_text("""
    ..........#..
    ..........#..
    ..........#..
""", 1.0), 0.4)


def test_they_lie_where_the_robot_fits_in_the_largest_part():
    for start, goal in random_pose_pairs(SPACE, 50, seed=1):
        assert start != goal
        for pose in (start, goal):
            SPACE.check_pose(*pose)
            assert pose[0] < 10.0


def test_the_seed_decides():
    pairs = random_pose_pairs(SPACE, 5, seed=1)
    assert pairs == random_pose_pairs(SPACE, 5, seed=1) != random_pose_pairs(SPACE, 5, seed=2)
    planner = SocialPlanner(SPACE.grid, PlannerConfig(robot_radius=0.4))
    assert pairs == random_pose_pairs(planner, 5, seed=1)


def test_starts_and_goals_are_apart():
    pairs = np.array(random_pose_pairs(SPACE, 6, seed=4, separation=2.0))
    for ends in (pairs[:, 0], pairs[:, 1]):
        gaps = np.hypot(*(ends[:, None] - ends[None]).transpose(2, 0, 1))
        assert gaps[~np.eye(6, dtype=bool)].min() >= 2.0


def test_more_than_fit_are_refused():
    with pytest.raises(InvalidInput, match="4 m apart"):
        random_pose_pairs(SPACE, 20, seed=1, separation=4.0)
    with pytest.raises(InvalidInput, match="no room"):
        random_pose_pairs(ConfigurationSpace(SPACE.grid, 5.0), 1, seed=1)
