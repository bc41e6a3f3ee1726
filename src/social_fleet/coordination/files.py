"""schedule.json: a coordinated fleet as a file that anything can read, and that `verify` can judge."""

from typing import Any, Dict, List, Optional, Tuple, Type, Union

from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import EncounterWindow, FleetSchedule, Precedence, Schedule
from social_fleet.errors import InvalidInput, InvalidSchedule
from social_fleet.files import PathLike, read_json, write_json

_Kind = Union[Type, tuple]
_NUMBER = (int, float)
_LIMITS = ("max_acceleration", "max_turn_rate", "max_turn_acceleration")


def schedule_to_dict(fleet: FleetSchedule) -> Dict[str, Any]:
    """`fleet` as the plain values of schedule.json; lengths in metres, times in seconds."""
    header = {name: getattr(fleet, name) for name in (
        "map", "status", "message", "formulation", "objective", "gap", "planning_time", "encounter_time",
        "solve_time")}
    return {**header, "robots": [_robot_to_dict(schedule) for schedule in fleet.schedules],
            "windows": [vars(window) for window in fleet.windows],
            "unserved": [{"name": name, "reason": reason} for name, reason in fleet.unserved]}


def write_schedule(fleet: FleetSchedule, path: PathLike) -> None:
    """Write schedule.json, whole or not at all.

    Raises
    ------
    InvalidInput
        When the file cannot be created.
    """
    write_json(path, schedule_to_dict(fleet))


def read_schedule(path: PathLike) -> FleetSchedule:
    """Read schedule.json.

    Raises
    ------
    InvalidSchedule
        Naming file and field, when something is missing, of the wrong type, or does not fit together.
    """
    return schedule_from_dict(read_json(path, InvalidSchedule), source=str(path))


def schedule_from_dict(data: Any, *, source: str = "") -> FleetSchedule:
    """The fleet of `schedule_to_dict`'s values; `source` names where they come from.

    Raises
    ------
    InvalidSchedule
        As for `read_schedule`.
    """
    _get({"file": data}, "file", dict, source)
    robots = _get(data, "robots", list, source)
    if not robots:
        raise InvalidSchedule("there is no robot in it", source=source, field="robots")
    schedules = tuple(_robot_from_dict(item, source, f"robots[{index}]") for index, item in enumerate(robots))
    names = [schedule.name for schedule in schedules]
    for name in names:
        if names.count(name) > 1:
            raise InvalidSchedule(f"two robots are named {name}; names must differ", source=source, field="robots")
    windows = tuple(_window_from_dict(item, source, f"windows[{index}]")
                    for index, item in enumerate(_get(data, "windows", list, source, default=[])))
    unserved = tuple(_unserved(item, source, f"unserved[{index}]")
                     for index, item in enumerate(_get(data, "unserved", list, source, default=[])))
    numbers = {name: float(_get(data, name, _NUMBER, source, default=0.0))
               for name in ("objective", "gap", "planning_time", "encounter_time", "solve_time")}
    texts = {name: _get(data, name, str, source, default=default)
             for name, default in (("status", "ok"), ("message", ""), ("formulation", "exact"))}
    return FleetSchedule(schedules, windows, map=data.get("map"), unserved=unserved,
                         **texts, **numbers)  # type: ignore[arg-type]


def _robot_to_dict(schedule: Schedule) -> Dict[str, Any]:
    robot = schedule.robot
    return {"name": robot.name, "radius": robot.body_radius, "max_speed": robot.max_speed, "depart": robot.depart,
            "weight": robot.weight, **{limit: getattr(robot, limit) for limit in _LIMITS},
            "start_yaw": robot.start_yaw, "goal_yaw": robot.goal_yaw, "version": schedule.version,
            "path": robot.path.points.tolist(), "arc_lengths": schedule.arc_lengths.tolist(),
            "times": schedule.times.tolist(), "precedences": [vars(rule) for rule in schedule.precedences]}


def _robot_from_dict(item: Any, source: str, field: str) -> Schedule:
    _get({field: item}, field, dict, source)
    values = {name: float(_get(item, name, _NUMBER, source, field)) for name in ("radius", "max_speed")}
    for key, default in (("depart", 0.0), ("weight", 1.0)):
        values[key] = float(_get(item, key, _NUMBER, source, field, default=default))
    for limit in _LIMITS:
        if limit in item:
            values[limit] = float(_get(item, limit, _NUMBER, source, field))
    yaws: Dict[str, Optional[float]] = {name: _get(item, name, _NUMBER + (type(None),), source, field, default=None)
                                        for name in ("start_yaw", "goal_yaw")}
    rules = tuple(_precedence(rule, source, f"{field}.precedences[{index}]")
                  for index, rule in enumerate(_get(item, "precedences", list, source, field, default=[])))
    lists: Dict[str, List] = {name: _get(item, name, list, source, field) for name in ("path", "arc_lengths", "times")}
    name, version = _get(item, "name", str, source, field), _get(item, "version", int, source, field, default=0)
    try:
        robot = Robot(name, lists["path"], **values, **yaws)  # type: ignore[arg-type]
        return Schedule(robot, lists["arc_lengths"], lists["times"], rules, version)  # type: ignore[arg-type]
    except InvalidInput as error:
        raise InvalidSchedule(error.message, source=source,
                              field=".".join(filter(None, (field, error.field)))) from error
    except (TypeError, ValueError) as error:
        raise InvalidSchedule("path must be a list of [x, y], arc_lengths and times lists of numbers",
                              source=source, field=field) from error


def _precedence(item: Any, source: str, field: str) -> Precedence:
    _get({field: item}, field, dict, source)
    return Precedence(float(_get(item, "at", _NUMBER, source, field)), _get(item, "other", str, source, field),
                      float(_get(item, "other_at", _NUMBER, source, field)),
                      int(_get(item, "other_version", int, source, field, default=0)))


def _unserved(item: Any, source: str, field: str) -> Tuple[str, str]:
    _get({field: item}, field, dict, source)
    return _get(item, "name", str, source, field), _get(item, "reason", str, source, field)


def _window_from_dict(item: Any, source: str, field: str) -> EncounterWindow:
    _get({field: item}, field, dict, source)
    texts = {name: _get(item, name, str, source, field) for name in ("robot_r", "robot_s", "kind", "first")}
    numbers = {name: float(_get(item, name, _NUMBER, source, field))
               for name in ("r_enter", "r_exit", "s_enter", "s_exit")}
    return EncounterWindow(**texts, **numbers)  # type: ignore[arg-type]


def _get(item: Dict[str, Any], name: str, kind: _Kind, source: str, within: str = "", **default: Any) -> Any:
    """The value of a key, refused by its full name when it is missing or of another type."""
    field = f"{within}.{name}" if within else name
    if name not in item:
        if default:
            return default["default"]
        raise InvalidSchedule("is missing", source=source, field=field)
    value = item[name]
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        wanted: Dict[Any, str] = {dict: "a mapping", list: "a list", str: "a text", int: "a whole number"}
        what = wanted.get(kind, "a number")
        raise InvalidSchedule(f"must be {what}, not {value!r:.40}", source=source, field=field)
    return value
