"""Messages as bytes and back, exactly: every float arrives with the bits that it was sent with.

A message is, one after the other: the four letters ``SFLT``; the version of this format and the length of the header
in bytes, two little-endian unsigned 32-bit integers; the header, a JSON object in UTF-8 (numbers in the shortest
digits that give the same double again); and doubles, little-endian. The header's ``doubles`` says how many of these
each array takes.
"""

import json
import struct
from dataclasses import fields
from typing import Any, Dict, List, Sequence, Tuple

import numpy as np

from social_fleet.coordination.encounters import Encounter, Order
from social_fleet.coordination.robot import Robot
from social_fleet.coordination.schedule import KINDS, FleetSchedule, Precedence, Schedule
from social_fleet.errors import InvalidInput, InvalidMessage
from social_fleet.files import plain
from social_fleet.fleet.messages import Announcement, Findings, Message, PairWindows, Verdict, digest

FORMAT = 2
"""Version of the format; robots of different versions do not understand each other, and say so."""

_MAGIC = b"SFLT"
_PREFIX = struct.Struct("<4sII")
_LIMITS = tuple(field.name for field in fields(Robot) if field.init and field.name not in ("name", "plan"))
_ORDERS = ("r_first", "s_first")
Arrays = List[np.ndarray]


def encode(message: Message) -> bytes:
    """`message` as bytes; equal for equal messages."""
    arrays: Arrays = []
    header: Dict[str, Any] = {"kind": type(message).__name__, "round": message.round, "sender": message.sender}
    if isinstance(message, Announcement):
        header["robot"] = _robot_to(message.robot, arrays)
        header["schedule"] = None if message.schedule is None else _timing_to(message.schedule, arrays)
    elif isinstance(message, Findings):
        header["pairs"] = [{"r": pair.r, "s": pair.s, "r_path": pair.r_path, "s_path": pair.s_path,
                            "windows": [_window_to(window, arrays) for window in pair.windows]}
                           for pair in message.pairs]
    else:
        header.update(schedule=message.schedule, reason=message.reason)
    return _packed(header, arrays)


def decode(content: bytes) -> Message:
    """The message in `content`.

    Raises
    ------
    InvalidMessage
        When it is cut short, of another version, or holds what no robot would send.
    """
    header, arrays = _unpacked(content)
    try:
        return _message(header, iter(arrays).__next__)
    except InvalidInput as error:
        raise InvalidMessage(f"from {header.get('sender')!r:.40}: {error}") from error
    except (KeyError, TypeError, ValueError, AttributeError, StopIteration) as error:
        raise InvalidMessage(f"from {header.get('sender')!r:.40}: a field is missing or of the wrong type "
                             f"({type(error).__name__}: {error})") from error


def schedule_digest(fleet: FleetSchedule) -> str:
    """A fingerprint of all that robots are driven by: paths, times, precedences, windows; not of how long it took."""
    arrays: Arrays = []
    header = {"schedules": [_schedule_to(schedule, arrays) for schedule in _by_name(fleet.schedules)],
              "amended": [_schedule_to(schedule, arrays) for schedule in _by_name(fleet.amended)],
              "windows": sorted(json.dumps(plain(vars(window)), sort_keys=True) for window in fleet.windows)}
    return digest(_packed(header, arrays))


def _packed(header: Dict[str, Any], arrays: Arrays) -> bytes:
    text = json.dumps(plain({**header, "doubles": [array.size for array in arrays]}), allow_nan=False,
                      ensure_ascii=False, sort_keys=True).encode()
    return b"".join([_PREFIX.pack(_MAGIC, FORMAT, len(text)), text,
                     *(np.ascontiguousarray(array, dtype="<f8").tobytes() for array in arrays)])


def _unpacked(content: bytes) -> Tuple[Dict[str, Any], Arrays]:
    if len(content) < _PREFIX.size:
        raise InvalidMessage(f"is cut short: {len(content)} bytes")
    magic, version, length = _PREFIX.unpack_from(content)
    if magic != _MAGIC:
        raise InvalidMessage(f"is none of social_fleet's: it begins with {magic!r}")
    if version != FORMAT:
        raise InvalidMessage(f"is of format {version}, this robot speaks {FORMAT}; run one release on all robots")
    try:
        header = json.loads(content[_PREFIX.size:_PREFIX.size + length].decode(), parse_constant=_not_a_number)
        counts = [int(count) for count in header["doubles"]]
    except (ValueError, KeyError, TypeError) as error:
        raise InvalidMessage(f"has a header that is cut short or no JSON object: {error}") from error
    doubles = content[_PREFIX.size + length:]
    if min(counts, default=0) < 0 or 8 * sum(counts) != len(doubles):
        raise InvalidMessage(f"announces {sum(counts)} doubles and brings {len(doubles) / 8:g}")
    flat = np.frombuffer(doubles, dtype="<f8").astype(float)
    return header, np.split(flat, np.cumsum(counts)[:-1]) if counts else []


def _not_a_number(text: str) -> None:
    raise ValueError(f"{text} is not a number")


def _message(header: Dict[str, Any], take: Any) -> Message:
    kind, key, sender = header["kind"], _text(header["round"]), _text(header["sender"])
    if kind == "Announcement":
        robot = _robot_from(header["robot"], take)
        schedule = header["schedule"]
        return Announcement(key, robot, None if schedule is None else _timing_from(schedule, robot, take))
    if kind == "Findings":
        return Findings(key, sender, tuple(_pair_from(pair, take) for pair in header["pairs"]))
    if kind == "Verdict":
        return Verdict(key, sender, _text(header["schedule"]), _text(header["reason"]))
    raise InvalidMessage(f"is of no known kind: {kind!r:.40}")


def _robot_to(robot: Robot, arrays: Arrays) -> Dict[str, Any]:
    arrays.append(robot.path.points)
    return {"name": robot.name, **{limit: getattr(robot, limit) for limit in _LIMITS}}


def _robot_from(item: Dict[str, Any], take: Any) -> Robot:
    return Robot(item["name"], take().reshape(-1, 2), **{limit: item[limit] for limit in _LIMITS})


def _timing_to(schedule: Schedule, arrays: Arrays) -> Dict[str, Any]:
    arrays += [schedule.arc_lengths, schedule.times]
    return {"version": schedule.version, "precedences": [vars(rule) for rule in schedule.precedences]}


def _timing_from(item: Dict[str, Any], robot: Robot, take: Any) -> Schedule:
    rules = tuple(Precedence(_number(rule["at"]), _text(rule["other"]), _number(rule["other_at"]),
                             _whole(rule["other_version"])) for rule in item["precedences"])
    return Schedule(robot, take(), take(), rules, _whole(item["version"]))


def _schedule_to(schedule: Schedule, arrays: Arrays) -> Dict[str, Any]:
    return {"robot": _robot_to(schedule.robot, arrays), "timing": _timing_to(schedule, arrays)}


def _pair_from(item: Dict[str, Any], take: Any) -> PairWindows:
    r, s, r_path, s_path = (_text(item[field]) for field in ("r", "s", "r_path", "s_path"))
    return PairWindows(r, s, r_path, s_path, tuple(_window_from(window, take) for window in item["windows"]))


def _window_to(window: Encounter, arrays: Arrays) -> Dict[str, Any]:
    for order in window.orders:
        arrays += [order.at, order.clear]
    return {"kind": window.kind, "r_extent": window.r_extent, "s_extent": window.s_extent, "r_ends": window.r_ends,
            "s_ends": window.s_ends, "possible": [order.possible for order in window.orders]}


def _window_from(item: Dict[str, Any], take: Any) -> Encounter:
    if item["kind"] not in KINDS:
        raise InvalidMessage(f"no such kind of window: {item['kind']!r:.40}")
    possible = _pair(item["possible"], bool)
    orders = [_order(place, take(), take(), possible[place]) for place in (0, 1)]
    return Encounter(0, 1, item["kind"], _pair(item["r_extent"], float), _pair(item["s_extent"], float),
                     _pair(item["r_ends"], bool), _pair(item["s_ends"], bool), *orders)


def _order(leader: int, at: np.ndarray, clear: np.ndarray, possible: bool) -> Order:
    if not (0 < len(at) == len(clear) and np.isfinite(at).all() and np.isfinite(clear).all()
            and (np.diff(at) >= 0.0).all() and (np.diff(clear) >= 0.0).all()):
        raise InvalidMessage("the rows of a window are not finite, or fall")
    return Order(leader, 1 - leader, at, clear, possible)


def _pair(value: Sequence[Any], kind: type) -> Tuple[Any, Any]:
    first, second = value
    if not (isinstance(first, kind) and isinstance(second, kind)):
        raise TypeError(f"two of {kind.__name__} are needed, not {value!r:.60}")
    return first, second


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"a text is needed, not {value!r:.40}")
    return value


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise TypeError(f"a number is needed, not {value!r:.40}")
    return value


def _whole(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise TypeError(f"a whole number is needed, not {value!r:.40}")
    return value


def _by_name(schedules: Sequence[Schedule]) -> List[Schedule]:
    return sorted(schedules, key=lambda schedule: schedule.name)
