"""The planner's parameters in dynamic_reconfigure, as their one declaration and their manual have them."""

import dataclasses
import os
import threading
from types import SimpleNamespace
from typing import Any, Callable, Dict, Optional, Tuple, get_type_hints

import rospy
from dynamic_reconfigure.encoding import Config
from dynamic_reconfigure.server import Server

from social_fleet.errors import InvalidParameter
from social_fleet.manual import read_manual
from social_fleet.planning.config import PlannerConfig
from social_fleet.scenario.locations import package_folder

_TYPES = {float: "double", int: "int", bool: "bool", str: "str"}
FIXED = ("robot_radius",)  # a robot does not grow under way
_MOST = 1e9  # where a parameter has no bound


class PlannerReconfigure:
    """Serves ``~set_parameters``; a plan right after a change uses it.

    Parameters
    ----------
    config
        What holds at the start.
    use
        Called with every new configuration; returns once plans use it.

    Parameters whose default follows from others can be set in the configuration file alone.
    """

    def __init__(self, config: PlannerConfig, use: Callable[[PlannerConfig], None]) -> None:
        self._config = config
        self._use = use
        self._lock = threading.Lock()
        self._server = Server(description(config), self._change)

    def _change(self, given: Config, _: int) -> Config:
        """Take what is given where it is right; in any case, say what holds now."""
        values = {name: given[name] for name in changeable()}
        with self._lock:
            try:
                wanted = dataclasses.replace(self._config, **values)
                if wanted != self._config:
                    self._use(wanted)
                    changes = (f"{name}: {getattr(wanted, name)}" for name in values
                               if getattr(wanted, name) != getattr(self._config, name))
                    rospy.loginfo("plans use %s from now on", ", ".join(changes))
                    self._config = wanted
            except InvalidParameter as error:
                rospy.logerr("the parameters stay as they were: %s", error)
            given.update({name: getattr(self._config, name) for name in values})
        return given


def changeable() -> Dict[str, Tuple[type, Any]]:
    """Type and bounds of the parameters that can be changed under way, by name."""
    kinds = get_type_hints(PlannerConfig)
    return {field.name: (kinds[field.name], field.metadata) for field in dataclasses.fields(PlannerConfig)
            if kinds[field.name] in _TYPES and field.name not in FIXED}


def description(config: PlannerConfig) -> SimpleNamespace:
    """What dynamic_reconfigure's Server takes; the values of `config` are the defaults."""
    manual = read_manual(os.path.join(package_folder(), "config", "planner.yaml"))
    entries = [_entry(name, kind, bounds, getattr(config, name), manual.get(name, ""))
               for name, (kind, bounds) in changeable().items()]
    group = {"name": "Default", "type": "", "state": True, "cstate": "true", "id": 0, "parent": 0, "parentname": "",
             "parentclass": "", "class": "DEFAULT", "field": "default", "upper": "DEFAULT", "lower": "groups",
             "parameters": entries, "groups": []}
    columns = {column: Config({entry["name"]: entry[column] for entry in entries})
               for column in ("default", "min", "max", "level")}
    return SimpleNamespace(config_description=group, defaults=columns["default"], min=columns["min"],
                           max=columns["max"], level=columns["level"], all_level=1)


def _entry(name: str, kind: type, bounds: Any, value: Any, text: str) -> Dict[str, Any]:
    low, high = _bounds(kind, bounds)
    choices = bounds.get("choices") or ()
    values = [{"name": choice, "type": "str", "value": choice, "ctype": "std::string", "srcfile": "", "srcline": 0,
               "cconsttype": "const char * const", "description": choice} for choice in choices]
    return {"name": name, "type": _TYPES[kind], "default": value, "min": low, "max": high, "level": 1,
            "description": text, "edit_method": repr({"enum": values, "enum_description": text}) if choices else "",
            "ctype": "", "cconsttype": "", "srcfile": "", "srcline": 0}


def _bounds(kind: type, bounds: Any) -> Tuple[Any, Any]:
    """The least and the greatest value; what lies between and is still wrong is refused when it comes."""
    if kind is str:
        return "", ""
    if kind is bool:
        return False, True
    least = _first(bounds.get("minimum"), bounds.get("above"), -_MOST)
    return kind(least), kind(_first(bounds.get("maximum"), _MOST))


def _first(*values: Optional[float]) -> float:
    return next(value for value in values if value is not None)
