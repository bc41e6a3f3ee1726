"""Simulated time that never drifts: whole ticks, multiplied."""


class TickClock:
    """Counts periods.

    Parameters
    ----------
    period : float
        Duration of a tick [s].
    start : float
        Time at tick 0 [s].
    """

    def __init__(self, period: float, start: float = 0.0) -> None:
        self.period = period
        self.tick = 0
        self._start = start

    @property
    def now(self) -> float:
        """Present time [s]."""
        return self._start + self.tick * self.period

    def advance(self) -> float:
        """Let one period pass; the new time [s]."""
        self.tick += 1
        return self.now
