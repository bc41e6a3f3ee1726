"""One robot's search: rules, arrival windows, soft traffic, the stop; and the bins in which it looks for traffic."""

import numpy as np
import pytest
from worlds import grid_from_text

from social_fleet.coordination.baselines.fleet_planner import Traveller
from social_fleet.coordination.baselines.roadmap import Roadmap
from social_fleet.coordination.baselines.sipp import NO_RULES, Rules
from social_fleet.coordination.baselines.traffic import BEGIN, EDGE, END, NODE, WAIT, Traffic, bin_of, owned, traffic_of

GO = np.zeros(1, dtype=np.uint8)
LANE = grid_from_text("......")
WIDE = grid_from_text("......\n......\n......")
NOBODY = traffic_of([], extent=(6.0, 3.0), reach=1.5, radius=0.3)


def traveller(grid: object, *places: object, index: int = 0) -> Traveller:
    roadmap = Roadmap(grid, 0.3, 1, np.array(places, dtype=float))  # type: ignore[arg-type]
    start, goal = roadmap.terminals
    return Traveller(index, roadmap, int(start), int(goal), 1.0, 0.0)


def rules(edges: object = (), nodes: object = (), window: object = (-np.inf, np.inf)) -> Rules:
    forbidden = [np.array(rule, dtype=float).reshape(-1, 3) for rule in (edges, nodes)]
    return Rules(forbidden[0], forbidden[1], np.array(window, dtype=float))


def edge_between(robot: Traveller, tail: int, head: int) -> int:
    graph = robot.roadmap.graph
    return next(edge for edge in range(graph.first[tail], graph.first[tail + 1]) if graph.target[edge] == head)


ROBOT = traveller(LANE, (0.5, 0.5), (3.5, 0.5))


@pytest.mark.parametrize("rule, arrival", [
    (NO_RULES, 3.0),
    (rules(edges=[(edge_between(ROBOT, 1, 2), 0.5, 4.0)]), 6.0),  # waits until 4 s before the second move
    (rules(edges=[(edge_between(ROBOT, 1, 2), 1.5, 4.0)]), 3.0),  # has left by then
    (rules(nodes=[(2, 1.0, 2.5)]), 3.5),  # comes to node 2 when it may
    (rules(nodes=[(3, 3.0, 5.0)]), 5.0),
    (rules(nodes=[(3, 4.0, 5.0)]), 5.0),  # could not stay at its goal before
    (rules(window=(7.0, np.inf)), 7.0),
    (rules(window=(0.0, 3.5)), 3.0),
])
def test_it_arrives_as_early_as_its_rules_let_it(rule: Rules, arrival: float) -> None:
    motion = ROBOT.search(NOBODY, GO, rule)
    assert motion is not None and motion.arrival == pytest.approx(arrival)
    assert motion.pieces[0, BEGIN] == -np.inf and motion.pieces[-1, END] == np.inf
    assert motion.pieces[1:, BEGIN] == pytest.approx(motion.pieces[:-1, END])


@pytest.mark.parametrize("rule", [
    rules(window=(0.0, 2.9)),
    rules(nodes=[(0, -1.0, 1.0)]),  # it stands there
    rules(edges=[(edge_between(ROBOT, 1, 2), -np.inf, np.inf)]),
    rules(nodes=[(3, 5.0, np.inf)]),
])
def test_where_the_rules_leave_no_way_there_is_none(rule: Rules) -> None:
    assert ROBOT.search(NOBODY, GO, rule) is None


def test_it_stops_when_told_to() -> None:
    assert ROBOT.search(NOBODY, np.ones(1, dtype=np.uint8)) is None


def test_of_equally_early_ways_it_takes_one_that_touches_nobody() -> None:
    other = traveller(WIDE, (3.5, 1.5), (3.5, 1.5), index=1).search(NOBODY, GO)
    robot = traveller(WIDE, (0.5, 0.5), (5.5, 1.5))
    assert other is not None
    soft = traffic_of([owned(other, 1, hard=False)], extent=(6.0, 3.0), reach=1.5, radius=0.3)
    motion = robot.search(soft, GO)
    assert motion is not None and motion.arrival == pytest.approx(4.0 + np.sqrt(2.0))
    moves = motion.pieces[motion.pieces[:, EDGE] != WAIT]
    assert 9.0 not in moves[:, NODE]  # node 9 is where the other stands
    straight = traveller(WIDE, (0.5, 1.5), (5.5, 1.5)).search(soft, GO)
    assert straight is not None and straight.arrival == pytest.approx(5.0)  # contacts count only among equals


def test_a_bin_holds_every_piece_that_a_move_from_it_can_meet() -> None:
    rng = np.random.RandomState(2)
    pieces = np.zeros((200, 11))
    pieces[:, BEGIN], pieces[:, END] = 0.0, rng.uniform(0.1, 4.0, 200)
    pieces[:, 2:4], pieces[:, 4:6] = rng.uniform(-1.0, 31.0, (200, 2)), rng.uniform(-1.0, 1.0, (200, 2))
    pieces[:, 8] = rng.uniform(0.1, 0.5, 200)
    traffic: Traffic = traffic_of([pieces], extent=(30.0, 30.0), reach=1.2, radius=0.4)
    for point in rng.uniform(0.0, 30.0, (100, 2)):
        place = bin_of(traffic.frame, *point)
        held = set(traffic.items[traffic.first[place]:traffic.first[place + 1]].tolist())
        for share in np.linspace(0.0, 1.0, 11):
            gaps = np.hypot(*(pieces[:, 2:4] + share * pieces[:, END, None] * pieces[:, 4:6] - point).T)
            assert set(np.flatnonzero(gaps < 1.2 + 0.4 + pieces[:, 8]).tolist()) <= held
