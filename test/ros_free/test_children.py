from __future__ import annotations

import os
import signal
import sys
import threading

import pytest

from cloth_sim_ros.launcher.children import Child

READY = "print('ready', flush=True)"
STUBBORN = f"import signal, time; signal.signal(signal.SIGINT, signal.SIG_IGN); {READY}; time.sleep(600)"
# A shell that starts us in the background has SIGINT ignored, and children inherit that.
POLITE = f"""
import signal, time
signal.signal(signal.SIGINT, signal.default_int_handler)
try:
    {READY}
    time.sleep(600)
except KeyboardInterrupt:
    print('bye')
"""


@pytest.fixture
def child():
    """Starts a Python program and waits until it says ready."""
    started = []

    def start(program: str) -> Child:
        ready = threading.Event()
        process = Child("test", [sys.executable, "-c", program], lambda line: ready.set() if line == "ready" else None)
        started.append(process)
        assert ready.wait(60)
        return process

    yield start
    for process in started:
        process.stop(0.0)


def test_a_child_ends_at_sigint_and_its_last_words_are_kept(child):
    process = child(POLITE)
    assert process.exit_code is None
    assert process.stop(60.0) == 0
    assert process.last_lines == ["ready", "bye"]


def test_a_child_that_ignores_sigint_is_killed(child):
    assert child(STUBBORN).stop(0.1) == -signal.SIGKILL


def test_stopping_again_changes_nothing(child):
    process = child(POLITE)
    assert process.stop(60.0) == process.stop(60.0) == 0


def test_a_child_is_out_of_reach_of_our_terminal(child):
    process = child(POLITE)
    assert os.getsid(process.pid) == process.pid != os.getsid(0)


def test_only_the_last_lines_are_kept(child):
    process = child(f"for n in range(100): print(n)\n{POLITE}")
    assert process.stop(60.0) == 0
    assert process.last_lines[-3:] == ["99", "ready", "bye"]
    assert len(process.last_lines) == 12
