"""The judge finds what was planted, also between samples, and nothing else."""

import math

import numpy as np
import pytest
from driving import schedule_of
from worlds import grid_from_text

from social_fleet.errors import InvalidInput
from social_fleet.geometry import Pose
from social_fleet.mapping.grid import OccupancyGrid
from social_fleet.scenario import judge
from social_fleet.scenario.recording import Recorder, Recording
from social_fleet.simulation.faults import CircleObstacle

HALL = grid_from_text("""
    ########
    #......#
    #......#
    ########
""")


def recording(*tracks: list) -> Recording:
    """Robots a, b, ... at the given (x, y) of each second."""
    poses = np.zeros((len(tracks[0]), len(tracks), 3))
    poses[:, :, :2] = np.array(tracks, dtype=float).transpose(1, 0, 2)
    return Recording(tuple("abc"[:len(tracks)]), np.arange(float(len(tracks[0]))), poses)


def test_robots_that_pass_through_each_other_between_samples_touch() -> None:
    run = recording([(0, 0), (2, 0)], [(2, 0), (0, 0)])
    assert judge.pair_clearance(run, 0, 1, 0.5).tolist() == [-0.5]


def test_parallel_robots_keep_their_distance() -> None:
    run = recording([(0, 0), (2, 0), (4, 0)], [(0, 1), (2, 1), (4, 1.5)])
    assert judge.pair_clearance(run, 0, 1, 0.5).tolist() == pytest.approx([0.5, 0.5])


def test_one_stretch_of_contact_is_one_contact_at_its_worst() -> None:
    run = recording([(0, 0)] * 6, [(3, 0), (0.4, 0), (0.3, 0), (0.4, 0), (3, 0), (4, 0)])
    gaps = judge.pair_clearance(run, 0, 1, 0.5)
    contact, = judge.contacts(run, gaps, "robots", ("a", "b"))
    assert (contact.kind, contact.robots, contact.position) == ("robots", ("a", "b"), (0.0, 0.0))
    assert contact.time in (1.0, 2.0) and contact.clearance == pytest.approx(-0.2)


def test_a_wall_is_touched_by_the_disc_not_by_its_centre() -> None:
    run = recording([(1.5, 1.5), (3.0, 1.5), (3.0, 1.2), (3.0, 2.0)])
    gaps = judge.wall_clearance(run, 0, 0.3, HALL)
    assert gaps.tolist() == pytest.approx([0.2, -0.1, -0.1])
    assert len(judge.contacts(run, gaps, "wall", ("a",))) == 1


def test_the_wall_check_is_brute_force_over_every_blocked_square() -> None:
    random = np.random.RandomState(3)
    blocked = random.uniform(size=(14, 17)) < 0.12
    grid = OccupancyGrid(np.where(blocked, 100, 0), 0.1, Pose(-0.4, 0.3, 0.5))
    local = random.uniform(-0.2, 1.9, size=(40, 2))
    run = recording(grid.from_local(local).tolist())
    gaps = judge.wall_clearance(run, 0, 0.05, grid)
    padded = np.pad(blocked, 12, mode="constant", constant_values=True)
    corners = (np.argwhere(padded)[:, ::-1] - 12) * 0.1
    for gap, begin, end in zip(gaps, local, local[1:]):
        points = begin + np.linspace(0.0, 1.0, 801)[:, None] * (end - begin)
        outside = np.maximum(np.maximum(corners - points[:, None], points[:, None] - corners - 0.1), 0.0)
        exact = min(float(np.hypot(outside[:, :, 0], outside[:, :, 1]).min()), 0.55) - 0.05
        assert exact - 2e-3 <= gap <= exact + 0.005 + 1e-3


def test_touching_exactly_is_no_overlap() -> None:
    run = recording([(1.25, 1.25), (6.75, 1.25)])
    assert judge.contacts(run, judge.wall_clearance(run, 0, 0.25, HALL), "wall", ("a",)) == []


def test_an_obstacle_counts_while_it_is_there() -> None:
    run = recording([(0, 0), (1, 0), (2, 0), (3, 0)])
    gaps = judge.obstacle_clearance(run, 0, 0.25, CircleObstacle(1.5, 0.0, 0.25, appears=2.0))
    assert gaps.tolist() == pytest.approx([np.inf, np.inf, 0.0])


def test_a_single_sample_is_judged_too() -> None:
    run = recording([(1.5, 1.5)], [(1.5, 1.9)])
    assert judge.pair_clearance(run, 0, 1, 0.5).tolist() == pytest.approx([-0.1])
    assert judge.wall_clearance(run, 0, 0.25, HALL).tolist() == pytest.approx([0.25])


def test_arrival_is_coming_to_stay_with_the_right_heading() -> None:
    robot = schedule_of([(0, 0), (2, 0)], name="a", goal_yaw=1.0).robot
    run = recording([(0, 0), (2, 0), (2.2, 0), (2, 0), (2, 0)])
    tolerances = {"position_tolerance": 0.05, "heading_tolerance": 0.1}
    assert judge.arrival_time(run, robot, **tolerances) is None
    run.poses[4:, 0, 2] = 1.0 - 2.0 * math.pi
    assert judge.arrival_time(run, robot, **tolerances) == 4.0


def test_tracking_error_is_from_the_reference_or_else_from_the_path() -> None:
    robot = schedule_of([(0, 0), (4, 0)], name="a").robot
    run = recording([(0, 0.1), (1, 0.2), (2, 0)])
    assert judge.tracking_error(run, robot).tolist() == pytest.approx([0.1, 0.2, 0.0])
    known = Recording(run.names, run.times, run.poses, np.array([[(0, 0)], [(1.5, 0.2)], [(np.nan, np.nan)]]))
    assert judge.tracking_error(known, robot).tolist() == pytest.approx([0.1, 0.5, 0.0])


def test_a_recorder_skips_what_comes_twice() -> None:
    recorder = Recorder(["a"])
    for time in (0.0, 1.0, 1.0, 2.0):
        recorder.add(time, np.array([[time, 0.0, 0.0]]))
    run = recorder.recording()
    assert run.times.tolist() == [0.0, 1.0, 2.0] and run.duration == 2.0 and run.references is None


def test_arrays_that_do_not_fit_are_refused() -> None:
    for times, poses in (([0.0, 0.0], np.zeros((2, 1, 3))), ([0.0], np.zeros((2, 1, 3))),
                         ([0.0], np.full((1, 1, 3), np.nan))):
        with pytest.raises(InvalidInput):
            Recording(("a",), np.array(times), poses)
