"""A scenario refuses robots that would touch before or after they drive, and names that are taken."""

import pytest

from social_fleet.errors import InvalidScenario
from social_fleet.scenario.scenario import Coordination, RobotSpec, Scenario


def pair(gap: float, radius: float = 0.25, name: str = "b", tolerance: float = 0.1) -> Scenario:
    """Two robots whose starts, in a row, are `gap` [m] apart."""
    robots = RobotSpec("a", (0.0, 0.0), (0.0, 5.0)), RobotSpec(name, (gap, 0.0), (5.0, 5.0), radius=radius)
    return Scenario("m", "/m", robots, coordination=Coordination(tracking_tolerance=tolerance), source="dir/two.yaml")


def test_touching_depends_on_radii_and_tolerances() -> None:
    assert pair(0.71).name == "two"
    pair(0.96, radius=0.5)
    pair(0.51, tolerance=0.0)
    with pytest.raises(InvalidScenario, match=r"dir/two.yaml: robots\[1\].start: robot b would stand 0.69 m from the "
                                              "start of robot a; their centres need 0.70 m"):
        pair(0.69)
    with pytest.raises(InvalidScenario, match="their centres need 0.95 m"):
        pair(0.94, radius=0.5)


def test_a_start_may_be_where_another_goes() -> None:
    Scenario("m", "/m", (RobotSpec("a", (0.0, 0.0), (5.0, 0.0)), RobotSpec("b", (5.0, 0.0), (0.0, 0.0))))


def test_names_must_differ() -> None:
    with pytest.raises(InvalidScenario, match=r"robots\[1\].name: robots\[0\] has the name a too; names must differ"):
        pair(3.0, name="a")


def test_without_a_file_it_has_a_name_all_the_same() -> None:
    assert Scenario("m", "/m", (RobotSpec("a", (0.0, 0.0), (5.0, 0.0)),)).name == "scenario"
