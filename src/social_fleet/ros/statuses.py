"""Which exception becomes which status of a service: the one place that knows."""

import logging
from typing import Sequence, Tuple, Type

from social_fleet.errors import (Infeasible, InvalidGoal, InvalidInput, InvalidMap, InvalidStart, NoPath, NotReady,
                                 SocialFleetError, SolverFailed, TimedOut)
from social_fleet.ros.conversions import UnknownFrame
from social_fleet.srv import AddOverlayResponse, CoordinateResponse, PlanPathResponse

_Table = Sequence[Tuple[Type[Exception], int]]

PLAN_STATUSES: _Table = (
    (UnknownFrame, PlanPathResponse.TF_ERROR),
    (InvalidStart, PlanPathResponse.INVALID_START),
    (InvalidGoal, PlanPathResponse.INVALID_GOAL),
    (InvalidMap, PlanPathResponse.MAP_ERROR),
    (InvalidInput, PlanPathResponse.INVALID_REQUEST),
    (NoPath, PlanPathResponse.NO_PATH_FOUND),
    (NotReady, PlanPathResponse.NOT_INITIALIZED),
    (TimedOut, PlanPathResponse.PAT_EXCEEDED),
    (SocialFleetError, PlanPathResponse.FAILURE),
    (Exception, PlanPathResponse.INTERNAL_ERROR),
)
COORDINATE_STATUSES: _Table = (
    (UnknownFrame, CoordinateResponse.TF_ERROR),
    (InvalidInput, CoordinateResponse.INVALID_REQUEST),
    (Infeasible, CoordinateResponse.INFEASIBLE),
    (TimedOut, CoordinateResponse.TIMED_OUT),
    (SolverFailed, CoordinateResponse.SOLVER_FAILED),
    (NotReady, CoordinateResponse.NOT_INITIALIZED),
    (SocialFleetError, CoordinateResponse.FAILURE),
    (Exception, CoordinateResponse.INTERNAL_ERROR),
)
OVERLAY_STATUSES: _Table = (  # of AddOverlay and ClearOverlay, which have the same
    (UnknownFrame, AddOverlayResponse.TF_ERROR),
    (InvalidMap, AddOverlayResponse.MAP_ERROR),
    (InvalidInput, AddOverlayResponse.INVALID_REQUEST),
    (NotReady, AddOverlayResponse.NOT_INITIALIZED),
    (SocialFleetError, AddOverlayResponse.FAILURE),
    (Exception, AddOverlayResponse.INTERNAL_ERROR),
)


def status_of(error: Exception, table: _Table) -> int:
    """The status for `error`: that of the first class in `table` which it is an instance of.

    An exception that nobody raised on purpose is logged with its traceback.
    """
    if not isinstance(error, SocialFleetError):
        logging.getLogger(__name__).error("a fault of the node itself", exc_info=error)
    return next(status for kind, status in table if isinstance(error, kind))
