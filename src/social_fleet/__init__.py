"""Socially consistent navigation of robot fleets: paths that keep to one side, and schedules that never touch.

The names below are imported when first used, so that ``import social_fleet`` is quick and needs no ROS.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any, List

if TYPE_CHECKING:
    from social_fleet.coordination.coordinator import coordinate
    from social_fleet.coordination.files import read_schedule, write_schedule
    from social_fleet.coordination.robot import MotionLimits, Robot
    from social_fleet.coordination.schedule import EncounterWindow, FleetSchedule, Precedence, Schedule
    from social_fleet.coordination.verification import ClearanceReport, verify
    from social_fleet.errors import (Disagreement, Infeasible, InvalidGoal, InvalidGraph, InvalidInput, InvalidMap,
                                     InvalidMessage, InvalidOverlay, InvalidParameter, InvalidPose, InvalidScenario,
                                     InvalidSchedule, InvalidStart, NoPath, NotReady, SilentRobot, SocialFleetError,
                                     SolverFailed, TimedOut)
    from social_fleet.geometry import Polyline, Pose
    from social_fleet.mapping.files import load_map, save_map
    from social_fleet.mapping.grid import OccupancyGrid
    from social_fleet.planning.config import PlannerConfig
    from social_fleet.planning.overlays.overlay_set import OverlaySet
    from social_fleet.planning.overlays.shapes import Cells, DiscObstacle, Polygon, Rectangle
    from social_fleet.planning.plan import Plan
    from social_fleet.planning.planner import SocialPlanner
    from social_fleet.planning.routes.social_graph import SocialGraph
    from social_fleet.scenario.files import load_scenario, save_scenario
    from social_fleet.scenario.scenario import Scenario

__version__ = "0.1.0"

_HOMES = {
    "coordination.coordinator": ("coordinate",),
    "coordination.files": ("read_schedule", "write_schedule"),
    "coordination.robot": ("MotionLimits", "Robot"),
    "coordination.schedule": ("EncounterWindow", "FleetSchedule", "Precedence", "Schedule"),
    "coordination.verification": ("ClearanceReport", "verify"),
    "errors": ("Disagreement", "Infeasible", "InvalidGoal", "InvalidGraph", "InvalidInput", "InvalidMap",
               "InvalidMessage", "InvalidOverlay", "InvalidParameter", "InvalidPose", "InvalidScenario",
               "InvalidSchedule", "InvalidStart", "NoPath", "NotReady", "SilentRobot", "SocialFleetError",
               "SolverFailed", "TimedOut"),
    "geometry": ("Polyline", "Pose"),
    "mapping.files": ("load_map", "save_map"),
    "mapping.grid": ("OccupancyGrid",),
    "planning.config": ("PlannerConfig",),
    "planning.overlays.overlay_set": ("OverlaySet",),
    "planning.overlays.shapes": ("Cells", "DiscObstacle", "Polygon", "Rectangle"),
    "planning.plan": ("Plan",),
    "planning.planner": ("SocialPlanner",),
    "planning.routes.social_graph": ("SocialGraph",),
    "scenario.files": ("load_scenario", "save_scenario"),
    "scenario.scenario": ("Scenario",),
}
_MODULE_OF = {name: module for module, names in _HOMES.items() for name in names}

__all__ = [
    "Cells", "ClearanceReport", "Disagreement", "DiscObstacle", "EncounterWindow", "FleetSchedule", "Infeasible",
    "InvalidGoal", "InvalidGraph", "InvalidInput", "InvalidMap", "InvalidMessage", "InvalidOverlay",
    "InvalidParameter", "InvalidPose", "InvalidScenario", "InvalidSchedule", "InvalidStart", "MotionLimits",
    "NoPath", "NotReady", "OccupancyGrid", "OverlaySet", "Plan", "PlannerConfig", "Polygon", "Polyline", "Pose",
    "Precedence", "Rectangle", "Robot", "Scenario", "Schedule", "SilentRobot", "SocialFleetError", "SocialGraph",
    "SocialPlanner", "SolverFailed", "TimedOut", "coordinate", "load_map", "load_scenario", "read_schedule",
    "save_map", "save_scenario", "verify", "write_schedule",
]


def __getattr__(name: str) -> Any:
    """Import the module of a top-level name when the name is first used (PEP 562)."""
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_MODULE_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> List[str]:
    return sorted(set(globals()) | set(__all__))
