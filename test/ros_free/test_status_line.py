from __future__ import annotations

import io
from pathlib import Path

from cloth_sim_ros.launcher.status_line import StatusLine, describe, shortened

VALUES = {
    "time_s": "12.34",
    "rate_hz": "50.01",
    "step_p50_ms": "7.10",
    "step_p99_ms": "9.80",
    "max_stretch": "1.0312",
    "held_by": "hand (12)",
    "lag_s": "0.04",
    "missed_slots": "3",
    "session_folder": "/data/sessions/scarf",
    "session_error": "none",
    "paused": "false",
}


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_the_line_says_everything_that_matters():
    line = describe(VALUES)
    for part in (
        "12.34 s",
        "50.0 Hz",
        "step  7.1 ms (p99  9.8)",
        "stretch 1.031",
        "holds hand (12)",
        "lag 0.04 s, 3 missed",
    ):
        assert part in line
    assert line.endswith("log /data/sessions/scarf")


def test_a_recording_that_failed_or_is_off_is_said():
    assert describe({**VALUES, "session_error": "disk full"}).endswith("log /data/sessions/scarf FAILED")
    assert describe({**VALUES, "session_folder": "none"}).endswith("not recording")


def test_a_pause_is_said():
    assert describe({**VALUES, "paused": "true"}).startswith("paused")


def test_a_node_that_says_nothing_yet_is_no_error():
    assert "holds nothing" in describe({})


def test_the_home_folder_is_a_tilde():
    assert shortened(Path.home() / "a") == "~/a"
    assert shortened("/elsewhere/a") == "/elsewhere/a"


def test_on_a_terminal_the_status_is_replaced_and_other_lines_stay_above_it(monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    terminal = Terminal()
    line = StatusLine(terminal)
    line.show("first")
    line.say("a warning")
    line.show("x" * 100)
    line.finish()
    shown = terminal.getvalue().split("\r\033[K")
    assert shown == ["", "first", "a warning\nfirst", "x" * 39 + "\n"]


def test_without_a_terminal_every_status_is_a_line():
    stream = io.StringIO()
    line = StatusLine(stream)
    line.show("first")
    line.say("a warning")
    line.show("x" * 200)
    line.finish()
    assert stream.getvalue().splitlines() == ["first", "a warning", "x" * 200]
