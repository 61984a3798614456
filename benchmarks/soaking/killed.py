"""Nodes that are ended: with SIGKILL while they record, and by signals at any moment."""

from __future__ import annotations

import os
import random
import signal
import time
from collections.abc import Iterator
from pathlib import Path

from marks.row import Row
from rosbags.highlevel import AnyReader

from cloth_sim_ros.recording.recorded import RecordedSession
from cloth_sim_ros.recording.verify import verify
from cloth_sim_ros.session import recover
from soaking.node import Node, running
from soaking.scenes import hanging

END_WITHIN_S = 20.0


def kill_9(folder: Path, seconds: float) -> Iterator[Row]:
    """What kill -9 takes from a session, and whether other tools read what was recovered."""
    lost, unreadable, different = [], 0, 0
    for number in range(max(4, int(seconds / 20.0))):
        record = ("outputs", "inputs")[number % 2]
        with running("drape", folder / f"{number}", record=record) as node:
            node.spin(random.uniform(2.0, 5.0))
            last_cloud = node.clouds[-1][0]
            os.killpg(node.process.pid, signal.SIGKILL)
            node.process.stop()
            session = node.session
        recover(session, folder / f"recovered_{number}")
        recovered = RecordedSession(folder / f"recovered_{number}")
        stamps = [stamp for stamp, entry in recovered.entries() if type(entry).__name__ == "Step"]
        lost.append((last_cloud - stamps[-1]) * 1e-9)
        with AnyReader([folder / f"recovered_{number}"]) as reader:
            unreadable += sum(1 for _ in reader.messages()) == 0
        different += not verify(recovered).bit_equal
    note = f"{len(lost)} times, recording outputs or inputs alone, mean {sum(lost) / len(lost):.2f} s"
    yield Row("kill -9 in a recording: lost, at most", "s", 1.0, 0.2, max(lost), note=note)
    yield Row(
        "kill -9: recovered sessions that rosbags cannot read, or that do not verify", "", 0, 0, unreadable + different
    )


def restarts(folder: Path, seconds: float) -> Iterator[Row]:
    """Start and stop, by SIGINT or SIGTERM at any moment."""
    count = 50 if seconds >= 60.0 else 10
    bad: list[str] = []
    scene = hanging(folder, 15)
    for number in range(count):
        bad += _one(scene, folder / f"{number}", random.Random(number))
    yield Row(f"{count} starts and stops at any moment: not clean", "", 0.0, 0.0, len(bad), note="; ".join(bad[:3]))


def _one(scene: Path, folder: Path, chance: random.Random) -> list[str]:
    node = Node(scene, folder)
    time.sleep(chance.uniform(0.0, 4.0))
    number = chance.choice((signal.SIGINT, signal.SIGTERM))
    os.killpg(node.process.pid, number)
    if chance.random() < 0.3:
        os.killpg(node.process.pid, number)
    end = time.monotonic() + END_WITHIN_S
    while node.process.exit_code is None and time.monotonic() < end:
        time.sleep(0.02)
    code, problems = node.process.exit_code, []
    node.close()
    # Before Python can install a handler a signal ends it by itself.
    if code not in (0, -number) or (code == -number and node.lines):
        problems.append(f"exit code {code} after {len(node.lines)} lines")
    if any("Traceback" in line for line in node.lines):
        problems.append("a traceback")
    if _alive(node.process.pid):
        problems.append("an orphan")
    for session in folder.iterdir() if folder.is_dir() else ():
        if not RecordedSession(session).complete:
            problems.append("an incomplete session")
    return problems


def _alive(group: int) -> bool:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True
