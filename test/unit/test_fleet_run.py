"""Fleets under faults, with a dispatcher and a bad network: nothing touches, and nobody waits for ever."""

from dataclasses import replace
from typing import Any, Sequence

import numpy as np
import pytest
from repository import ROOT

from social_fleet.mapping.files import load_map
from social_fleet.scenario.agent import Agent
from social_fleet.scenario.faulty import FaultyRun, drive_scenario, report_of
from social_fleet.scenario.files import load_scenario
from social_fleet.scenario.fleet import FleetPlanner, coordinate_scenario
from social_fleet.scenario.random_faults import random_faulty_scenario
from social_fleet.scenario.scenario import RobotSpec, Scenario
from social_fleet.simulation.faults import CircleObstacle, Fault
from social_fleet.simulation.network import NetworkConfig

PATH = str(ROOT / "maps" / "crossing.yaml")
GRID = load_map(PATH)
PLANNERS = FleetPlanner(GRID, {"wall_margin": 0.14})
BAD = NetworkConfig(loss=0.3, latency=0.05, late=0.4, delay=8.0, seed=5)
NAMED = sorted(path.name for path in (ROOT / "config" / "scenarios").glob("*.yaml"))

EAST = RobotSpec("gold", (1.5, 8.0, 0.0), (14.5, 8.0, 0.0))
ON_ITS_WAY = PLANNERS.plan(EAST).path.position(3.5).tolist()
NORTH = RobotSpec("green", (8.0, 1.5, 1.57), (8.0, 14.5, 1.57), max_speed=0.5)


def run(*faults: Fault, obstacles: Sequence[CircleObstacle] = (), robots: Sequence[RobotSpec] = (EAST, NORTH),
        network: NetworkConfig = NetworkConfig(loss=0.1, late=0.1, delay=2.0)) -> FaultyRun:
    scenario = Scenario(PATH, PATH, tuple(robots), faults=faults, obstacles=tuple(obstacles), network=network)
    return drive_scenario(scenario, coordinate_scenario(scenario, GRID, planners=PLANNERS), GRID, planners=PLANNERS)


@pytest.mark.parametrize("name", NAMED)
def test_a_scenario_with_a_name_ends_as_it_says(name: str) -> None:
    scenario = load_scenario(ROOT / "config" / "scenarios" / name)
    grid = load_map(scenario.map_path)
    fleet = coordinate_scenario(scenario, grid)
    report = report_of(scenario, fleet, drive_scenario(scenario, fleet, grid))
    assert report.passed, report.failures


@pytest.mark.parametrize("kind", ["pause", "lost", "silent", "restart"])
def test_what_passes_costs_time_and_nothing_else(kind: str) -> None:
    faulty = run(Fault("gold", kind, 6.0, 12.0))
    assert faulty.verdict.passed, faulty.verdict.failures
    assert set(faulty.verdict.arrived) == {"gold", "green"}


def test_while_one_is_held_up_the_other_goes_first() -> None:
    scenario = Scenario(PATH, PATH, (EAST, NORTH), faults=(Fault("gold", "pause", 3.0, 40.0),))
    fleet = coordinate_scenario(scenario, GRID, planners=PLANNERS)
    assert fleet.windows[0].first == "gold"
    faulty = drive_scenario(scenario, fleet, GRID, planners=PLANNERS)
    late = faulty.verdict.arrivals["green"] - fleet["green"].arrival_time
    assert faulty.verdict.passed and late < 10.0 and "sequential: gold is" in faulty.decisions[0]


def test_a_dead_robot_is_led_round_and_waited_for_by_nobody() -> None:
    ahead = RobotSpec("blue", (4.0, 7.6, 0.0), (12.0, 9.0, 0.0), max_speed=0.3)
    faulty = run(Fault("blue", "dead", 5.0), robots=[EAST, NORTH, ahead])
    assert faulty.verdict.passed, faulty.verdict.failures
    assert set(faulty.verdict.arrived) == {"gold", "green"} and faulty.verdict.excused == ("blue",)


def test_a_robot_that_cannot_move_is_led_round_and_may_come_back() -> None:
    ahead = RobotSpec("blue", (4.0, 8.0, 0.0), (12.0, 9.0, 0.0), max_speed=0.3)
    faulty = run(Fault("blue", "pause", 5.0, 150.0), robots=[EAST, ahead])
    assert faulty.verdict.passed, faulty.verdict.failures
    assert faulty.verdict.arrivals["gold"] < 150.0 < faulty.verdict.arrivals["blue"]


def test_what_stands_in_the_way_is_waited_for_then_driven_round() -> None:
    faulty = run(obstacles=[CircleObstacle(*ON_ITS_WAY, 0.3)], robots=[EAST])
    assert faulty.verdict.passed, faulty.verdict.failures
    assert any("something in its way" in decision for decision in faulty.decisions)


def test_a_crossing_person_is_only_waited_for() -> None:
    faulty = run(obstacles=[CircleObstacle(*ON_ITS_WAY, 0.3, 1.0, 9.0)], robots=[EAST])
    assert faulty.verdict.passed and not faulty.decisions
    assert faulty.verdict.arrivals["gold"] > 24.0


def test_another_goal_on_the_way_and_one_that_joins_late() -> None:
    faulty = run(Fault("gold", "errand", 8.0, goal=(7.5, 13.0)), Fault("green", "join", 10.0))
    assert faulty.verdict.passed and set(faulty.verdict.arrived) == {"gold", "green"}
    assert np.hypot(*(faulty.recording.poses[-1, 0, :2] - (7.5, 13.0))) < 0.1


@pytest.mark.parametrize("kind", ["restart", "silent"])
def test_without_a_dispatcher_all_stand_and_with_one_they_go_on(kind: str) -> None:
    faulty = run(Fault("dispatcher", kind, 4.0, 15.0))
    assert faulty.verdict.passed, faulty.verdict.failures
    still = (faulty.recording.times > 13.5) & (faulty.recording.times < 18.5)
    assert np.ptp(faulty.recording.poses[still][:, :, :2], axis=0).max() < 1e-9


def test_a_jump_is_stopped_for_and_moves_no_progress() -> None:
    faulty = run(Fault("gold", "jump", 6.0, 6.0, distance=1.5, direction=0.0))
    assert faulty.verdict.passed, faulty.verdict.failures
    jumped = (faulty.recording.times > 7.5) & (faulty.recording.times < 12.0)
    assert np.ptp(faulty.recording.poses[jumped][:, 0, :2], axis=0).max() < 1e-9


@pytest.mark.parametrize("seed", range(6))
def test_blind_robots_on_a_terrible_network_never_touch(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """What keeps robots apart while schedules change is the protocol; the lidar comes on top."""
    monkeypatch.setattr(Agent, "_points", lambda *_: np.zeros((0, 2)))
    monkeypatch.setattr(Agent, "_look", lambda *_: None)
    scenario = random_faulty_scenario(GRID, 4, seed=seed, map_name=PATH, map_path=PATH)
    faults = tuple(fault for fault in scenario.faults if fault.kind != "join")  # it would be there before it is known
    scenario = replace(scenario, obstacles=(), faults=faults, network=replace(BAD, seed=seed))
    fleet = coordinate_scenario(scenario, GRID, planners=PLANNERS)
    assert drive_scenario(scenario, fleet, GRID, planners=PLANNERS).verdict.passed


def test_without_the_promise_that_network_lets_robots_touch(monkeypatch: pytest.MonkeyPatch) -> None:
    """The test above would notice: robots that hold to no promise, and wait for nobody's confirmation, do touch."""
    from social_fleet.execution.gate import PrecedenceGate
    from social_fleet.execution.recovery.member import Member
    monkeypatch.setattr(Agent, "_points", lambda *_: np.zeros((0, 2)))
    monkeypatch.setattr(Agent, "_look", lambda *_: None)
    follow, promise = PrecedenceGate.follow, Member._promise

    def heedless(gate: PrecedenceGate, schedule: Any) -> None:
        follow(gate, replace(schedule, peers=()))

    def broken(member: Member) -> None:
        promise(member)
        member.bound = np.inf

    monkeypatch.setattr(PrecedenceGate, "follow", heedless)
    monkeypatch.setattr(Member, "_promise", broken)
    contacts = 0
    for seed in range(12):
        scenario = random_faulty_scenario(GRID, 4, seed=seed, map_name=PATH, map_path=PATH)
        faults = tuple(fault for fault in scenario.faults if fault.kind != "join")
        scenario = replace(scenario, obstacles=(), faults=faults, network=replace(BAD, seed=seed))
        fleet = coordinate_scenario(scenario, GRID, planners=PLANNERS)
        contacts += len(drive_scenario(scenario, fleet, GRID, planners=PLANNERS).verdict.contacts)
    assert contacts


def test_the_same_seed_gives_the_same_run() -> None:
    first, second = (run(Fault("gold", "pause", 3.0, 20.0), network=BAD) for _ in range(2))
    assert np.array_equal(first.recording.poses, second.recording.poses) and first.decisions == second.decisions
