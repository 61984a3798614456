"""Warnings that come once or every few seconds, not fifty times a second, and the counts behind them."""

from __future__ import annotations

import time
from collections.abc import Callable


class Notices:
    """Says each cause at most once in a while, and counts how often it came.

    Args:
        log: writes one line.
        period: s between two lines of the same cause.
        clock: monotonic s.
    """

    def __init__(
        self, log: Callable[[str], None], *, period: float = 5.0, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.counts: dict[str, int] = {}
        self._log = log
        self._period = period
        self._clock = clock
        self._said: dict[str, float] = {}
        self._latest: dict[str, tuple[float, str]] = {}

    def say(self, cause: str, text: str) -> None:
        """Count ``cause``; log ``text`` unless the same cause was logged within the period."""
        self.counts[cause] = self.counts.get(cause, 0) + 1
        now, count = self._clock(), self.counts[cause]
        text = text if count == 1 else f"{text} ({count} times so far)"
        self._latest[cause] = (now, text)
        if now - self._said.get(cause, -float("inf")) >= self._period:
            self._said[cause] = now
            self._log(text)

    def within(self, seconds: float) -> list[str]:
        """The newest text of each cause that came in the last ``seconds`` s, the latest first."""
        now = self._clock()
        lately = [(at, text) for at, text in dict(self._latest).values() if now - at <= seconds]
        return [text for _, text in sorted(lately, key=lambda said: -said[0])]

    def as_text(self) -> str:
        """``cause: count`` of everything counted, the most frequent first."""
        ordered = sorted(dict(self.counts).items(), key=lambda item: -item[1])
        return "; ".join(f"{cause}: {count}" for cause, count in ordered)
