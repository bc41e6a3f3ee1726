"""Robots that live in one process: for tests, and to try a fleet on a laptop. Can be as unkind as a network."""

import random
from typing import Dict, List, Optional, Sequence

from social_fleet.coordination.schedule import FleetSchedule
from social_fleet.errors import InvalidParameter
from social_fleet.fleet.participant import Participant
from social_fleet.fleet.transport import Transport


class InProcessNetwork:
    """Carries messages between the transports that have joined it; who joins late has missed what was said before.

    Parameters
    ----------
    seed : int, optional
        Deliver in random order and with random delays, the same for the same seed; in order and at once by default.
    losses, duplicates : float
        Probabilities that a message does not reach a robot, and that it does so twice; they need a seed.

    Raises
    ------
    InvalidParameter
        When a probability is out of range, or there is one without a seed.
    """

    def __init__(self, seed: Optional[int] = None, *, losses: float = 0.0, duplicates: float = 0.0) -> None:
        for value, field in ((losses, "losses"), (duplicates, "duplicates")):
            if not 0.0 <= value < 1.0:
                raise InvalidParameter(f"must be at least 0 and below 1, not {value!r}", field=field)
            if value > 0.0 and seed is None:
                raise InvalidParameter("needs a seed", field=field)
        self._random = None if seed is None else random.Random(seed)
        self._losses = losses
        self._duplicates = duplicates
        self._pending: List[List[bytes]] = []

    def join(self) -> Transport:
        """A transport for one more robot."""
        self._pending.append([])
        return _InProcessTransport(self, len(self._pending) - 1)

    def send(self, sender: int, message: bytes) -> None:
        """Put a message on the way to all but its sender."""
        for receiver, pending in enumerate(self._pending):
            if receiver != sender:
                pending += [message] * self._copies()

    def take(self, receiver: int) -> List[bytes]:
        """What reaches a robot now: all that is on the way, or a random part of it."""
        pending = self._pending[receiver]
        count = len(pending)
        if self._random is not None:
            self._random.shuffle(pending)
            count = self._random.randint(0, count)
        taken, pending[:count] = pending[:count], []
        return taken

    def _copies(self) -> int:
        if self._random is None:
            return 1
        if self._random.random() < self._losses:
            return 0
        return 2 if self._random.random() < self._duplicates else 1


class _InProcessTransport(Transport):
    """A place in an `InProcessNetwork`."""

    def __init__(self, network: InProcessNetwork, place: int) -> None:
        self._network = network
        self._place = place

    def send(self, message: bytes) -> None:
        self._network.send(self._place, message)

    def receive(self) -> List[bytes]:
        return self._network.take(self._place)


def run_together(participants: Sequence[Participant], *, step: float = 0.05, start: float = 0.0
                 ) -> Dict[str, FleetSchedule]:
    """Poll robots in turn on a clock of their own until each has the fleet's schedule.

    Parameters
    ----------
    participants : sequence of Participant
        Those that are alive; ends even when others are not, for no participant waits for ever.
    step, start : float
        What the clock gains per turn [s], and where it starts [s].

    Returns
    -------
    dict of str to FleetSchedule
        By robot; equal for all.

    Raises
    ------
    SilentRobot, Disagreement, Infeasible, TimedOut, SolverFailed
        What the first robot that fails raises.
    """
    now = start
    found: Dict[str, FleetSchedule] = {}
    while len(found) < len(participants):
        for participant in participants:
            schedule = participant.poll(now)
            if schedule is not None:
                found[participant.name] = schedule
        now += step
    return found
