"""What the commands share: arguments meant for ROS, and ending when asked to."""

from __future__ import annotations

import argparse
import signal
import socket
import sys
import threading
from collections.abc import Sequence
from types import FrameType


def split_ros_args(argv: Sequence[str]) -> tuple[list[str], list[str]]:
    """Arguments for us and arguments for ROS, which stand from ``--ros-args`` to ``--`` or the end."""
    ours, for_ros, inside = [], [], False
    for argument in argv:
        inside = inside or argument == "--ros-args"
        (for_ros if inside else ours).append(argument)
        inside = inside and argument != "--"
    return ours, for_ros


def stop_on_signals() -> threading.Event:
    """An event that Ctrl-C (SIGINT), SIGTERM or a closed terminal sets; further signals change nothing."""
    stop = threading.Event()

    def ask(_number: int, _frame: FrameType | None) -> None:
        stop.set()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, ask)
    if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:  # nohup
        signal.signal(signal.SIGHUP, ask)
    return stop


def seconds(text: str) -> float:
    """A ``--duration`` in s; ``argparse`` shows the error."""
    try:
        duration = float(text)
    except ValueError:
        duration = -1.0
    if not duration > 0.0:
        raise argparse.ArgumentTypeError(f"{text} is not a number of seconds above 0")
    return duration


def complain(command: str, problem: object) -> None:
    """One line on stderr, without a traceback."""
    print(f"{command}: {problem}", file=sys.stderr)


def free_domain() -> int:
    """A ROS domain without a participant on this machine, 1 .. 101 (beyond, ports collide with Linux's own)."""
    for domain in range(1, 102):
        # The port at which the first participant of a domain is reached (DDSI-RTPS 9.6.2).
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("", 7400 + 250 * domain + 10))
                return domain
            except OSError:
                continue
    raise OSError("no ROS domain from 1 to 101 is free on this machine")
