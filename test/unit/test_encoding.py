"""Messages as bytes: nothing gets lost, nothing but a message is read."""

import json
import struct
from typing import Any, Callable, Dict

import numpy as np
import pytest
from fleets import robot, street_fleet

from social_fleet.coordination.coordinator import coordinate
from social_fleet.coordination.encounters import Encounter, EncounterFinder
from social_fleet.coordination.robot import Robot
from social_fleet.errors import InvalidMessage
from social_fleet.fleet.encoding import FORMAT, decode, encode, schedule_digest
from social_fleet.fleet.messages import Announcement, Findings, PairWindows, Verdict

AWKWARD = robot("Gödel", (0.1 + 0.2, -0.0), (1.0 / 3.0, 1e-300), (np.pi, 1e16), max_speed=0.1 + 0.2, radius=0.3,
                depart=1.0 / 3.0, start_yaw=-np.pi)
CROSSING = [robot("r", (-5, 0), (5, 0), (5, 7)), robot("s", (0.1, -5), (0.1, 5))]
ENCODED = encode(Announcement("key", AWKWARD))


def same_bits(one: Any, other: Any) -> bool:
    return np.asarray(one, dtype=float).tobytes() == np.asarray(other, dtype=float).tobytes()


def header_of(content: bytes) -> Dict[str, Any]:
    length, = struct.unpack_from("<I", content, 8)
    header: Dict[str, Any] = json.loads(content[12:12 + length].decode())
    return header


def with_header(content: bytes, change: Callable[[Dict[str, Any]], None]) -> bytes:
    length, = struct.unpack_from("<I", content, 8)
    header = header_of(content)
    change(header)
    text = json.dumps(header).encode()
    return content[:8] + struct.pack("<I", len(text)) + text + content[12 + length:]


def test_a_path_arrives_bit_by_bit() -> None:
    heard = decode(ENCODED)
    assert isinstance(heard, Announcement) and heard.schedule is None
    assert (heard.round, heard.sender) == ("key", "Gödel")
    assert same_bits(heard.robot.path.points, AWKWARD.path.points)
    assert heard.robot.limits == AWKWARD.limits and heard.robot.goal_yaw is None
    for field in ("max_speed", "radius", "depart", "start_yaw"):
        assert same_bits(getattr(heard.robot, field), getattr(AWKWARD, field))
    assert encode(heard) == ENCODED


def test_a_schedule_arrives_bit_by_bit() -> None:
    sent, = (schedule for schedule in coordinate(CROSSING, version=3).schedules if schedule.precedences)
    heard = decode(encode(Announcement("key", sent.robot, sent)))
    assert isinstance(heard, Announcement) and heard.schedule is not None
    assert same_bits(heard.schedule.times, sent.times) and same_bits(heard.schedule.arc_lengths, sent.arc_lengths)
    assert heard.schedule.precedences == sent.precedences and heard.schedule.version == 3
    assert heard.schedule.robot is heard.robot


@pytest.mark.parametrize("seed", range(3))
def test_windows_arrive_bit_by_bit(seed: int) -> None:
    fleet, finder = street_fleet(6, seed), EncounterFinder(0.1)
    pairs = tuple(PairWindows(r.name, s.name, "one", "other", finder.between(r, s))
                  for index, r in enumerate(fleet) for s in fleet[index + 1:])
    assert any(pair.windows for pair in pairs) and not all(pair.windows for pair in pairs)
    heard = decode(encode(Findings("key", "robot_00", pairs)))
    assert isinstance(heard, Findings) and heard.sender == "robot_00"
    for got, pair in zip(heard.pairs, pairs):
        assert (got.r, got.s, got.r_path, got.s_path) == (pair.r, pair.s, pair.r_path, pair.s_path)
        assert [plain(window) for window in got.windows] == [plain(window) for window in pair.windows]


def plain(window: Encounter) -> Any:
    return (window.r, window.s, window.kind, window.r_extent, window.s_extent, window.r_ends, window.s_ends,
            [(order.leader, order.follower, order.at.tobytes(), order.clear.tobytes(), order.possible)
             for order in window.orders])


def test_a_verdict_arrives() -> None:
    for verdict in (Verdict("key", "gold", "abc"), Verdict("key", "gold", "", "no schedule: ∞ robots")):
        assert decode(encode(verdict)) == verdict


@pytest.mark.parametrize("content, complaint", [
    (b"", "is cut short: 0 bytes"),
    (b"\x00" * 40, "none of social_fleet's"),
    (ENCODED[:-1], "announces 6 doubles and brings 5.875"),
    (ENCODED + b"\x00" * 8, "announces 6 doubles and brings 7"),
    (ENCODED[:30], "header"),
    (ENCODED[:4] + struct.pack("<I", FORMAT + 1) + ENCODED[8:], "run one release on all robots"),
    (with_header(ENCODED, lambda header: header.update(kind="Order")), "no known kind: 'Order'"),
    (with_header(ENCODED, lambda header: header.pop("robot")), "a field is missing"),
    (with_header(ENCODED, lambda header: header["robot"].update(radius=-1.0)), "radius.*must be positive"),
    (with_header(ENCODED, lambda header: header["robot"].update(depart="soon")), "depart"),
    (with_header(ENCODED, lambda header: header["robot"].update(max_speed=float("nan"))), "NaN is not a number"),
    (with_header(ENCODED, lambda header: header.update(doubles=[5, 1])), "cannot reshape"),
    (with_header(ENCODED, lambda header: header.update(doubles=[-2, 8])), "doubles"),
    (with_header(ENCODED, lambda header: header.update(round=7)), "a text is needed, not 7")])
def test_what_is_no_message_is_refused(content: bytes, complaint: str) -> None:
    with pytest.raises(InvalidMessage, match=complaint):
        decode(content)


@pytest.mark.parametrize("change, complaint", [
    (lambda window: window.update(kind="meeting"), "no such kind of window: 'meeting'"),
    (lambda window: window.update(possible=[1, 0]), "two of bool are needed"),
    (lambda window: window.update(r_extent=[1.0]), "wrong type"),
    (lambda window: window.update(s_ends=None), "wrong type")])
def test_windows_that_are_none_are_refused(change: Callable[[Dict[str, Any]], None], complaint: str) -> None:
    windows = EncounterFinder(0.1).between(*CROSSING)
    content = encode(Findings("key", "r", (PairWindows("r", "s", "one", "other", windows),)))
    with pytest.raises(InvalidMessage, match=complaint):
        decode(with_header(content, lambda header: change(header["pairs"][0]["windows"][0])))


def test_rows_that_fall_are_refused() -> None:
    windows = EncounterFinder(0.1).between(robot("r", (0, 0), (20, 0)), robot("s", (-5, 0), (18, 0)))
    content = bytearray(encode(Findings("key", "r", (PairWindows("r", "s", "one", "other", windows),))))
    content[-8:] = struct.pack("<d", -1.0)
    with pytest.raises(InvalidMessage, match="not finite, or fall"):
        decode(bytes(content))


def test_the_digest_of_a_schedule_tells_all_but_how_long_it_took() -> None:
    fleet = coordinate(CROSSING)
    assert schedule_digest(coordinate(CROSSING[::-1])) == schedule_digest(fleet)
    later = [CROSSING[0], Robot("s", CROSSING[1].plan, depart=1e-12)]
    assert schedule_digest(coordinate(later)) != schedule_digest(fleet)
    assert schedule_digest(coordinate(CROSSING, version=2)) != schedule_digest(fleet)
