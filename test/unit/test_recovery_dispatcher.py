"""The dispatcher: when it opens an exchange, what it waits for, and what it keeps saying."""

from dataclasses import replace
from typing import Dict, List, Optional

import numpy as np
import pytest
from driving import schedule_of
from worlds import grid_from_text

from social_fleet.coordination.schedule import Precedence, Schedule
from social_fleet.execution.recovery.config import RecoveryConfig
from social_fleet.execution.recovery.dispatcher import Dispatcher
from social_fleet.execution.recovery.messages import Directive, Errand, Report
from social_fleet.execution.recovery.replanning import Options, Replanning
from social_fleet.execution.state import ProgressState
from social_fleet.geometry import Pose
from social_fleet.planning.config import PlannerConfig
from social_fleet.planning.overlays.shapes import DiscObstacle
from social_fleet.planning.planner import SocialPlanner

HALL = grid_from_text("\n".join(["#" * 64, *["#" + "." * 62 + "#"] * 30, "#" * 64]), 0.25)
PLANNER = SocialPlanner(HALL, PlannerConfig())
CONFIG = RecoveryConfig()
GOALS = {"gold": (14.0, 2.0), "green": (14.0, 5.0)}


def schedule(name: str, y: float, *, precedences: tuple = ()) -> Schedule:
    plain = schedule_of([(1.0, y), (14.0, y)], name=name, precedences=precedences)
    others = tuple(other for other in GOALS if other != name)
    return replace(plain, version=1, peers=others)


SCHEDULES = {"gold": schedule("gold", 2.0), "green": schedule("green", 5.0, precedences=(
    Precedence(6.0, "gold", 7.0, 1),))}


class Fleet:
    """Reports as the test wants them, and a dispatcher that hears them."""

    def __init__(self) -> None:
        self.dispatcher = Dispatcher(Replanning(lambda radius: PLANNER, Options(time_limit=600.0)), CONFIG)
        self.reports: Dict[str, Report] = {
            name: Report(name, 0, 0.0, version=1, state=ProgressState.DRIVING, pose=Pose(1.0, y),
                         schedule=SCHEDULES[name],
                         errand=Errand(1, GOALS[name]), serving=1) for name, y in (("gold", 2.0), ("green", 5.0))}
        self.now = 0.0
        self.said: List[Directive] = []

    def pass_time(self, seconds: float, *, silent: tuple = (), **changes: dict) -> Optional[Directive]:
        """Let robots drive by their schedules but for `changes`, by name; the last directive."""
        for name, change in changes.items():
            self.reports[name] = replace(self.reports[name], **change)
        for _ in range(int(round(seconds / 0.1))):
            self.now = round(self.now + 0.1, 6)
            for name, report in self.reports.items():
                if name in silent:
                    continue
                own = report.schedule
                if "arc_length" not in changes.get(name, {}) and own is not None:
                    arc = min(float(own.arc_length(self.now)), report.bound)
                    x, y = own.robot.path.position(arc)
                    report = replace(report, arc_length=arc, pose=Pose(float(x), float(y)))
                self.reports[name] = replace(report, stamp=self.now)
                self.dispatcher.hear(self.reports[name])
            directive = self.dispatcher.step(self.now)
            if directive is not None:
                self.said.append(directive)
        return self.said[-1] if self.said else None

    def promise(self, name: str, ahead: float = 0.5) -> dict:
        report = self.reports[name]
        return {"exchange": self.said[-1].exchange, "bound": report.arc_length + ahead}


def test_all_is_well_and_nothing_is_asked_for() -> None:
    fleet = Fleet()
    last = fleet.pass_time(5.0)
    assert last is not None and last.exchange == 0 and not last.assignments and not fleet.dispatcher.decisions
    assert last.heard == {"gold": pytest.approx(last.stamp), "green": pytest.approx(last.stamp)}
    assert 8 <= len(fleet.said) <= 12


def test_a_new_goal_opens_an_exchange_that_waits_for_all_promises() -> None:
    fleet = Fleet()
    fleet.pass_time(2.0)
    asked = fleet.pass_time(3.0, gold={"errand": Errand(2, (14.0, 6.5))})
    assert asked is not None and asked.exchange == 2 and not asked.assignments
    asked = fleet.pass_time(3.0, gold=fleet.promise("gold"))
    assert asked is not None and not asked.assignments
    given = fleet.pass_time(0.5, green=fleet.promise("green"))
    assert given is not None and set(given.assignments) == {"gold", "green"}
    gold, green = given.assignments["gold"], given.assignments["green"]
    assert gold.errand == 2 and np.allclose(gold.schedule.robot.path.points[-1], (14.0, 6.5))
    assert gold.schedule.version == green.schedule.version == 2 and gold.schedule.peers == ("green",)
    report = fleet.reports["gold"]
    assert gold.origin == pytest.approx(report.arc_length) and gold.schedule.robot.committed == pytest.approx(
        report.bound - report.arc_length)
    assert np.allclose(green.schedule.robot.path.points[-1], GOALS["green"])


def test_without_its_goal_a_robot_stays_where_it_can_stop() -> None:
    fleet = Fleet()
    fleet.pass_time(2.0)
    fleet.pass_time(1.0, gold={"errand": None})
    given = fleet.pass_time(1.0, gold=fleet.promise("gold"), green=fleet.promise("green"))
    assert given is not None and fleet.dispatcher.decisions == ["sequential: gold has no goal any more"]
    gold = given.assignments["gold"]
    assert gold.errand == 0 and gold.schedule.robot.path.length == pytest.approx(gold.schedule.robot.committed)
    confirmed = {"version": 2, "schedule": gold.schedule, "serving": 0, "bound": np.inf, "exchange": 2}
    fleet.pass_time(3.0, gold=confirmed, green={"version": 2, "schedule": given.assignments["green"].schedule,
                                                "bound": np.inf})
    assert len(fleet.dispatcher.decisions) == 1


def test_assignments_are_said_until_they_are_confirmed() -> None:
    fleet = Fleet()
    fleet.pass_time(2.0)
    fleet.pass_time(1.0, gold={"errand": Errand(2, (14.0, 6.5))})
    given = fleet.pass_time(3.0, gold=fleet.promise("gold"), green=fleet.promise("green"))
    assert given is not None
    taken = given.assignments["gold"]
    left = fleet.pass_time(1.0, gold={"version": 2, "schedule": taken.schedule, "serving": 2, "bound": np.inf})
    assert left is not None and set(left.assignments) == {"green"} and len(fleet.dispatcher.decisions) == 1
    left = fleet.pass_time(1.0, green={"version": 2, "schedule": given.assignments["green"].schedule, "bound": np.inf})
    assert left is not None and not left.assignments


def test_one_that_started_anew_gets_a_schedule_of_its_session() -> None:
    fleet = Fleet()
    fleet.pass_time(2.0)
    fleet.pass_time(3.0, gold={"session": 7, "version": 0, "schedule": None, "serving": 0, "speed": 0.0})
    given = fleet.pass_time(1.0, gold=fleet.promise("gold"), green=fleet.promise("green"))
    assert given is not None and given.assignments["gold"].session == 7 and given.assignments["gold"].origin == 0.0
    assert fleet.dispatcher.decisions == ["sequential: gold has no schedule"]


def test_a_silent_robot_is_left_out_and_where_it_may_be_is_said() -> None:
    fleet = Fleet()
    fleet.pass_time(4.0)
    fleet.pass_time(CONFIG.gone + 1.0, silent=("gold",))
    given = fleet.pass_time(1.0, silent=("gold",), green=fleet.promise("green"))
    assert given is not None and set(given.assignments) == {"green"}
    assert given.assignments["green"].schedule.peers == () and not given.assignments["green"].schedule.precedences
    places = [shape for name, shape in given.obstacles.items() if name.startswith("gold#")]
    assert max(shape.x for shape in places) > fleet.reports["gold"].arc_length + 1.0 + CONFIG.lapse * 0.7 - 0.5


def test_a_late_robot_is_fitted_in_anew_with_hysteresis() -> None:
    fleet = Fleet()
    fleet.pass_time(4.0)
    stuck = {"arc_length": fleet.reports["gold"].arc_length}
    fleet.pass_time(4.0, gold=stuck)
    assert not fleet.dispatcher.decisions
    fleet.pass_time(3.0, gold=stuck)
    assert fleet.dispatcher.decisions == ["sequential: gold is 5 s late, green would wait"]
    given = fleet.pass_time(1.0, gold={**stuck, **fleet.promise("gold", 0.0)}, green=fleet.promise("green"))
    assert given is not None and given.assignments["gold"].schedule.times[0] > fleet.now  # it is not expected at once


def test_started_anew_the_dispatcher_waits_for_who_may_still_drive() -> None:
    fleet = Fleet()
    errand = {"errand": Errand(2, (14.0, 6.5))}
    fleet.pass_time(CONFIG.gone - 1.0, silent=("green",), gold=errand)
    assert not fleet.dispatcher.decisions
    fleet.pass_time(2.0, silent=("green",))
    assert fleet.dispatcher.decisions == ["sequential: gold has a new goal"]


def test_numbers_grow_beyond_all_that_was_ever_said() -> None:
    fleet = Fleet()
    asked = fleet.pass_time(3.0, gold={"errand": Errand(2, (14.0, 6.5))}, green={"exchange": 41})
    assert asked is not None and asked.exchange == 42


def test_a_number_that_an_ended_dispatcher_has_used_is_left_to_it() -> None:
    fleet = Fleet()
    fleet.pass_time(3.0, gold={"errand": Errand(2, (14.0, 6.5))})
    asked = fleet.pass_time(1.0, green={"version": 2})
    assert asked is not None and asked.exchange == 3 and not asked.assignments
    asked = fleet.pass_time(1.0, gold={**fleet.promise("gold"), "promised_to": 9}, green=fleet.promise("green"))
    assert asked is not None and not asked.assignments


def test_older_reports_are_passed_over() -> None:
    fleet = Fleet()
    fleet.pass_time(3.0)
    fleet.dispatcher.hear(replace(fleet.reports["gold"], stamp=1.0, errand=Errand(9, (5.0, 5.0))))
    fleet.dispatcher.hear(replace(fleet.reports["gold"], session=-1, stamp=99.0, errand=Errand(9, (5.0, 5.0))))
    fleet.pass_time(2.0)
    assert not fleet.dispatcher.decisions


def test_an_obstacle_is_driven_round_after_a_while_and_said_to_all() -> None:
    fleet = Fleet()
    fleet.pass_time(4.0)
    x = fleet.reports["gold"].arc_length + 1.0
    held = {"arc_length": x - 1.0, "blocked": 5.0, "obstacles": {"gold/1": DiscObstacle(x + 0.8, 2.0, 0.3)}}
    assert fleet.pass_time(1.0, gold=held).obstacles == held["obstacles"]  # type: ignore[union-attr]
    assert not fleet.dispatcher.decisions
    held = {**held, "blocked": CONFIG.obstacle_patience}
    fleet.pass_time(1.0, gold=held)
    given = fleet.pass_time(1.0, gold={**held, **fleet.promise("gold", 0.0)}, green=fleet.promise("green"))
    assert given is not None and given.assignments["gold"].temporary
    points = given.assignments["gold"].schedule.robot.path.position(np.linspace(0.0, 13.0, 200))
    assert np.hypot(points[:, 0] - x - 0.8, points[:, 1] - 2.0).min() > 0.55
    gone = fleet.pass_time(1.0, green={"cleared": ("gold/1",)})
    assert gone is not None and not gone.obstacles


def test_where_no_schedule_is_found_the_former_ones_stay_in_force(monkeypatch: pytest.MonkeyPatch) -> None:
    from social_fleet.errors import TimedOut
    from social_fleet.execution.recovery import replanning

    def fails(*_: object, **__: object) -> None:
        raise TimedOut("too slow")

    monkeypatch.setattr(replanning, "coordinate", fails)
    fleet = Fleet()
    fleet.pass_time(2.0)
    fleet.pass_time(1.0, gold={"errand": Errand(2, (14.0, 6.5))})
    given = fleet.pass_time(1.0, gold=fleet.promise("gold"), green=fleet.promise("green"))
    assert given is not None and given.assignments["gold"].reason and not given.assignments["green"].reason
    for name, assignment in given.assignments.items():
        kept, old = assignment.schedule, SCHEDULES[name]
        assert assignment.origin == 0.0 and np.array_equal(kept.times, old.times) and kept.version == 2
        assert np.array_equal(kept.robot.path.points, old.robot.path.points)
        assert kept.robot.committed == pytest.approx(fleet.reports[name].bound)
    assert given.assignments["green"].schedule.precedences == (Precedence(6.0, "gold", 7.0, 2),)


@pytest.mark.parametrize("unserved", ["", "gold has no way to its goal"])
def test_a_new_goal_of_a_robot_that_is_still_blocked_is_not_given_up_with_the_former(unserved: str) -> None:
    fleet = Fleet()
    fleet.pass_time(4.0)
    x = fleet.reports["gold"].arc_length + 1.0
    held = {"arc_length": x - 1.0, "blocked": CONFIG.give_up, "unserved": unserved,
            "obstacles": {"gold/1": DiscObstacle(x + 0.8, 2.0, 0.3)}}
    fleet.pass_time(CONFIG.give_up, gold=held)
    given = fleet.pass_time(1.0, gold={**held, **fleet.promise("gold", 0.0)}, green=fleet.promise("green"))
    assert given is not None and given.assignments["gold"].final
    kept = {name: {"version": 2, "exchange": 2, "bound": np.inf, "schedule": given.assignments[name].schedule}
            for name in GOALS}
    held = {"arc_length": 0.0, "blocked": held["blocked"]}
    fleet.pass_time(2.0, green=kept["green"], gold={
        **kept["gold"], **held, "unserved": given.assignments["gold"].reason, "final": True})
    fleet.pass_time(1.0, gold={**held, "errand": Errand(2, (14.0, 6.5))})
    given = fleet.pass_time(1.0, gold={**held, **fleet.promise("gold", 0.0)}, green=fleet.promise("green"))
    gold = given.assignments["gold"]  # type: ignore[union-attr]
    assert gold.errand == 2 and not gold.reason and not gold.final


def test_where_no_schedule_is_found_nobody_drives_on_to_a_goal_that_was_taken_back(
        monkeypatch: pytest.MonkeyPatch) -> None:
    from social_fleet.errors import TimedOut
    from social_fleet.execution.recovery import replanning

    def fails(*_: object, **__: object) -> None:
        raise TimedOut("too slow")

    monkeypatch.setattr(replanning, "coordinate", fails)
    fleet = Fleet()
    fleet.pass_time(2.0)
    fleet.pass_time(1.0, gold={"errand": None})
    given = fleet.pass_time(1.0, gold=fleet.promise("gold"), green=fleet.promise("green"))
    assert given is not None
    for name, assignment in given.assignments.items():
        assert assignment.schedule.robot.path.length == pytest.approx(assignment.schedule.robot.committed), name
    assert given.assignments["green"].reason and not given.assignments["green"].final


def test_when_all_have_fallen_silent_nothing_is_planned_and_nothing_warned_of(caplog: pytest.LogCaptureFixture) -> None:
    fleet = Fleet()
    fleet.pass_time(2.0)
    asked = fleet.pass_time(1.0, gold={"errand": Errand(2, (14.0, 6.5))})
    assert asked is not None and asked.exchange == 2
    fleet.pass_time(CONFIG.gone + 5.0, silent=("gold", "green"))
    assert not any("no schedule" in record.getMessage() for record in caplog.records)


def test_one_that_falls_silent_while_promises_are_awaited_is_led_round_at_once() -> None:
    fleet = Fleet()
    fleet.pass_time(2.0)
    fleet.pass_time(1.0, green={"errand": Errand(2, (14.0, 2.0))})
    fleet.pass_time(CONFIG.gone - 1.0, silent=("gold",), green=fleet.promise("green"))
    assert not fleet.said[-1].assignments
    given = fleet.pass_time(2.0, silent=("gold",))
    assert given is not None and set(given.assignments) == {"green"} and len(fleet.dispatcher.decisions) == 1
    points = given.assignments["green"].schedule.robot.path.position(np.linspace(1.0, 14.0, 200))
    places = [(shape.x, shape.y) for name, shape in given.obstacles.items() if name.startswith("gold#")]
    assert places and min(np.hypot(*(points - place).T).min() for place in places) > 0.5


def test_one_that_never_knew_where_it_is_keeps_nobody_waiting_for_long() -> None:
    fleet = Fleet()
    fleet.pass_time(2.0)
    where = fleet.reports["gold"].pose
    fleet.pass_time(3.0, gold={"session": 7, "version": 0, "schedule": None, "serving": 0, "pose": None})
    assert not fleet.dispatcher.decisions
    fleet.pass_time(2.0, green={"errand": Errand(2, (14.0, 6.5))})
    fleet.pass_time(2.0, gold=fleet.promise("gold"), green=fleet.promise("green"))
    assert len(fleet.dispatcher.decisions) == 1 and not fleet.said[-1].assignments
    given = fleet.pass_time(CONFIG.gone - 6.0)
    assert given is not None and set(given.assignments) == {"green"}
    assert where is not None and (given.obstacles["gold#1/0"].x, given.obstacles["gold#1/0"].y) == where[:2]
    told = {"version": 2, "schedule": given.assignments["green"].schedule, "serving": 2, "bound": np.inf}
    fleet.pass_time(2.0, green=told, gold={"pose": Pose(3.0, 2.0)})
    assert fleet.dispatcher.decisions[1:] == ["sequential: gold has no schedule"]
