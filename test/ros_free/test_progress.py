"""The bar of long work."""

from __future__ import annotations

import io

from cloth_sim_ros.progress import ProgressBar


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_the_bar_tells_share_amount_and_time_left():
    bar = ProgressBar(60.0, "s", io.StringIO())
    assert bar.line(15.0, 3.0) == "[######..................]  25 %, 15.0 of 60.0 s, 9 s left"
    assert bar.line(70.0, 3.0).startswith("[########################] 100 %")


def test_without_a_total_it_tells_the_amount():
    assert ProgressBar(0.0, "MB", io.StringIO()).line(2.5, 1.0) == "2.5 MB"


def test_it_shows_on_a_terminal_alone():
    file, terminal = io.StringIO(), Terminal()
    for stream in (file, terminal):
        bar = ProgressBar(10.0, "s", stream)
        bar.show(5.0, ", fast")
        bar.clear()
    assert file.getvalue() == ""
    assert "50 %, 5.0 of 10.0 s" in terminal.getvalue()
    assert terminal.getvalue().endswith("\r\033[K")
