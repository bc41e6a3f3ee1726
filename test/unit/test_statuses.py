"""Every exception has its status, and every status of the services is one of their constants."""

from typing import Any, Set

import pytest

pytest.importorskip("social_fleet.msg", reason="needs the built workspace's messages; tools/test has them")

from social_fleet import errors  # noqa: E402
from social_fleet.ros.conversions import UnknownFrame  # noqa: E402
from social_fleet.ros.statuses import COORDINATE_STATUSES, OVERLAY_STATUSES, PLAN_STATUSES, status_of  # noqa: E402
from social_fleet.srv import (AddOverlayResponse, ClearOverlayResponse, CoordinateResponse,  # noqa: E402
                              PlanPathResponse)


def constants(response: Any) -> Set[int]:
    return {value for name, value in vars(response).items() if name.isupper() and isinstance(value, int)}


@pytest.mark.parametrize("table, response", [(PLAN_STATUSES, PlanPathResponse),
                                             (COORDINATE_STATUSES, CoordinateResponse),
                                             (OVERLAY_STATUSES, AddOverlayResponse),
                                             (OVERLAY_STATUSES, ClearOverlayResponse)])
def test_statuses_are_constants_and_none_means_success(table: Any, response: Any) -> None:
    given = {status for _, status in table}
    assert given <= constants(response) - {response.SUCCESS}
    assert given | {response.SUCCESS, getattr(response, "CANCELED", response.SUCCESS)} == constants(response)


@pytest.mark.parametrize("error, plan, coordinate", [
    (errors.InvalidStart("x"), "INVALID_START", "INVALID_REQUEST"),
    (errors.InvalidGoal("x"), "INVALID_GOAL", "INVALID_REQUEST"),
    (errors.InvalidMap("x"), "MAP_ERROR", "INVALID_REQUEST"),
    (errors.InvalidScenario("x"), "INVALID_REQUEST", "INVALID_REQUEST"),
    (UnknownFrame("x"), "TF_ERROR", "TF_ERROR"),
    (errors.NoPath("x"), "NO_PATH_FOUND", "FAILURE"),
    (errors.NotReady("x"), "NOT_INITIALIZED", "NOT_INITIALIZED"),
    (errors.TimedOut("x"), "PAT_EXCEEDED", "TIMED_OUT"),
    (errors.Infeasible("x"), "FAILURE", "INFEASIBLE"),
    (errors.SolverFailed("x"), "FAILURE", "SOLVER_FAILED"),
    (ZeroDivisionError("x"), "INTERNAL_ERROR", "INTERNAL_ERROR"),
])
def test_every_exception_has_its_status(error: Exception, plan: str, coordinate: str) -> None:
    assert status_of(error, PLAN_STATUSES) == getattr(PlanPathResponse, plan)
    assert status_of(error, COORDINATE_STATUSES) == getattr(CoordinateResponse, coordinate)


def test_obstacles_have_theirs() -> None:
    for error, status in ((errors.InvalidOverlay("x"), "INVALID_REQUEST"), (UnknownFrame("x"), "TF_ERROR"),
                          (errors.NotReady("x"), "NOT_INITIALIZED"), (errors.InvalidMap("x"), "MAP_ERROR")):
        assert status_of(error, OVERLAY_STATUSES) == getattr(AddOverlayResponse, status)
    assert status_of(errors.InvalidOverlay("x"), PLAN_STATUSES) == PlanPathResponse.INVALID_REQUEST


def test_the_tables_reach_every_exception_of_the_package() -> None:
    for kind in vars(errors).values():
        if isinstance(kind, type) and issubclass(kind, errors.SocialFleetError):
            for table in (PLAN_STATUSES, COORDINATE_STATUSES, OVERLAY_STATUSES):
                assert any(issubclass(kind, known) for known, _ in table)
