"""The one line that says how a running simulation does."""

from __future__ import annotations

import shutil
import sys
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import TextIO


def describe(values: Mapping[str, str]) -> str:
    """The line, from the values that the node's /diagnostics carry."""
    get = values.get
    paused = "paused  " if get("paused") == "true" else ""
    parts = [
        f"{paused}{float(get('time_s', 0.0)):7.2f} s",
        f"{float(get('rate_hz', 0.0)):5.1f} Hz",
        f"step {float(get('step_p50_ms', 0.0)):4.1f} ms (p99 {float(get('step_p99_ms', 0.0)):4.1f})",
        f"stretch {float(get('max_stretch', 1.0)):.3f}",
        f"holds {get('held_by', 'nothing')}",
        f"lag {float(get('lag_s', 0.0)):.2f} s, {get('missed_slots', '0')} missed",
        _session(get("session_folder", "none"), get("session_error", "none")),
    ]
    return " | ".join(parts)


def _session(folder: str, error: str) -> str:
    if folder == "none":
        return "not recording"
    where = f"log {shortened(folder)}"
    return where if error == "none" else f"{where} FAILED"


def shortened(path: str | Path) -> str:
    """A path with the home folder as ``~``."""
    home = str(Path.home())
    text = str(path)
    return "~" + text[len(home) :] if text.startswith(home + "/") else text


class StatusLine:
    """Updates in place on a terminal; elsewhere every update is a line. Other lines go above it.

    Args:
        stream: standard output by default.
    """

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = stream or sys.stdout
        self._in_place = self._stream.isatty()
        self._shown = ""
        self._lock = threading.Lock()

    def show(self, text: str) -> None:
        """Replace the status."""
        with self._lock:
            if self._in_place:
                self._shown = text[: shutil.get_terminal_size().columns - 1]
                self._write(f"\r\033[K{self._shown}")
            else:
                self._write(text + "\n")

    def say(self, text: str) -> None:
        """Print a line that stays."""
        with self._lock:
            if self._shown:
                self._write(f"\r\033[K{text}\n{self._shown}")
            else:
                self._write(text + "\n")

    def finish(self) -> None:
        """Leave the last status where it is and go on below it."""
        with self._lock:
            if self._shown:
                self._write("\n")
            self._shown = ""

    def _write(self, text: str) -> None:
        self._stream.write(text)
        self._stream.flush()
