"""What both planners of fleets keep to, on worlds that a reader checks by hand; `verify` judges every schedule."""

import math
from typing import Any, List, Type

import numpy as np
import pytest
from fleets import robot
from worlds import grid_from_text

from social_fleet.coordination.baselines.conflict_based import ConflictBasedSearch
from social_fleet.coordination.baselines.fleet_planner import FleetPlanner
from social_fleet.coordination.baselines.prioritized import PrioritizedPlanner
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.coordination.verification import verify
from social_fleet.errors import InvalidGoal, InvalidParameter, InvalidScenario, InvalidStart, NoPath, TimedOut
from social_fleet.mapping.clearance import ConfigurationSpace
from social_fleet.mapping.grid import OccupancyGrid

PLANNERS = (ConflictBasedSearch, PrioritizedPlanner)
LANE = grid_from_text("#######\n.......\n#######")
CROSS = grid_from_text("""
    ##.##
    ##.##
    .....
    ##.##
    ##.##
""")
RING = grid_from_text(".....\n.###.\n.###.\n.....")
ROOM = grid_from_text("\n".join(["." * 8] * 8))


def planned(kind: Type[FleetPlanner], grid: OccupancyGrid, fleet: List[Robot], **options: Any) -> FleetSchedule:
    """A schedule that has stood every test: no contact, no wall, right ends, no faster than allowed."""
    schedule = kind(**{"coarsening": 1, **options}).plan(grid, fleet)
    assert verify(schedule).safe
    for one, given in zip(schedule.schedules, fleet):
        path = one.robot.path
        assert one.name == given.name and one.robot.body_radius == given.body_radius
        assert ConfigurationSpace(grid, given.body_radius).is_free_path(path)
        assert path.points[0] == pytest.approx(given.path.points[0])
        assert path.points[-1] == pytest.approx(given.path.points[-1])
        assert one.arc_lengths[[0, -1]] == pytest.approx([0.0, path.length])
        assert (np.diff(one.arc_lengths) <= given.max_speed * np.diff(one.times) + 1e-9).all()
        assert one.times[0] >= given.depart
    assert schedule.objective == pytest.approx(schedule.sum_of_completion)
    return schedule


@pytest.mark.parametrize("kind", PLANNERS)
def test_alone_it_takes_the_shortest_way_at_full_speed(kind: Type[FleetPlanner]) -> None:
    fleet = planned(kind, ROOM, [robot("a", (0.5, 0.5), (6.5, 3.5), max_speed=0.5)])
    assert fleet["a"].arrival_time == pytest.approx((3.0 + 3.0 * math.sqrt(2.0)) / 0.5)
    assert fleet.gap == pytest.approx(0.0, abs=1e-9) and fleet.formulation == kind.name


@pytest.mark.parametrize("kind", PLANNERS)
def test_at_a_crossing_one_waits_for_as_long_as_it_must(kind: Type[FleetPlanner]) -> None:
    crossing = [robot("a", (0.5, 2.5), (4.5, 2.5), max_speed=1.0, radius=0.35),
                robot("b", (2.5, 0.5), (2.5, 4.5), max_speed=1.0, radius=0.35)]
    fleet = planned(kind, CROSS, crossing)
    # Two that cross at right angles, t apart, come within t / sqrt(2) of each other.
    assert fleet.sum_of_completion == pytest.approx(8.0 + 0.7 * math.sqrt(2.0), abs=1e-4)


@pytest.mark.parametrize("kind", PLANNERS)
def test_the_sizes_of_both_count(kind: Type[FleetPlanner]) -> None:
    crossing = [robot("a", (0.5, 2.5), (4.5, 2.5), max_speed=1.0, radius=0.1),
                robot("b", (2.5, 0.5), (2.5, 4.5), max_speed=1.0, radius=0.45)]
    assert planned(kind, CROSS, crossing).sum_of_completion == pytest.approx(8.0 + 0.55 * math.sqrt(2.0), abs=1e-4)


@pytest.mark.parametrize("kind", PLANNERS)
def test_the_speeds_of_both_count(kind: Type[FleetPlanner]) -> None:
    # In one lane, the fast one has to stay behind: it arrives when the slow one is clear of its goal.
    lane = [robot("slow", (1.5, 1.5), (6.5, 1.5), max_speed=0.5, radius=0.25),
            robot("fast", (0.5, 1.5), (5.5, 1.5), max_speed=1.0, radius=0.25)]
    fleet = planned(kind, LANE, lane)
    assert fleet["slow"].arrival_time == pytest.approx(10.0)
    assert 8.0 < fleet["fast"].arrival_time < 10.1


@pytest.mark.parametrize("kind", PLANNERS)
def test_nobody_drives_over_one_that_is_parked(kind: Type[FleetPlanner]) -> None:
    # b is at its goal long before a comes by: a goes round the other side of the ring.
    fleet = planned(kind, RING, [robot("a", (0.5, 0.5), (4.5, 0.5), max_speed=1.0, radius=0.3),
                                 robot("b", (2.5, 3.5), (2.5, 0.5), max_speed=4.0, radius=0.3)])
    assert fleet["a"].arrival_time == pytest.approx(10.0) or fleet["b"].arrival_time > 2.0
    assert fleet.sum_of_completion < 12.5


@pytest.mark.parametrize("kind", PLANNERS)
def test_one_that_departs_later_stands_at_its_start_till_then(kind: Type[FleetPlanner]) -> None:
    lane = [robot("a", (0.5, 1.5), (5.5, 1.5), max_speed=1.0, radius=0.3),
            robot("b", (3.5, 1.5), (6.5, 1.5), max_speed=1.0, radius=0.3, depart=20.0)]
    fleet = planned(kind, LANE, lane)
    assert fleet["b"].times[0] == pytest.approx(20.0) and fleet["b"].arrival_time == pytest.approx(23.0)
    assert fleet["a"].arrival_time > 21.0


@pytest.mark.parametrize("kind", PLANNERS)
def test_one_that_is_at_its_goal_makes_way_and_comes_back(kind: Type[FleetPlanner]) -> None:
    bay = grid_from_text("...\n#.#")
    fleet = planned(kind, bay, [robot("a", (0.5, 1.5), (2.5, 1.5), max_speed=1.0, radius=0.3),
                                robot("b", (1.5, 1.5), (1.5, 1.5), max_speed=1.0, radius=0.3)])
    assert fleet["a"].arrival_time < 3.5 and fleet["b"].robot.path.length == pytest.approx(2.0)


@pytest.mark.parametrize("kind", PLANNERS)
def test_one_that_stays_has_arrived_when_it_departs(kind: Type[FleetPlanner]) -> None:
    fleet = planned(kind, ROOM, [robot("a", (0.5, 0.5), (0.5, 0.5), depart=3.0)])
    assert fleet["a"].times.tolist() == [3.0] and fleet["a"].arrival_time == 3.0


@pytest.mark.parametrize("kind", PLANNERS)
def test_starts_and_goals_beside_the_centres_are_kept(kind: Type[FleetPlanner]) -> None:
    fleet = [robot("a", (0.6, 0.7), (7.3, 6.6), max_speed=0.7, radius=0.3),
             robot("b", (7.3, 6.4), (0.4, 0.9), max_speed=0.7, radius=0.3)]
    schedule = planned(kind, ROOM, fleet, coarsening=2)
    assert schedule["a"].robot.path.length < 1.1 * math.hypot(6.7, 5.9)


@pytest.mark.parametrize("kind", PLANNERS)
@pytest.mark.parametrize("seed", range(6))
def test_random_fleets_in_a_room_never_touch(kind: Type[FleetPlanner], seed: int) -> None:
    rng = np.random.RandomState(seed)
    places = [grid_cell for grid_cell in np.ndindex(8, 8)]
    starts, goals = rng.permutation(len(places))[:6], rng.permutation(len(places))[:6]
    fleet = [robot(f"r{index}", np.array(places[start]) + 0.5, np.array(places[goal]) + 0.5,
                   max_speed=rng.uniform(0.3, 1.0), radius=rng.uniform(0.15, 0.45), depart=rng.choice([0.0, 2.0]))
             for index, (start, goal) in enumerate(zip(starts, goals))]
    planned(kind, ROOM, fleet)


@pytest.mark.parametrize("kind", PLANNERS)
def test_the_same_fleet_gets_the_same_schedule(kind: Type[FleetPlanner]) -> None:
    fleet = [robot("a", (0.5, 0.5), (6.5, 5.5)), robot("b", (6.5, 5.5), (0.5, 0.5)), robot("c", (0.5, 6.5), (7.5, 0.5))]
    one, two = (planned(kind, ROOM, fleet) for _ in range(2))
    for first, second in zip(one.schedules, two.schedules):
        assert np.array_equal(first.times, second.times)
        assert np.array_equal(first.robot.path.points, second.robot.path.points)


def test_a_time_limit_ends_a_search_that_has_no_end() -> None:
    swap = [robot("a", (0.5, 1.5), (6.5, 1.5)), robot("b", (6.5, 1.5), (0.5, 1.5))]
    with pytest.raises(TimedOut, match="conflict-based search of 2 robots found no schedule within 0.5 s"):
        ConflictBasedSearch(coarsening=1).plan(LANE, swap, time_limit=0.5)


@pytest.mark.parametrize("kind", PLANNERS)
@pytest.mark.parametrize("fleet, error, message", [
    ([], InvalidScenario, "no robot"),
    ([robot("a", (0.5, 1.5)), robot("a", (3.5, 1.5))], InvalidScenario, "two robots are named a"),
    ([robot("a", (0.5, 1.5), (5.5, 1.5)), robot("b", (0.8, 1.5), (3.5, 1.5))], InvalidScenario,
     "a and b have starts 0.30 m apart"),
    ([robot("a", (0.5, 1.5), (5.5, 1.5)), robot("b", (3.5, 1.5), (5.2, 1.5))], InvalidScenario,
     "a and b have goals 0.30 m apart"),
    ([robot("a", (0.5, 0.5), (5.5, 1.5))], InvalidStart, r"robot a: \(0.50, 0.50\) lies in a wall"),
    ([robot("a", (0.5, 1.5), (50.0, 1.5))], InvalidGoal, r"robot a: \(50.00, 1.50\) is off the map"),
    ([robot("a", (0.5, 1.5), (5.5, 1.5), radius=0.6)], InvalidStart, "robot a"),
])
def test_fleets_that_cannot_be_are_refused(kind: Type[FleetPlanner], fleet: List[Robot], error: Type[Exception],
                                           message: str) -> None:
    with pytest.raises(error, match=message):
        kind(coarsening=1).plan(LANE, fleet)


@pytest.mark.parametrize("kind", PLANNERS)
def test_where_no_way_leads_it_says_so(kind: Type[FleetPlanner]) -> None:
    with pytest.raises(NoPath, match="robot a: no way for a disc of radius 0.25 m"):
        kind(coarsening=1).plan(grid_from_text("..#.."), [robot("a", (0.5, 0.5), (4.5, 0.5))])


@pytest.mark.parametrize("make, message", [
    (lambda: ConflictBasedSearch(coarsening=0), "coarsening: must be a whole number from 1 on, not 0"),
    (lambda: PrioritizedPlanner(coarsening=True), "coarsening"),
    (lambda: PrioritizedPlanner(restarts=-1), "restarts: must be a whole number from 0 on, not -1"),
    (lambda: ConflictBasedSearch(suboptimality=0.9), "suboptimality: must be a number from 1 on, not 0.9"),
    (lambda: PrioritizedPlanner().plan(ROOM, [robot("a", (1.0, 1.0))], time_limit=0.0), "time_limit"),
])
def test_options_out_of_range_are_refused(make: Any, message: str) -> None:
    with pytest.raises(InvalidParameter, match=message):
        make()
