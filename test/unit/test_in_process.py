"""Messages within a process: who gets what, and how unkind the network may be."""

from typing import Any, List

import pytest

from social_fleet.errors import InvalidParameter
from social_fleet.fleet.in_process import InProcessNetwork

MESSAGES = [bytes([number]) for number in range(20)]


def received(network: InProcessNetwork, polls: int) -> List[bytes]:
    sender, receiver = network.join(), network.join()
    for message in MESSAGES:
        sender.send(message)
    got = [message for _ in range(polls) for message in receiver.receive()]
    assert sender.receive() == [], "nothing comes back to its sender"
    return got


def test_by_default_all_comes_at_once_and_in_order() -> None:
    assert received(InProcessNetwork(), 1) == MESSAGES


def test_a_seed_decides_the_order_and_loses_nothing() -> None:
    got = received(InProcessNetwork(3), 100)
    assert got != MESSAGES and sorted(got) == MESSAGES
    assert received(InProcessNetwork(3), 100) == got and received(InProcessNetwork(4), 100) != got


def test_losses_and_duplicates() -> None:
    got = received(InProcessNetwork(1, losses=0.3, duplicates=0.3), 100)
    assert 0 < len(set(got)) < len(MESSAGES) and len(got) > len(set(got))


def test_who_joins_late_has_missed_what_was_said() -> None:
    network = InProcessNetwork()
    first = network.join()
    first.send(b"early")
    second = network.join()
    first.send(b"late")
    assert second.receive() == [b"late"] and second.receive() == []


@pytest.mark.parametrize("options, complaint", [
    ({"losses": 0.1}, "losses: needs a seed"), ({"seed": 1, "duplicates": 1.0}, "duplicates: must be at least 0"),
    ({"seed": 1, "losses": -0.1}, "losses: must be at least 0")])
def test_what_makes_no_network_is_refused(options: Any, complaint: str) -> None:
    with pytest.raises(InvalidParameter, match=complaint):
        InProcessNetwork(**options)
