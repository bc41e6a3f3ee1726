"""Messages between robots and dispatcher that may be lost, and come late or in another order."""

import heapq
import random
from dataclasses import dataclass
from typing import Any, List, Sequence, Tuple

from social_fleet.parameters import Parameters, parameter


@dataclass(frozen=True)
class NetworkConfig(Parameters):
    """How unkind the network is.

    Raises
    ------
    InvalidParameter
        When a value is of a wrong type or out of range; `field` names it.
    """

    loss: float = parameter(0.0, minimum=0.0, maximum=0.9)  # share of messages that do not arrive [-]
    latency: float = parameter(0.0, minimum=0.0)  # of all that do [s]
    late: float = parameter(0.0, minimum=0.0, maximum=1.0)  # share of those that take longer [-]
    delay: float = parameter(0.0, minimum=0.0)  # by up to so much [s]
    seed: int = parameter(0, minimum=0)


class Network:
    """Carries messages; the same seed gives the same fate of each.

    Parameters
    ----------
    config : NetworkConfig
        Losses and delays.
    """

    def __init__(self, config: NetworkConfig = NetworkConfig()) -> None:
        self._config = config
        self._random = random.Random(config.seed)
        self._under_way: List[Tuple[float, int, str, Any]] = []
        self._count = 0

    def send(self, now: float, receivers: Sequence[str], message: Any) -> None:
        """Send `message` at `now` [s]; each receiver's copy has a fate of its own."""
        config = self._config
        for receiver in receivers:
            if config.loss > 0.0 and self._random.random() < config.loss:
                continue
            arrives = now + config.latency
            if config.late > 0.0 and self._random.random() < config.late:
                arrives += self._random.uniform(0.0, config.delay)
            self._count += 1
            heapq.heappush(self._under_way, (arrives, self._count, receiver, message))

    def arrived(self, now: float) -> List[Tuple[str, Any]]:
        """Receivers and messages that come at `now` [s] or before."""
        found: List[Tuple[str, Any]] = []
        while self._under_way and self._under_way[0][0] <= now + 1e-9:
            _, _, receiver, message = heapq.heappop(self._under_way)
            found.append((receiver, message))
        return found
