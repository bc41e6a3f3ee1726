"""Parameters as frozen dataclasses: one declaration per value, one loader that refuses what is wrong."""

import dataclasses
import math
from numbers import Integral, Real
from typing import Any, Dict, Mapping, Optional, Sequence, Tuple, Type, TypeVar, Union, get_type_hints

import numpy as np
import yaml

from social_fleet.errors import InvalidParameter

_NONE = type(None)
Kind = TypeVar("Kind")
_SCALARS: Dict[Any, Tuple[Tuple[type, ...], str]] = {  # NumPy's numbers are Real or Integral as Python's are
    float: ((Real,), "a number"),
    int: ((Integral,), "a whole number"),
    bool: ((bool, np.bool_), "true or false"),
    str: ((str,), "a text"),
}


class Parameters:
    """Base of the frozen dataclasses that hold parameters: checked whenever one is made, read from mappings.

    One with conditions of its own checks them in `__post_init__` after this one's.
    """

    def __post_init__(self) -> None:
        check_parameters(self)

    @classmethod
    def from_mapping(cls: Type[Kind], mapping: Mapping[str, Any], *, source: str = "", prefix: str = "") -> Kind:
        """Read from a YAML file's or parameter server's mapping; see the function `from_mapping`."""
        return from_mapping(cls, mapping, source=source, prefix=prefix)


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

    Values become plain ones of their field's type: 1 and NumPy's numbers a float where that is asked for.

    Raises
    ------
    InvalidParameter
        The `field` is `prefix` + the field's name.
    """
    kinds = get_type_hints(type(values))
    for field in dataclasses.fields(values):
        value = getattr(values, field.name)
        problem = _problem(value, kinds[field.name], field.metadata)
        if problem:
            raise InvalidParameter(problem, source=source, field=prefix + field.name)
        object.__setattr__(values, field.name, _converted(value, kinds[field.name]))


def from_mapping(kind: Type[Kind], mapping: Mapping[str, Any], *, source: str = "", prefix: str = "") -> Kind:
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
        hint = exponent_hint(value) if kind is float else ""
        return f"must be {wanted}, not {value!r}{hint}"
    if kind is float and not _is_finite(value):
        return f"must be finite, not {value!r:.40}"
    return _range_problem(value, bounds)


def _is_finite(value: Any) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number beyond the largest float
        return False


def exponent_hint(value: Any) -> str:
    """What to write instead of 1e3, which YAML reads as a text, as the end of a sentence; empty for other values."""
    try:
        number = float(value) if isinstance(value, str) else math.nan
    except ValueError:
        number = math.nan
    return f"; write {yaml.safe_dump(number).split()[0]}" if math.isfinite(number) else ""


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
    if getattr(kind, "__origin__", None) is Union:
        if value is None:
            return None
        kind = next(option for option in kind.__args__ if option is not _NONE)
    if getattr(kind, "__origin__", None) is tuple:
        items = kind.__args__
        kinds = (items[0],) * len(value) if items[-1] is Ellipsis else items
        return tuple(_converted(item, item_kind) for item, item_kind in zip(value, kinds))
    return kind(value) if kind in _SCALARS else value
