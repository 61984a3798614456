"""A bar for long work, on a terminal alone."""

from __future__ import annotations

import sys
import time
from typing import TextIO

_WIDTH = 24
_PERIOD_S = 0.1


class ProgressBar:
    """One line that updates in place, ten times a second; nothing where the stream is no terminal.

    Args:
        total: what is to be done, in ``unit``; 0 if that is not known.
        unit: of ``total`` and of what is done.
        stream: standard error by default.
    """

    def __init__(self, total: float, unit: str, stream: TextIO | None = None) -> None:
        self._total = total
        self._unit = unit
        self._stream = stream or sys.stderr
        self._shows = self._stream.isatty()
        self._start = self._next = time.monotonic()

    def show(self, done: float, remark: str = "") -> None:
        """Tell how much is done."""
        now = time.monotonic()
        if self._shows and now >= self._next:
            self._next = now + _PERIOD_S
            self._stream.write(f"\r\033[K{self.line(done, now - self._start)}{remark}")
            self._stream.flush()

    def line(self, done: float, seconds: float) -> str:
        """The bar after ``seconds`` s of work."""
        if self._total <= 0.0:
            return f"{done:.1f} {self._unit}"
        share = min(1.0, done / self._total)
        filled = int(share * _WIDTH)
        left = f", {seconds / share - seconds:.0f} s left" if share > 0.01 else ""
        bar = "#" * filled + "." * (_WIDTH - filled)
        return f"[{bar}] {100 * share:3.0f} %, {done:.1f} of {self._total:.1f} {self._unit}{left}"

    def clear(self) -> None:
        """Leave an empty line for what comes next."""
        if self._shows:
            self._stream.write("\r\033[K")
            self._stream.flush()
