"""Fleets in closed loop: on time without faults, safe with them."""

import numpy as np
import pytest
from driving import crossing, schedule_of
from repository import ROOT
from worlds import grid_from_text

from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.mapping.files import load_map
from social_fleet.scenario.closed_loop import ClosedLoop, simulate, simulate_scenario
from social_fleet.scenario.fleet import coordinate_scenario
from social_fleet.scenario.random_fleet import random_scenario
from social_fleet.simulation.config import SimulationConfig
from social_fleet.simulation.faults import CircleObstacle, Fault

WILLOW = ROOT.parent / "shared" / "maps" / "willow-full-0.05.yaml"


def test_without_faults_all_arrive_on_time() -> None:
    fleet = crossing()
    report, recording = simulate(fleet)
    assert report.passed and report.min_clearance is not None and report.min_clearance > 0.0
    for robot in report.robots:
        assert robot.arrival_time == pytest.approx(robot.scheduled_time, abs=1.0)
        assert robot.max_tracking_error <= 0.01
    assert recording.poses[0, :, :2].tolist() == [[0.0, 5.0], [5.0, 0.0]]


@pytest.mark.parametrize("at", [0.0, 2.0, 5.0, 7.5, 9.0])
def test_a_pause_of_the_first_costs_time_and_nothing_else(at: float) -> None:
    report, _ = simulate(crossing(), faults=[Fault("gold", "pause", at, 30.0)])
    assert report.passed and report.min_clearance is not None and report.min_clearance > 0.0
    for robot in report.robots:
        assert robot.arrival_time is not None and robot.arrival_time <= robot.scheduled_time + 32.0


def test_without_the_gate_that_pause_would_be_a_collision() -> None:
    ungated = FleetSchedule(tuple(schedule_of(schedule.robot.path.points, name=schedule.name,
                                              wait=schedule.times[0]) for schedule in crossing().schedules))
    report, _ = simulate(ungated, faults=[Fault("gold", "pause", 7.5, 30.0)])
    assert not report.passed and report.collisions[0].kind == "robots"


def test_a_slow_robot_arrives_late() -> None:
    report, _ = simulate(crossing(), faults=[Fault("gold", "slow", 0.0, 60.0, 0.3)])
    assert report.passed
    assert report.robots[0].arrival_time is not None and report.robots[0].arrival_time > 30.0


def test_a_bounded_localisation_error_is_survived() -> None:
    report, _ = simulate(crossing(), config=SimulationConfig(position_error=0.03, heading_error=0.03, seed=4))
    assert report.min_clearance is not None and report.min_clearance > 0.0
    assert all(robot.max_tracking_error < 0.15 for robot in report.robots)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_pause_under_a_localisation_error_does_not_hold_anyone_for_ever(seed: int) -> None:
    report, _ = simulate(crossing(), config=SimulationConfig(position_error=0.05, heading_error=0.03, seed=seed),
                         faults=[Fault("gold", "pause", 5.0, 20.0)])
    assert report.passed and report.min_clearance is not None and report.min_clearance > 0.0


def test_an_obstacle_is_waited_for() -> None:
    report, recording = simulate(crossing(), obstacles=[CircleObstacle(3.0, 5.0, 0.3, disappears=20.0)])
    assert report.passed and report.collisions == ()
    assert recording.poses[recording.times < 20.0, 0, 0].max() < 2.4


def test_what_cannot_arrive_is_given_up() -> None:
    report, _ = simulate(crossing(), config=SimulationConfig(deadline_factor=1.0, deadline_extra=1.0),
                         obstacles=[CircleObstacle(3.0, 5.0, 0.3)])
    assert not report.passed and "robot gold did not arrive" in report.failures
    assert report.simulated_time < 30.0


def test_a_wall_across_the_path_is_a_contact() -> None:
    grid = grid_from_text("\n".join(["............", "............", "......#....."] + ["............"] * 9))
    report, _ = simulate(FleetSchedule((schedule_of([(1, 9.5), (11, 9.5)]),)), grid)
    assert [contact.kind for contact in report.collisions] == ["wall"] and report.min_clearance is None


@pytest.mark.skipif(not WILLOW.exists(), reason="the Willow map does not lie next to the repository")
@pytest.mark.parametrize("seed", [0, 1])
def test_a_random_fleet_on_the_willow_map_keeps_to_its_schedule(seed: int) -> None:
    grid = load_map(WILLOW)
    scenario = random_scenario(grid, 6, seed=seed, map_name=WILLOW.name, map_path=str(WILLOW))
    report, _ = simulate_scenario(scenario, coordinate_scenario(scenario, grid), grid)
    assert report.passed, report.failures


def test_the_same_seed_gives_the_same_run() -> None:
    config = SimulationConfig(position_error=0.02, seed=7)
    first, second = (simulate(crossing(), config=config)[1].poses for _ in range(2))
    assert np.array_equal(first, second)


def test_progress_is_told_as_a_share() -> None:
    told: list = []
    simulate(crossing(), progress=told.append)
    assert told and told == sorted(told) and 0.0 <= told[0] and told[-1] <= 1.0


def test_no_command_or_motion_exceeds_a_limit() -> None:
    loop = ClosedLoop(crossing(), faults=[Fault("gold", "pause", 3.0, 5.0)])
    commands = []
    while not loop.finished and loop.now < 120.0:
        loop.step()
        commands.append([tracker.command for tracker in loop.trackers.values()])
    values = np.array(commands)
    assert loop.finished
    assert values[:, :, 0].min() >= 0.0 and values[:, :, 0].max() <= 0.7
    assert (np.abs(np.diff(values, axis=0)) <= np.array([1.0, 3.0]) * 0.05 + 1e-9).all()
    poses = loop.recorder.recording().poses
    assert np.hypot(*np.diff(poses[:, :, :2], axis=0).reshape(-1, 2).T).max() <= 0.7 * 0.05 + 1e-9
