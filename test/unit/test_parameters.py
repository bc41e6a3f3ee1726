"""Parameters: what is right comes through, what is wrong is refused by its full name."""

from dataclasses import dataclass
from typing import Any, Optional, Tuple

import numpy as np
import pytest

from social_fleet.errors import InvalidParameter
from social_fleet.parameters import Parameters, from_mapping, parameter


@dataclass(frozen=True)
class Wheel(Parameters):
    radius: float = parameter(0.1, above=0.0)
    spokes: int = parameter(8, minimum=3, maximum=40)
    kind: str = parameter("steel", choices=("steel", "wood"))
    driven: bool = True
    width: Optional[float] = parameter(None, above=0.0)
    axle: Tuple[float, float] = (0.0, 0.0)


def test_what_is_left_out_keeps_its_default() -> None:
    assert from_mapping(Wheel, {}) == Wheel()


def test_values_take_the_type_of_their_field() -> None:
    wheel = from_mapping(Wheel, {"radius": 1, "axle": [1, 2], "width": 0.5})
    assert isinstance(wheel.radius, float) and wheel.axle == (1, 2) and wheel.width == 0.5


@pytest.mark.parametrize("radius, spokes, axle", [
    (np.float32(0.5), np.int64(9), (np.float64(1.0), 2)), (np.int32(1), np.uint8(9), [1, np.float32(2.0)])])
def test_numbers_of_numpy_become_plain_ones(radius: Any, spokes: Any, axle: Any) -> None:
    for wheel in (Wheel(radius=radius, spokes=spokes, axle=axle, driven=np.bool_(True)),  # type: ignore[arg-type]
                  Wheel.from_mapping({"radius": radius, "spokes": spokes, "axle": axle, "driven": np.bool_(True)})):
        values = (wheel.radius, wheel.spokes, *wheel.axle, wheel.driven)
        assert [type(value) for value in values] == [float, int, float, float, bool]
        assert values == (radius, spokes, *axle, True)


@pytest.mark.parametrize("text, remedy", [("1e3", "write 1000.0"), ("1e37", r"write 1\.0e\+37"), ("wide", "'wide'$")])
def test_a_number_that_yaml_takes_for_a_text_is_told_how_to_be_written(text: str, remedy: str) -> None:
    with pytest.raises(InvalidParameter, match=remedy):
        from_mapping(Wheel, {"radius": text})


@pytest.mark.parametrize("name, value, complaint", [
    ("radius", 0.0, "greater than 0"), ("radius", "wide", "a number"), ("radius", True, "a number"),
    ("radius", float("nan"), "finite"), ("radius", 10 ** 400, "finite"), ("radius", np.float32("inf"), "finite"),
    ("spokes", np.float64(9.0), "whole number"), ("spokes", 2, "at least 3"), ("spokes", 41, "at most 40"),
    ("spokes", 8.5, "whole number"), ("kind", "iron", "steel, wood"), ("driven", 1, "true or false"),
    ("width", -1.0, "greater than 0"), ("axle", [1.0], "list of 2"), ("axle", 3.0, "list"), ("speed", 1, "no such")])
def test_a_wrong_value_is_refused_by_its_full_name(name: str, value: Any, complaint: str) -> None:
    with pytest.raises(InvalidParameter, match=complaint) as caught:
        from_mapping(Wheel, {name: value}, source="car.yaml", prefix="front.")
    assert (caught.value.source, caught.value.field) == ("car.yaml", f"front.{name}")


def test_a_list_where_a_mapping_belongs_is_refused() -> None:
    with pytest.raises(InvalidParameter, match="mapping"):
        from_mapping(Wheel, [1, 2], prefix="wheel.")  # type: ignore[arg-type]


def test_code_is_held_to_the_same_bounds() -> None:
    with pytest.raises(InvalidParameter) as caught:
        Wheel(radius=-1.0)
    assert caught.value.field == "radius"
