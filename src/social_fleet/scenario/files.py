"""Scenario files: read strictly, and written so that a person can go on from there."""

import math
import os
from typing import Any, Dict, List, Sequence, Tuple, Type

import yaml

from social_fleet.coordination.options import FORMULATIONS, MODES, OBJECTIVES
from social_fleet.errors import InvalidInput, InvalidScenario
from social_fleet.files import PathLike, atomic_write, plain, read_yaml
from social_fleet.parameters import Parameters
from social_fleet.scenario.fields import Fields
from social_fleet.scenario.locations import resolve
from social_fleet.scenario.scenario import Coordination, Expect, RobotSpec, Scenario
from social_fleet.simulation.config import SimulationConfig
from social_fleet.simulation.faults import DISPATCHER, FAULT_KINDS, LASTING, CircleObstacle, Fault
from social_fleet.simulation.network import NetworkConfig


def load_scenario(path: PathLike) -> Scenario:
    """Read a scenario file.

    Raises
    ------
    InvalidScenario
        When the file is missing or not YAML, holds a key that is unknown, missing or of the wrong type, or
        contradicts itself. `source` is the file, `field` names the value, such as ``robots[2].max_speed``.
    """
    source = os.fspath(path)
    return parse_scenario(read_yaml(source, InvalidScenario), source=source)


def parse_scenario(content: Any, *, source: str) -> Scenario:
    """The scenario that a YAML file's content describes; see `load_scenario`."""
    fields = Fields(content, source)
    map_name = fields.text("map")
    robots = tuple(_robot(child) for child in fields.children("robots"))
    if not robots:
        raise fields.wrong("robots", "must list at least one robot")
    planner = _planner(fields)
    coordination = _coordination(fields.child("coordination"))
    obstacles = tuple(_obstacle(child) for child in fields.children("obstacles", []))
    names = [robot.name for robot in robots]
    faults = tuple(_fault(child, names) for child in fields.children("faults", []))
    expect = _expect(fields.child("expect"), names)
    network = NetworkConfig.from_mapping(_tried(fields, "network", NetworkConfig))
    simulation = _tried(fields, "simulation", SimulationConfig)
    fields.finish()
    return Scenario(map_name, _map_path(fields, map_name), robots, planner, coordination, obstacles, faults, expect,
                    network, simulation, source)


def save_scenario(scenario: Scenario, path: PathLike) -> None:
    """Write `scenario` such that `load_scenario` gives it back; values that are defaults are left out.

    Raises
    ------
    InvalidInput
        When the file cannot be created.
    """
    with atomic_write(path) as stream:
        stream.write(format_scenario(scenario))


def format_scenario(scenario: Scenario) -> str:
    """`scenario` as the text of a scenario file, one line per robot, obstacle and fault."""
    lines = []
    for key, value in scenario_to_dict(scenario).items():
        if isinstance(value, list):
            lines += [f"{key}:", *(f"  - {_flow(item)}" for item in value)]
        else:
            lines.append(f"{key}: {_flow(value)}")
    return "\n".join(lines) + "\n"


def scenario_to_dict(scenario: Scenario) -> Dict[str, Any]:
    """The content of a scenario file as plain values; what equals a default or is empty is left out."""
    content: Dict[str, Any] = {"map": scenario.map, "robots": [_robot_to_dict(robot) for robot in scenario.robots]}
    if scenario.obstacles:
        content["obstacles"] = [_obstacle_to_dict(obstacle) for obstacle in scenario.obstacles]
    if scenario.faults:
        content["faults"] = [{name: list(value) if isinstance(value, tuple) else value
                              for name, value in _given(fault).items()} for fault in scenario.faults]
    if scenario.network != NetworkConfig():
        content["network"] = _given(scenario.network)
    if scenario.simulation:
        content["simulation"] = scenario.simulation
    if scenario.planner:
        content["planner"] = scenario.planner
    content["coordination"] = {**_given(scenario.coordination), "mode": scenario.coordination.mode}
    arrived = scenario.expect.arrived
    content["expect"] = {**_given(scenario.expect), "arrived": "all" if arrived is None else arrived,
                         "collisions": scenario.expect.collisions}
    plain_content: Dict[str, Any] = plain(content)
    return plain_content


def _robot(fields: Fields) -> RobotSpec:
    pose = ("x", "y", "yaw")
    robot = RobotSpec(
        name=fields.text("name"), start=fields.numbers("start", pose, optional=1),
        goal=fields.numbers("goal", pose, optional=1), max_speed=fields.number("max_speed", 0.7, above=0.0),
        radius=fields.number("radius", 0.25, above=0.0), depart=fields.number("depart", 0.0, least=0.0),
        weight=fields.number("weight", 1.0, above=0.0),
        **{name: fields.number(name, None, above=0.0)
           for name in ("max_acceleration", "max_turn_rate", "max_turn_acceleration")})
    fields.finish()
    return robot


def _robot_to_dict(robot: RobotSpec) -> Dict[str, Any]:
    """Speed and radius are written out even where they are the defaults: they are what a reader asks for first."""
    shown = {name: getattr(robot, name) for name in ("name", "start", "goal", "max_speed", "radius")}
    return {**shown, **_given(robot)}


def _obstacle(fields: Fields) -> CircleObstacle:
    fields.choice("shape", ("circle",), "circle")
    x, y = fields.numbers("center", ("x", "y"))
    radius = fields.number("radius", above=0.0)
    appears = fields.number("appears", 0.0, least=0.0)
    disappears = fields.number("disappears", math.inf, least=0.0)
    if disappears <= appears:
        raise fields.wrong("disappears", f"must be later than appears, which is {appears:g}, not {disappears:g}")
    fields.finish()
    return CircleObstacle(x, y, radius, appears, disappears)


def _obstacle_to_dict(obstacle: CircleObstacle) -> Dict[str, Any]:
    given = _given(obstacle)
    return {"shape": "circle", "center": [given.pop("x"), given.pop("y")], **given}


def _fault(fields: Fields, names: Sequence[str]) -> Fault:
    kind = fields.choice("kind", FAULT_KINDS)
    values = {name: fields.number(name, above=above) for name, above in (
        ("factor", 0.0), ("distance", None), ("direction", None)) if fields.has(name)}
    lasting = (math.inf,) if kind in LASTING else ()
    goal = fields.numbers("goal", ("x", "y", "yaw"), optional=1) if fields.has("goal") else ()
    try:
        fault = Fault(robot=fields.choice("robot", [*names, DISPATCHER]), kind=kind, goal=goal,
                      at=fields.number("at", least=0.0), duration=fields.number("duration", *lasting, above=0.0),
                      **values)
    except InvalidScenario as error:
        raise error if error.source else fields.wrong(error.field, error.message) from error
    fields.finish()
    return fault


def _coordination(fields: Fields) -> Coordination:
    default = Coordination()
    coordination = Coordination(
        mode=fields.choice("mode", MODES, default.mode),
        formulation=fields.choice("formulation", FORMULATIONS, default.formulation),
        objective=fields.choice("objective", OBJECTIVES, default.objective),
        time_margin=fields.number("time_margin", default.time_margin, least=0.0),
        time_limit=fields.number("time_limit", default.time_limit, above=0.0),
        tracking_tolerance=fields.number("tracking_tolerance", default.tracking_tolerance, least=0.0))
    fields.finish()
    return coordination


def _expect(fields: Fields, names: Sequence[str]) -> Expect:
    arrived = fields.take("arrived", "all")
    if arrived != "all" and not (isinstance(arrived, list) and set(map(str, arrived)) <= set(names)):
        raise fields.wrong("arrived", f"must be all or a list of robots of this file, not {arrived!r}")
    expect = Expect(arrived=None if arrived == "all" else tuple(arrived),
                    collisions=fields.whole_number("collisions", 0),
                    max_lateness=fields.number("max_lateness", None, least=0.0),
                    max_tracking_error=fields.number("max_tracking_error", None, above=0.0))
    fields.finish()
    return expect


def _planner(fields: Fields) -> Dict[str, Any]:
    """The overrides, tried out on the planner's own configuration so that a mistake is found on loading."""
    from social_fleet.planning.config import PlannerConfig
    overrides = fields.take("planner", {})
    if not isinstance(overrides, dict):
        raise fields.wrong("planner", f"must be a mapping of parameters to values, not {overrides!r}")
    if "robot_radius" in overrides:
        raise fields.wrong("planner.robot_radius", "is not for here; give each robot its radius")
    try:
        PlannerConfig.from_mapping(overrides)
    except InvalidInput as error:
        raise fields.wrong("planner" + (f".{error.field}" if error.field else ""), error.message) from error
    return dict(overrides)


def _tried(fields: Fields, key: str, kind: Type[Parameters]) -> Dict[str, Any]:
    """Overrides of parameters, tried out so that a mistake is found on loading."""
    overrides = fields.take(key, {})
    if not isinstance(overrides, dict):
        raise fields.wrong(key, f"must be a mapping of parameters to values, not {overrides!r}")
    try:
        kind.from_mapping(overrides)
    except InvalidInput as error:
        raise fields.wrong(key + (f".{error.field}" if error.field else ""), error.message) from error
    return dict(overrides)


def _map_path(fields: Fields, name: str) -> str:
    try:
        path = resolve(name, os.path.dirname(os.path.abspath(fields.source)))
    except InvalidScenario as error:
        raise fields.wrong("map", error.message) from error
    if not os.path.isfile(path):
        raise fields.wrong("map", f"there is no file {path}; the map's YAML file is named relative to this file, "
                                  "by its absolute path, or as package://social_fleet/maps/…")
    return path


def _given(item: Any) -> Dict[str, Any]:
    """The fields of a dataclass that differ from their defaults, and those without one."""
    values: List[Tuple[str, Any]] = [(name, getattr(item, name)) for name in item.__dataclass_fields__]
    return {name: value for name, value in values if value != item.__dataclass_fields__[name].default}


def _flow(value: Any) -> str:
    text: str = yaml.safe_dump(value, default_flow_style=True, sort_keys=False, allow_unicode=True,
                               width=float("inf"))
    return text.split("\n...\n")[0].strip()
