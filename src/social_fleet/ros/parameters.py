"""Node parameters: the parameter server's values for the core's one loader of dataclasses."""

import dataclasses
from typing import Any, Dict, Tuple, Type, TypeVar

import rospy

from social_fleet.errors import InvalidParameter
from social_fleet.parameters import from_mapping

Parameters = TypeVar("Parameters")


def read_private(kind: Type[Parameters]) -> Parameters:
    """This node's private parameters as the dataclass `kind`.

    Raises
    ------
    InvalidParameter
        For an unknown name, a wrong type or a value out of range; the `field` is the parameter's full name.
    """
    return from_mapping(kind, _given(), prefix=private_prefix())


def split_private(kind: Type[Parameters]) -> Tuple[Parameters, Dict[str, Any]]:
    """As `read_private` for those parameters that `kind` has as fields, and the others by name."""
    given = _given()
    own = {item.name for item in dataclasses.fields(kind)}  # type: ignore[arg-type]
    values = {name: value for name, value in given.items() if name in own}
    others = {name: value for name, value in given.items() if name not in own}
    return from_mapping(kind, values, prefix=private_prefix()), others


def private_prefix() -> str:
    """What stands before the name of a private parameter of this node."""
    return f"{rospy.get_name()}/"


def _given() -> Dict[str, Any]:
    given = rospy.get_param(rospy.get_name(), {})
    if not isinstance(given, dict):
        raise InvalidParameter(f"holds {given!r} where the node's parameters belong", field=rospy.get_name())
    return given
