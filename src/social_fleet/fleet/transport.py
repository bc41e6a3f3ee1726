"""What the protocols need of whatever carries messages between robots."""

from abc import ABC, abstractmethod
from typing import List


class Transport(ABC):
    """One robot's way to all others of its fleet.

    The protocols bear messages that come late, in another order, more than once, or back to their sender, and repeat
    what may have been lost. A message that arrives is whole: it is never cut nor changed. One that is sent from
    another thread than it is received in is the transport's business.
    """

    @abstractmethod
    def send(self, message: bytes) -> None:
        """Hand a message on to all other robots; does not wait for anybody."""

    @abstractmethod
    def receive(self) -> List[bytes]:
        """The messages that have come since the last call, in any order; does not wait for any."""
