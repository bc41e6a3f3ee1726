"""Typed access to the mappings of a scenario file: each wrong value is refused by the name of its field."""

import difflib
import math
from typing import Any, List, Optional, Sequence, Tuple

from social_fleet.errors import InvalidScenario
from social_fleet.parameters import exponent_hint

_TYPE_NAMES = {dict: "a mapping", list: "a list", str: "a text", bool: "true or false", int: "a whole number",
               float: "a number", type(None): "empty"}


class Fields:
    """The keys of one mapping, taken one by one; `finish` refuses those that nobody took.

    Parameters
    ----------
    value
        What stands in the file; must be a mapping.
    source
        Name of the file.
    path
        Field name of the mapping itself, such as ``robots[2]``; empty for the whole file.
    """

    def __init__(self, value: Any, source: str = "", path: str = "") -> None:
        self.source = source
        self.path = path
        if not isinstance(value, dict):
            raise self.wrong("", f"must be a mapping of names to values, not {describe(value)}")
        self._value = value
        self._taken: List[str] = []

    def wrong(self, name: str, message: str) -> InvalidScenario:
        """The exception for the key `name`, to be raised by the caller."""
        return InvalidScenario(message, source=self.source, field=self.name(name))

    def name(self, key: str) -> str:
        """Full field name of `key`."""
        return f"{self.path}.{key}" if self.path and key else self.path or key

    def has(self, key: str) -> bool:
        """Whether the file gives `key`."""
        return key in self._value

    def take(self, key: str, *default: Any) -> Any:
        """The raw value of `key`; without a default, a missing key is refused."""
        self._taken.append(key)
        if key not in self._value:
            if not default:
                raise self.wrong(key, "is missing; it has no default")
            return default[0]
        return self._value[key]

    def text(self, key: str, *default: str) -> str:
        """A text that is not empty."""
        value = self.take(key, *default)
        if not isinstance(value, str) or not value.strip():
            raise self.wrong(key, f"must be a text, not {describe(value)}" + (
                "; write it in quotes" if isinstance(value, (bool, int, float)) else ""))
        return value

    def choice(self, key: str, options: Sequence[str], *default: str) -> str:
        """One of `options`."""
        value = self.take(key, *default)
        if value not in options:
            raise self.wrong(key, f"must be {' or '.join(options)}, not {describe(value)}")
        return str(value)

    def number(self, key: str, *default: Optional[float], above: Optional[float] = None,
               least: Optional[float] = None) -> float:
        """A finite number, greater than `above` and not less than `least` where these are given.

        A default may also be None or infinite.
        """
        value = self.take(key, *default)
        if key not in self._value and (value is None or value == math.inf):
            return value
        return self._number(key, value, above, least)

    def whole_number(self, key: str, *default: int, least: int = 0) -> int:
        """A whole number, not less than `least`."""
        value = self.take(key, *default)
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            raise self.wrong(key, f"must be a whole number from {least} on, not {describe(value)}")
        return value

    def numbers(self, key: str, names: Sequence[str], optional: int = 0) -> Tuple[float, ...]:
        """A list of finite numbers, one per name; the last `optional` of them may be left out."""
        value = self.take(key)
        wanted = "[" + ", ".join(names) + "]"
        if not isinstance(value, list) or not len(names) - optional <= len(value) <= len(names):
            raise self.wrong(key, f"must be a list {wanted}, not {describe(value)}")
        return tuple(self._number(f"{key}[{index}]", item) for index, item in enumerate(value))

    def children(self, key: str, *default: Any) -> List["Fields"]:
        """A list of mappings."""
        value = self.take(key, *default)
        if not isinstance(value, list):
            raise self.wrong(key, f"must be a list, not {describe(value)}")
        return [Fields(item, self.source, f"{self.name(key)}[{index}]") for index, item in enumerate(value)]

    def child(self, key: str) -> "Fields":
        """A mapping, empty when missing."""
        value = self.take(key, {})
        return Fields({} if value is None else value, self.source, self.name(key))

    def finish(self) -> None:
        """Refuse keys that were never taken, with the nearest one that would be right."""
        for key in self._value:
            if key not in self._taken:
                near = difflib.get_close_matches(str(key), self._taken, n=1)
                hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(self._taken)}"
                raise self.wrong(str(key), f"is not known here; {hint}")

    def _number(self, key: str, value: Any, above: Optional[float] = None, least: Optional[float] = None) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self.wrong(key, f"must be a number, not {describe(value)}" + exponent_hint(value))
        number = float(value)
        if not math.isfinite(number):
            raise self.wrong(key, f"must be a finite number, not {value!r}")
        if above is not None and number <= above:
            raise self.wrong(key, f"must be greater than {above:g}, not {value!r}")
        if least is not None and number < least:
            raise self.wrong(key, f"must not be less than {least:g}, not {value!r}")
        return number


def describe(value: Any) -> str:
    """`value` as an error message names it."""
    kind = _TYPE_NAMES.get(type(value), type(value).__name__)
    if value is None:
        return "empty"
    if isinstance(value, (dict, list)) and len(repr(value)) > 60:
        return f"{kind} of {len(value)}"
    if isinstance(value, str):
        return f"the text {value[:60]!r}"
    return f"{value!r}"
