from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading

import pytest

from cloth_sim_ros.command_line import StopFlag, free_domain, split_ros_args, stop_on_signals


@pytest.mark.parametrize(
    ("given", "ours", "for_ros"),
    [
        ("--scene a", "--scene a", ""),
        ("--scene a --ros-args -p b:=1", "--scene a", "--ros-args -p b:=1"),
        ("--ros-args -p b:=1 -- --scene a", "--scene a", "--ros-args -p b:=1 --"),
        ("x --ros-args -p b:=1 -- y --ros-args -r c:=d", "x y", "--ros-args -p b:=1 -- --ros-args -r c:=d"),
    ],
)
def test_arguments_for_ros_are_told_from_ours(given, ours, for_ros):
    assert split_ros_args(given.split()) == (ours.split(), for_ros.split())


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_set_the_event_and_nothing_else(number):
    before = {n: signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    try:
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
        stop = stop_on_signals()
        assert not stop.is_set()
        os.kill(os.getpid(), number)
        os.kill(os.getpid(), number)
        assert stop.wait(10)
    finally:
        for n, handler in before.items():
            signal.signal(n, handler)


def test_a_signal_in_the_middle_of_the_handler_of_another_locks_nothing_up():
    program = (
        "import os, signal, sys; from cloth_sim_ros.command_line import stop_on_signals; stop = stop_on_signals()\n"
        "again = iter(range(200))\n"
        "def trace(frame, event, _):\n"  # a signal at every line that a handler passes, and those of its callees
        "    if next(again, None) is not None: os.kill(os.getpid(), signal.SIGTERM)\n"
        "    return trace\n"
        "sys.settrace(trace); os.kill(os.getpid(), signal.SIGINT); sys.settrace(None)\n"
        "raise SystemExit(0 if stop.wait(10) else 1)"
    )
    assert subprocess.run([sys.executable, "-c", program], timeout=60).returncode == 0


def test_waiting_for_the_flag_ends_with_the_time_or_the_flag():
    stop = StopFlag()
    assert not stop.wait(0.0)
    assert not stop.wait(0.001)
    threading.Timer(0.01, stop.set).start()
    assert stop.wait(60)
    assert stop.wait(60)
    assert stop.is_set()


def test_under_nohup_a_closed_terminal_is_ignored():
    program = (
        "import os, signal; from cloth_sim_ros.command_line import stop_on_signals;"
        "signal.signal(signal.SIGHUP, signal.SIG_IGN); stop = stop_on_signals();"
        "os.kill(os.getpid(), signal.SIGHUP); raise SystemExit(7 if stop.is_set() else 0)"
    )
    assert subprocess.run([sys.executable, "-c", program], timeout=60).returncode == 0


def test_a_domain_in_use_is_not_free():
    domain = free_domain()
    assert 1 <= domain <= 101
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as participant:
        participant.bind(("127.0.0.1", 7410 + 250 * domain))
        assert free_domain() != domain
