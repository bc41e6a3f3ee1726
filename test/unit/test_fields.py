"""Each wrong value in a mapping is refused by the name of its field."""

from typing import Any, Callable

import pytest

from social_fleet.errors import InvalidScenario
from social_fleet.scenario.fields import Fields


@pytest.mark.parametrize("value, read, message", [
    ({}, lambda f: f.text("name"), "robots[2].name: is missing; it has no default"),
    ({"name": 7}, lambda f: f.text("name"), "robots[2].name: must be a text, not 7; write it in quotes"),
    ({"name": "  "}, lambda f: f.text("name"), "robots[2].name: must be a text, not the text '  '"),
    ({"v": "fast"}, lambda f: f.number("v"), "robots[2].v: must be a number, not the text 'fast'"),
    ({"v": "1e3"}, lambda f: f.number("v"), "robots[2].v: must be a number, not the text '1e3'; write 1000.0"),
    ({"v": True}, lambda f: f.number("v"), "robots[2].v: must be a number, not True"),
    ({"v": None}, lambda f: f.number("v"), "robots[2].v: must be a number, not empty"),
    ({"v": float("nan")}, lambda f: f.number("v"), "robots[2].v: must be a finite number, not nan"),
    ({"v": 0}, lambda f: f.number("v", above=0.0), "robots[2].v: must be greater than 0, not 0"),
    ({"v": -1}, lambda f: f.number("v", least=0.0), "robots[2].v: must not be less than 0, not -1"),
    ({"n": 1.5}, lambda f: f.whole_number("n"), "robots[2].n: must be a whole number from 0 on, not 1.5"),
    ({"p": [1]}, lambda f: f.numbers("p", ("x", "y")), "robots[2].p: must be a list [x, y], not [1]"),
    ({"p": [1, "a"]}, lambda f: f.numbers("p", ("x", "y")), "robots[2].p[1]: must be a number, not the text 'a'"),
    ({"c": "left"}, lambda f: f.choice("c", ("a", "b")), "robots[2].c: must be a or b, not the text 'left'"),
    ({"l": {}}, lambda f: f.children("l"), "robots[2].l: must be a list, not {}"),
    ({"l": [3]}, lambda f: f.children("l"), "robots[2].l[0]: must be a mapping of names to values, not 3"),
    ({"m": [1]}, lambda f: f.child("m"), "robots[2].m: must be a mapping of names to values, not [1]"),
])
def test_a_wrong_value_is_refused_by_name(value: Any, read: Callable[[Fields], Any], message: str) -> None:
    with pytest.raises(InvalidScenario) as caught:
        read(Fields(value, "a.yaml", "robots[2]"))
    assert str(caught.value) == f"a.yaml: {message}"


def test_what_is_right_is_read() -> None:
    fields = Fields({"a": "x", "b": 2, "c": [1, 2], "d": [{}], "e": None})
    assert (fields.text("a"), fields.number("b"), fields.numbers("c", ("x", "y", "yaw"), optional=1)) == (
        "x", 2.0, (1.0, 2.0))
    assert len(fields.children("d")) == 1 and not fields.child("e").has("f")
    assert fields.number("g", 0.5) == 0.5 and fields.number("h", None) is None
    fields.finish()


def test_an_unknown_key_is_refused_with_the_one_that_is_meant() -> None:
    fields = Fields({"max_sped": 1.0}, "a.yaml", "robots[0]")
    fields.number("max_speed", 0.7)
    with pytest.raises(InvalidScenario, match=r"robots\[0\]\.max_sped: is not known here; did you mean max_speed\?"):
        fields.finish()
    other = Fields({"colour": 1.0})
    other.number("radius", 0.7)
    with pytest.raises(InvalidScenario, match="colour: is not known here; known are radius"):
        other.finish()
