"""A recording that was killed loses no more than its flush period, and becomes a complete bag again."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

import cloth_sim_ros
from cloth_sim_ros.messages import cdr
from cloth_sim_ros.session import (
    Channel,
    Qos,
    Recovery,
    SessionError,
    SessionReader,
    SessionWriter,
    find_message_type,
    recover,
)
from cloth_sim_ros.session.bag import Bag

pytest.importorskip("std_msgs", reason="no ROS message definitions are installed")

STRING = "std_msgs/msg/String"

# Records numbers for ever and says on stdout, once it is so, how many are safe from a kill.
RECORDER = """
import sys, threading
from cloth_sim_ros.messages import cdr
from cloth_sim_ros.session import SessionWriter

writer = SessionWriter(sys.argv[1], attachments={"scene.yaml": b"a: 1"}, flush_period_s=0.02)
n = reported = 0
pace = threading.Event()
while True:
    writer.write("/number", "std_msgs/msg/String", cdr.encode_string(str(n)), n)
    n += 1
    safe = writer.health.messages
    if safe > reported:
        reported = safe
        print(reported, flush=True)
    pace.wait(0.001)
"""


def texts(path) -> list[str]:
    return [cdr.decode_string(record.cdr) for record in SessionReader(path).messages()]


@pytest.fixture(scope="module")
def killed(tmp_path_factory) -> tuple[Path, int]:
    """The folder of a recording killed by SIGKILL, and how many messages it had said were safe."""
    folder = tmp_path_factory.mktemp("killed") / "session"
    environment = {**os.environ, "PYTHONPATH": str(Path(cloth_sim_ros.__file__).parents[1])}
    command = [sys.executable, "-c", RECORDER, str(folder)]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as child:
        watchdog = threading.Timer(60.0, child.kill)  # a child that hangs must not hang the tests
        watchdog.start()
        reported = 0
        for line in child.stdout:
            reported = int(line)
            if reported >= 50:
                break
        child.send_signal(signal.SIGKILL)
        child.wait()
        watchdog.cancel()
    assert reported >= 50, "the recorder ended before it had recorded enough"
    return folder, reported


def test_a_killed_recording_keeps_every_message_it_called_safe(killed):
    folder, reported = killed
    reader = SessionReader(folder)
    assert not reader.complete
    assert reader.attachments == {"scene.yaml": b"a: 1"}
    found = texts(folder)
    assert len(found) >= reported
    assert found == [str(n) for n in range(len(found))]


def test_a_killed_recording_becomes_a_bag_that_rosbags_reads(killed, tmp_path):
    highlevel = pytest.importorskip("rosbags.highlevel", reason="rosbags is not installed")
    folder, _ = killed
    expected = texts(folder)
    with pytest.raises(FileNotFoundError, match="metadata"), highlevel.AnyReader([folder]):
        pass

    recovery = recover(folder, tmp_path / "whole")
    assert recovery.topics == {"/number": len(expected)} and recovery.messages == len(expected)
    assert recovery.damaged == ()
    with highlevel.AnyReader([tmp_path / "whole"]) as bag:
        found = [bag.deserialize(data, connection.msgtype).data for connection, _, data in bag.messages()]
    assert found == expected


def test_recovering_keeps_everything_and_leaves_the_source_alone(tmp_path):
    with SessionWriter(tmp_path / "a", attachments={"x": b"1"}, metadata={"m": {"k": "v"}}) as writer:
        for n in range(10):
            writer.write(f"/topic_{n % 2}", STRING, cdr.encode_string(str(n)), 100 + n, n)
    before = (tmp_path / "a" / "a_0.mcap").read_bytes()
    recovery = recover(tmp_path / "a", tmp_path / "b")

    assert recovery == Recovery({"/topic_0": 5, "/topic_1": 5}, lost_bytes=0, damaged=())
    assert (tmp_path / "a" / "a_0.mcap").read_bytes() == before
    source, copy = SessionReader(tmp_path / "a"), SessionReader(tmp_path / "b")
    assert copy.complete
    assert (copy.attachments, copy.metadata) == (source.attachments, source.metadata)
    assert list(copy.entries()) == list(source.entries())


def test_recovering_goes_on_behind_a_damaged_chunk_and_names_it(tmp_path):
    bag = Bag(tmp_path / "a", attachments={}, metadata={})
    channel = Channel("/text", find_message_type(STRING), Qos().to_yaml())
    for n in range(5):
        bag.add(channel, cdr.encode_string(f"message {n}"), n, n)
        bag.flush()
    bag.finish()
    path = tmp_path / "a" / "a_0.mcap"
    # Short messages are stored as they are: this is inside the third chunk, and its checksum notices.
    path.write_bytes(path.read_bytes().replace(b"message 2", b"massage 2"))

    recovery = recover(path, tmp_path / "b")
    (damage,) = recovery.damaged
    assert damage.startswith(f"{path}: the record at byte ") and "crc" in damage
    assert texts(tmp_path / "b") == ["message 0", "message 1", "message 3", "message 4"]
    assert SessionReader(tmp_path / "b").complete


def test_recovering_into_a_folder_that_holds_something_is_refused(tmp_path):
    with SessionWriter(tmp_path / "a"):
        pass
    with pytest.raises(SessionError, match="the folder is not empty"):
        recover(tmp_path / "a", tmp_path / "a")
    assert SessionReader(tmp_path / "a").complete


def test_recovering_what_is_no_session_leaves_no_folder_behind(tmp_path):
    with pytest.raises(SessionError, match="no such session"):
        recover(tmp_path / "nothing", tmp_path / "b")
    assert not (tmp_path / "b").exists()
