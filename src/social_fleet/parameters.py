"""Parameters as frozen dataclasses: one declaration per value, one loader that refuses what is wrong."""

import dataclasses
import math
from typing import Any, Dict, Mapping, Optional, Sequence, Tuple, Type, TypeVar, Union, get_type_hints

from social_fleet.errors import InvalidParameter

_NONE = type(None)
Parameters = TypeVar("Parameters")
_SCALARS: Dict[Any, Tuple[Tuple[type, ...], str]] = {
    float: ((float, int), "a number"),
    int: ((int,), "a whole number"),
    bool: ((bool,), "true or false"),
    str: ((str,), "a text"),
}


def parameter(default: Any, *, above: Optional[float] = None, minimum: Optional[float] = None,
              maximum: Optional[float] = None, choices: Sequence[Any] = ()) -> Any:
    """A dataclass field with its bounds; `check_parameters` holds the value to them.

    Parameters
    ----------
    above, minimum, maximum
        The value must be greater than, at least, at most this.
    choices
        The values that are allowed, when there are only a few.
    """
    bounds = {"above": above, "minimum": minimum, "maximum": maximum, "choices": tuple(choices)}
    return dataclasses.field(default=default, metadata=bounds)


def check_parameters(values: Any, *, source: str = "", prefix: str = "") -> None:
    """Hold every field of a dataclass instance to its type and bounds; for `__post_init__`.

    Raises
    ------
    InvalidParameter
        The `field` is `prefix` + the field's name.
    """
    kinds = get_type_hints(type(values))
    for field in dataclasses.fields(values):
        problem = _problem(getattr(values, field.name), kinds[field.name], field.metadata)
        if problem:
            raise InvalidParameter(problem, source=source, field=prefix + field.name)


def from_mapping(kind: Type[Parameters], mapping: Mapping[str, Any], *, source: str = "",
                 prefix: str = "") -> Parameters:
    """Build a parameter dataclass from the values of a YAML file or of a parameter server.

    Parameters
    ----------
    kind
        The dataclass; what the mapping leaves out keeps its default.
    mapping
        Values by field name.
    source, prefix
        The file, and what stands before the name in it (``planner.``, ``/gold/trajectory_tracker/``).

    Raises
    ------
    InvalidParameter
        For a key that is unknown, a wrong type, or a value out of its range, by its full name.
    """
    if not isinstance(mapping, Mapping):
        raise InvalidParameter(f"must be a mapping of parameters, not {mapping!r}", source=source,
                               field=prefix.rstrip("./"))
    fields = {field.name: field for field in dataclasses.fields(kind) if field.init}  # type: ignore[arg-type]
    for key in mapping:
        if key not in fields:
            raise InvalidParameter(f"there is no such parameter; known are {', '.join(sorted(fields))}",
                                   source=source, field=prefix + str(key))
    kinds = get_type_hints(kind)
    values = {}
    for key, value in mapping.items():
        problem = _problem(value, kinds[key], fields[key].metadata)
        if problem:
            raise InvalidParameter(problem, source=source, field=prefix + key)
        values[key] = _converted(value, kinds[key])
    try:
        return kind(**values)
    except InvalidParameter as error:
        raise InvalidParameter(error.message, source=source, field=prefix + error.field) from error


def _problem(value: Any, kind: Any, bounds: Mapping[str, Any]) -> str:
    """What is wrong with a value, as the end of a sentence; empty when nothing is."""
    if getattr(kind, "__origin__", None) is Union:
        if value is None:
            return ""
        kind = next(option for option in kind.__args__ if option is not _NONE)
    if getattr(kind, "__origin__", None) is tuple:
        return _sequence_problem(value, kind, bounds)
    if dataclasses.is_dataclass(kind):
        return "" if isinstance(value, (kind, Mapping)) else f"must be a mapping of parameters, not {value!r}"
    types, wanted = _SCALARS[kind]
    if not isinstance(value, types) or (isinstance(value, bool) and kind is not bool):
        return f"must be {wanted}, not {value!r}"
    if kind is float and not math.isfinite(value):
        return f"must be finite, not {value!r}"
    return _range_problem(value, bounds)


def _sequence_problem(value: Any, kind: Any, bounds: Mapping[str, Any]) -> str:
    if not isinstance(value, (list, tuple)):
        return f"must be a list, not {value!r}"
    items = kind.__args__
    if items[-1] is Ellipsis:
        items = (items[0],) * len(value)
    if len(items) != len(value):
        return f"must be a list of {len(items)} values, not {value!r}"
    problems = (_problem(item, item_kind, bounds) for item, item_kind in zip(value, items))
    return next((problem for problem in problems if problem), "")


def _range_problem(value: Any, bounds: Mapping[str, Any]) -> str:
    if bounds.get("choices") and value not in bounds["choices"]:
        return f"must be one of {', '.join(map(str, bounds['choices']))}, not {value!r}"
    if bounds.get("above") is not None and not value > bounds["above"]:
        return f"must be greater than {bounds['above']:g}, not {value!r}"
    if bounds.get("minimum") is not None and not value >= bounds["minimum"]:
        return f"must be at least {bounds['minimum']:g}, not {value!r}"
    if bounds.get("maximum") is not None and not value <= bounds["maximum"]:
        return f"must be at most {bounds['maximum']:g}, not {value!r}"
    return ""


def _converted(value: Any, kind: Any) -> Any:
    """A value that was found right in the type of its field."""
    if kind is float:
        return float(value)
    if getattr(kind, "__origin__", None) is tuple:
        return tuple(value)
    return value
