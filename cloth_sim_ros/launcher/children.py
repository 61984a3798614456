"""Other programs that a command starts, watches and ends."""

from __future__ import annotations

import collections
import contextlib
import os
import signal
import subprocess
import threading
from collections.abc import Callable, Sequence

_KEPT_LINES = 12
_READ_WITHIN_S = 5.0


class Child:
    """A program in a session of its own, so that Ctrl-C reaches us and not it.

    Args:
        name: for messages.
        command: program and arguments.
        on_line: gets every line that it prints, in a thread of its own.
    """

    def __init__(self, name: str, command: Sequence[str], on_line: Callable[[str], None]) -> None:
        self.name = name
        self._on_line = on_line
        self._last: collections.deque[str] = collections.deque(maxlen=_KEPT_LINES)
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
            start_new_session=True,
        )
        self._reader = threading.Thread(target=self._read, name=f"output of {name}", daemon=True)
        self._reader.start()

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def exit_code(self) -> int | None:
        """None while it runs; -N when signal N ended it."""
        return self._process.poll()

    @property
    def last_lines(self) -> list[str]:
        """The end of what it printed."""
        return list(self._last)

    def stop(self, patience: float = 10.0) -> int:
        """Send SIGINT; SIGKILL after ``patience`` s. Returns the exit code, negative if it had to be killed."""
        if self.exit_code is None:
            self._signal(signal.SIGINT)
        try:
            self._process.wait(patience)
        except subprocess.TimeoutExpired:
            self._signal(signal.SIGKILL)
            self._process.wait()
        self._reader.join(_READ_WITHIN_S)  # whoever inherited its output may keep it open for longer
        return self._process.returncode

    def _signal(self, number: signal.Signals) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, number)

    def _read(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as printed:
            for line in printed:
                self._last.append(line.rstrip())
                self._on_line(line.rstrip())
