"""A network that loses, delays and reorders, the same way for the same seed."""

import pytest

from social_fleet.errors import InvalidParameter
from social_fleet.simulation.network import Network, NetworkConfig


def carried(config: NetworkConfig, count: int = 2000) -> list:
    network = Network(config)
    for number in range(count):
        network.send(0.01 * number, ["gold"], number)
    return [(round(0.01 * tick, 2), message) for tick in range(count + 400)
            for _, message in network.arrived(0.01 * tick)]


def test_a_kind_network_carries_all_at_once_and_in_order() -> None:
    assert carried(NetworkConfig()) == [(round(0.01 * number, 2), number) for number in range(2000)]


def test_an_unkind_one_loses_delays_and_reorders() -> None:
    came = carried(NetworkConfig(loss=0.1, late=0.1, delay=2.0, seed=3))
    assert 0.85 * 2000 < len(came) < 0.95 * 2000
    waits = [when - 0.01 * number for when, number in came]
    assert max(waits) <= 2.011 and 0.05 < sum(wait > 0.02 for wait in waits) / len(waits) < 0.15
    assert [number for _, number in came] != sorted(number for _, number in came)
    assert came == carried(NetworkConfig(loss=0.1, late=0.1, delay=2.0, seed=3))
    assert came != carried(NetworkConfig(loss=0.1, late=0.1, delay=2.0, seed=4))


def test_each_receiver_has_a_fate_of_its_own() -> None:
    network = Network(NetworkConfig(loss=0.5, seed=1))
    for _ in range(100):
        network.send(0.0, ["gold", "green"], "news")
    came = [receiver for receiver, _ in network.arrived(0.0)]
    assert 30 < came.count("gold") < 70 and came.count("gold") != came.count("green")


@pytest.mark.parametrize("values", [{"loss": 1.0}, {"late": 1.5}, {"delay": -1.0}])
def test_what_no_network_does_is_refused(values: dict) -> None:
    with pytest.raises(InvalidParameter):
        NetworkConfig(**values)
