"""Speaking and listening within one round: everything is said until it need not be, and heard once."""

import logging
import math
from typing import Dict, Iterator, List, Optional, Sequence, Tuple

from social_fleet.errors import Disagreement, InvalidMessage
from social_fleet.fleet.encoding import decode
from social_fleet.fleet.messages import Message
from social_fleet.fleet.transport import Transport

log = logging.getLogger(__name__)


class Conversation:
    """What one robot says to the others of a round, and hears from them.

    Parameters
    ----------
    name : str
        The robot's.
    key : str
        The round's; messages of others are not for this one.
    members : sequence of str
        The robots of the round.
    transport : Transport
    repeat : float
        After what time everything is said again [s].

    Attributes
    ----------
    heard_at : dict of str to float
        When each robot was heard of last [s].
    """

    def __init__(self, name: str, key: str, members: Sequence[str], transport: Transport, repeat: float) -> None:
        self.heard_at: Dict[str, float] = {}
        self._name = name
        self._key = key
        self._members = members
        self._transport = transport
        self._repeat = repeat
        self._said: List[bytes] = []
        self._said_at = -math.inf
        self._senders: Dict[bytes, Optional[str]] = {}  # of all that was heard; None of what is of no use

    def say(self, content: bytes, now: float) -> None:
        """Tell all others, now and again."""
        self._said.append(content)
        self._transport.send(content)
        self._said_at = now

    def repeat(self, now: float) -> None:
        """Say everything again when it is time to."""
        if now - self._said_at >= self._repeat:
            for content in self._said:
                self._transport.send(content)
            self._said_at = now

    def listen(self, now: float) -> Iterator[Tuple[Message, bytes]]:
        """What is new, and its bytes; what is of another round, or cannot be read, counts as not heard.

        Raises
        ------
        Disagreement
            When another robot goes by this one's name.
        """
        for content in self._transport.receive():
            message = self._understood(content) if content not in self._senders else None
            sender = self._senders[content]
            if sender is not None:
                self.heard_at[sender] = now
            if message is not None:
                yield message, content

    def discard(self) -> None:
        """Hear what came without listening, so that it does not pile up."""
        self._transport.receive()

    def _understood(self, content: bytes) -> Optional[Message]:
        """The message, noted as heard; None when it is not for this robot or its own."""
        self._senders[content] = None
        if content in self._said:
            return None
        try:
            message = decode(content)
        except InvalidMessage as error:
            log.warning("robot %s: message refused: %s", self._name, error)
            return None
        if message.round != self._key or message.sender not in self._members:
            return None
        if message.sender == self._name:
            raise Disagreement(f"another robot goes by the name of {self._name}; names must differ",
                               robots=[self._name])
        self._senders[content] = message.sender
        return message
