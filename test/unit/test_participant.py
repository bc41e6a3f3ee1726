"""Fleets without a coordinator: all find what one coordinator finds, whatever becomes of their messages."""

from dataclasses import replace
from typing import Any, Dict, List, Tuple

import pytest
from fleets import robot, street_fleet
from sharing import participants, round_of
from worlds import grid_from_text

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.encounters import EncounterFinder
from social_fleet.coordination.replanning import PlannerReplanner
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import FleetSchedule, Schedule
from social_fleet.coordination.verification import verify
from social_fleet.errors import Disagreement, Infeasible, InvalidParameter, InvalidScenario, SilentRobot
from social_fleet.fleet.encoding import encode, schedule_digest
from social_fleet.fleet.in_process import InProcessNetwork, run_together
from social_fleet.fleet.messages import Announcement, Findings, PairWindows, Verdict, digest
from social_fleet.fleet.participant import Participant
from social_fleet.planning.planner import SocialPlanner

CROSSING = [robot("a", (-4, 0), (4, 0)), robot("b", (0, -4), (0, 4)), robot("c", (-4, 1.5), (4, 1.5))]


def scenario(planning: int, fixed: int) -> Tuple[List[Robot], List[Schedule]]:
    """Robots to plan, and schedules of others that are under way: half a street fleet moves before the rest comes."""
    fleet = street_fleet(planning + fixed, 6)
    moving = coordinate(fleet[:fixed], version=1).schedules if fixed else ()
    return fleet[fixed:], list(moving)


SCENARIOS = {"simultaneous, odd": scenario(5, 0), "simultaneous, even": scenario(6, 0),
             "sequential": scenario(1, 4), "unified": scenario(3, 2), "alone": scenario(1, 0)}


def centralized(robots: List[Robot], fixed: List[Schedule], **options: Any) -> FleetSchedule:
    return coordinate(robots, fixed=fixed, mode="unified" if fixed else "simultaneous", **options)


def plain(fleet: FleetSchedule) -> Any:
    """All of a schedule that matters, as values that compare bit by bit."""
    def parts(schedules: Any) -> Dict[str, Any]:
        return {schedule.name: (schedule.robot.path.points.tobytes(), schedule.arc_lengths.tobytes(),
                                schedule.times.tobytes(), schedule.precedences, schedule.version)
                for schedule in schedules}
    return parts(fleet.schedules), parts(fleet.amended), fleet.windows, fleet.objective, fleet.gap


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("name", list(SCENARIOS))
def test_whatever_the_order_of_messages_all_find_the_centralized_schedule(name: str, seed: int) -> None:
    robots, fixed = SCENARIOS[name]
    found = run_together(participants(robots, fixed, network=InProcessNetwork(seed)))
    expected = plain(centralized(robots, fixed))
    assert sorted(found) == sorted(own.name for own in [*robots, *fixed])
    assert all(plain(fleet) == expected for fleet in found.values())


@pytest.mark.parametrize("seed", range(6))
def test_messages_that_get_lost_or_come_twice_change_nothing(seed: int) -> None:
    robots, fixed = SCENARIOS["unified"]
    network = InProcessNetwork(seed, losses=0.4, duplicates=0.3)
    found = run_together(participants(robots, fixed, network=network, limit=20.0))
    assert {schedule_digest(fleet) for fleet in found.values()} == {schedule_digest(centralized(robots, fixed))}


def test_one_after_the_other_is_the_sequential_mode() -> None:
    fleet = street_fleet(4, 3)
    moving: Dict[str, Schedule] = {}
    for new in fleet:
        fixed = [moving[name] for name in sorted(moving)]
        found = run_together(participants([new], fixed))[new.name]
        moving.update({schedule.name: schedule for schedule in (*found.schedules, *found.amended)})
    whole = coordinate(fleet, mode="sequential")
    assert schedule_digest(FleetSchedule(tuple(moving.values()))) == schedule_digest(FleetSchedule(whole.schedules))
    assert verify(FleetSchedule(tuple(moving.values()))).safe


def test_who_joins_late_is_told_again() -> None:
    network, round_ = InProcessNetwork(), round_of(CROSSING)
    early = [Participant(body, round_, network.join()) for body in CROSSING[:2]]
    for participant in early:
        assert participant.poll(0.0) is None
    late = Participant(CROSSING[2], round_, network.join())
    found = run_together([*early, late], start=2.0)
    assert {schedule_digest(fleet) for fleet in found.values()} == {schedule_digest(coordinate(CROSSING))}


def test_a_robot_without_a_path_is_named_in_time() -> None:
    first, second, _ = participants(CROSSING, limit=3.0)
    for now in (0.0, 1.0, 2.9):
        assert first.poll(now) is None and second.poll(now) is None
    for _ in range(2):
        with pytest.raises(SilentRobot, match="robot a has heard no path from c within the limit") as caught:
            first.poll(3.0)
        assert caught.value.robots == ("c",)


def test_a_robot_that_is_lost_after_its_path_is_named() -> None:
    first, second, lost = participants(CROSSING, limit=3.0)
    lost.poll(0.0)
    with pytest.raises(SilentRobot, match="no more than a path from c") as caught:
        run_together([first, second])
    assert caught.value.robots == ("c",)


class Deaf(Participant):
    """One that tells its path and repeats it, but never gets to search, nor any further."""

    def _search_own(self, now: float) -> None:
        pass


def test_what_a_slow_robot_does_not_search_the_others_do() -> None:
    network, round_ = InProcessNetwork(), round_of(CROSSING)
    quick = [Participant(body, round_, network.join(), limit=2.0, time_limit=3.0) for body in CROSSING[:2]]
    slow = Deaf(CROSSING[2], round_, network.join(), limit=2.0)
    for now in range(4):
        assert [body.poll(float(now)) for body in (*quick, slow)] == [None] * 3
    assert [body.searched_for for body in quick] == [("c",), ("c",)]
    network.send(2, encode(Verdict(round_.key, "c", schedule_digest(coordinate(CROSSING)))))
    assert all(schedule_digest(body.poll(4.0)) == schedule_digest(coordinate(CROSSING)) for body in quick)


def test_who_does_not_confirm_is_named_and_nobody_drives() -> None:
    network, round_ = InProcessNetwork(), round_of(CROSSING)
    quick = [Participant(body, round_, network.join(), limit=2.0, time_limit=3.0) for body in CROSSING[:2]]
    slow = Deaf(CROSSING[2], round_, network.join(), limit=2.0)
    with pytest.raises(SilentRobot, match="no verdict from c"):
        run_together([*quick, slow])


def test_each_pair_is_searched_once_by_whose_share_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    searched: List[Tuple[str, str]] = []
    between = EncounterFinder.between

    def counted(self: EncounterFinder, r: Robot, s: Robot) -> Any:
        if (r.name, s.name) not in self._known:
            searched.append((r.name, s.name))
        return between(self, r, s)
    monkeypatch.setattr(EncounterFinder, "between", counted)
    robots, fixed = SCENARIOS["unified"]
    run_together(participants(robots, fixed))
    assert len(searched) == len(set(searched)) == 3 + 3 * 2


def test_no_schedule_is_no_schedule_for_all() -> None:
    blocked = [robot("a", (0, 0), (9, 0)), robot("b", (9.0, 0.0), (0.0, 0.0))]
    with pytest.raises(Infeasible) as central:
        coordinate(blocked)
    reasons: Dict[str, str] = {}
    everyone = participants(blocked, network=InProcessNetwork(4))
    for step in range(100):
        for participant in everyone:
            try:
                assert participant.poll(0.05 * step) is None
            except Infeasible as error:
                reasons[participant.name] = str(error)
    assert reasons == {body.name: str(central.value) for body in blocked}


def hall() -> PlannerReplanner:
    """Replans in a hall of 20 m by 5 m."""
    planner = SocialPlanner(grid_from_text("\n".join(["#" * 88, *["#" + "." * 86 + "#"] * 26, "#" * 88]), 0.25))
    return PlannerReplanner(lambda radius: planner)


IN_THE_WAY = [robot("mover", (2, 3), (18, 3)), robot("parked", (10, 3)), robot("passer", (18, 5), (2, 5))]


def test_all_repair_alike() -> None:
    replanner = hall()
    whole = coordinate(IN_THE_WAY, replanner=replanner)
    assert "mover drives round" in whole.message
    found = run_together(participants(IN_THE_WAY, network=InProcessNetwork(1), replanner=replanner))
    assert {schedule_digest(fleet) for fleet in found.values()} == {schedule_digest(whole)}
    assert {fleet.message for fleet in found.values()} == {whole.message}


def test_a_robot_that_cannot_repair_is_found_out() -> None:
    network, round_ = InProcessNetwork(), round_of(IN_THE_WAY[:2])
    able = Participant(IN_THE_WAY[0], round_, network.join(), replanner=hall())
    unable = Participant(IN_THE_WAY[1], round_, network.join())
    assert able.poll(0.0) is None and unable.poll(0.0) is None and able.poll(0.1) is None
    with pytest.raises(Infeasible):
        unable.poll(0.1)
    with pytest.raises(Disagreement, match="robot parked has no schedule: no schedule on these paths") as caught:
        able.poll(0.2)
    assert caught.value.robots == ("parked",)


def heard_by_first(message: Any) -> Participant:
    """The first of the crossing's robots, on its way to which are the others' paths and windows, and `message`."""
    network = InProcessNetwork()
    first, *others = participants(CROSSING, network=network)
    first.poll(0.0)
    for participant in others * 2:
        participant.poll(0.0)
    network.send(1, encode(message(first._key)))
    return first


@pytest.mark.parametrize("message, complaint, names", [
    (lambda key: Announcement(key, CROSSING[0]), None, ()),
    (lambda key: Announcement(key, replace(CROSSING[0], depart=1.0)), "another robot goes by the name of a", ("a",)),
    (lambda key: Announcement(key, replace(CROSSING[1], depart=1.0)), "robot b announced two different", ("b",)),
    (lambda key: Announcement("another round", replace(CROSSING[1], depart=1.0)), None, ()),
    (lambda key: Announcement(key, robot("stranger", (0, 0), (1, 0))), None, ()),
    (lambda key: Verdict(key, "b", "0" * 32), "robots a and b found different schedules", ("a", "b")),
    (lambda key: Verdict(key, "b", "", "timed out"), "robot b has no schedule: timed out", ("b",))])
def test_what_does_not_fit_is_said_or_left(message: Any, complaint: Any, names: Any) -> None:
    first = heard_by_first(message)
    if complaint is None:
        assert first.poll(0.1) is None
        return
    with pytest.raises(Disagreement, match=complaint) as caught:
        first.poll(0.1)
    assert caught.value.robots == names


def test_noise_is_refused_and_does_no_harm(caplog: pytest.LogCaptureFixture) -> None:
    network = InProcessNetwork()
    everyone = participants(CROSSING, network=network)
    noise = network.join()
    noise.send(b"hello")
    noise.send(encode(Announcement("key", CROSSING[0]))[:-3])
    found = run_together(everyone)
    assert {schedule_digest(fleet) for fleet in found.values()} == {schedule_digest(coordinate(CROSSING))}
    assert "is none of social_fleet's" in caplog.text or "is cut short" in caplog.text


def test_windows_of_another_path_are_not_believed() -> None:
    first, *others = participants(CROSSING)
    other = EncounterFinder(0.1).between(CROSSING[1], replace(CROSSING[2], plan=CROSSING[2].path.points - (0.0, 1.0)))
    first.poll(0.0)
    paths = {body.name: digest(encode(Announcement(first._key, body))) for body in CROSSING}
    wrong = PairWindows("b", "c", paths["b"], "of another path", other)
    first._take(Findings(first._key, "b", (wrong,)), b"")
    found = run_together([first, *others])
    assert {schedule_digest(fleet) for fleet in found.values()} == {schedule_digest(coordinate(CROSSING))}


def test_who_has_no_part_is_refused() -> None:
    round_ = round_of(CROSSING)
    with pytest.raises(InvalidScenario, match="robot d is none of the round's robots: a, b, c"):
        Participant(robot("d", (0, 0), (1, 0)), round_, InProcessNetwork().join())
    with pytest.raises(InvalidScenario, match="fixed: robot a is none"):
        Participant(coordinate(CROSSING)["a"], round_, InProcessNetwork().join())
    for name in ("limit", "repeat", "time_limit"):
        with pytest.raises(InvalidParameter, match=f"{name}: must be positive and finite"):
            Participant(CROSSING[0], round_, InProcessNetwork().join(), **{name: float("inf")})
