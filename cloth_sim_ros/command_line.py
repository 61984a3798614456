"""What the commands share: arguments meant for ROS, and ending when asked to."""

from __future__ import annotations

import argparse
import contextlib
import os
import queue
import signal
import socket
import sys
from collections.abc import Callable, Sequence
from types import FrameType


def split_ros_args(argv: Sequence[str]) -> tuple[list[str], list[str]]:
    """Arguments for us and arguments for ROS, which stand from ``--ros-args`` to ``--`` or the end."""
    ours, for_ros, inside = [], [], False
    for argument in argv:
        inside = inside or argument == "--ros-args"
        (for_ros if inside else ours).append(argument)
        inside = inside and argument != "--"
    return ours, for_ros


class StopFlag:
    """Set once and for all; a signal handler may set it, even one that interrupted another in the middle of it.

    ``threading.Event`` may not: its ``set`` takes a lock, and a second signal within the first waits for that
    lock for ever. ``SimpleQueue.put`` is the call of the standard library that is made for this.
    """

    def __init__(self) -> None:
        self._set = False
        self._wake: queue.SimpleQueue[None] = queue.SimpleQueue()

    def set(self) -> None:
        """Set the flag and wake who waits for it."""
        self._set = True
        self._wake.put(None)

    def is_set(self) -> bool:
        """Whether anybody has set it."""
        return self._set

    def wait(self, timeout: float) -> bool:
        """Block until the flag is set, ``timeout`` s at most; returns whether it is. For one thread at a time."""
        if not self._set:
            with contextlib.suppress(queue.Empty):
                self._wake.get(timeout=timeout)
        return self._set


def on_end_signals(ask: Callable[[], None]) -> None:
    """Call ``ask`` at Ctrl-C (SIGINT), SIGTERM and a closed terminal (SIGHUP, unless nohup had it ignored)."""

    def handle(_number: int, _frame: FrameType | None) -> None:
        ask()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, handle)
    if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
        signal.signal(signal.SIGHUP, handle)


def end_at_once_on_signals() -> None:
    """Until something else is asked for, signals end the process there and then, with exit code 0.

    For the second in which Python imports: there is nothing to close yet, and an exception raised in the middle of an
    import comes out as whatever the module that is being imported makes of it.
    """
    on_end_signals(lambda: os._exit(0))


def stop_on_signals() -> StopFlag:
    """A flag that every signal that asks for an end sets; further signals change nothing."""
    stop = StopFlag()
    on_end_signals(stop.set)
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
    """A ROS domain without a participant on this machine, 101 .. 1 (beyond, ports collide with Linux's own).

    From above, for people and other programs begin with the small ones.
    """
    for domain in range(101, 0, -1):
        # The port at which the first participant of a domain is reached (DDSI-RTPS 9.6.2).
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("", 7400 + 250 * domain + 10))
                return domain
            except OSError:
                continue
    raise OSError("no ROS domain from 1 to 101 is free on this machine")
