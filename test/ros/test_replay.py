"""cloth_replay publishing a session, heard by a real subscriber."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from sensor_msgs.msg import PointCloud2

from cloth_core.scene import Scene
from cloth_sim_ros.interfaces import LATCHED, STREAM
from cloth_sim_ros.messages.cdr import PointCloudEncoder, encode_string, encode_triangles
from cloth_sim_ros.recording.recorder import Recorder
from cloth_sim_ros.ros.qos import profile
from cloth_sim_ros.session import SessionReader, SessionWriter

POINTS = "sensor_msgs/msg/PointCloud2"
COUNT = 20
STEP_NS = 20_000_000


@pytest.fixture
def session(tmp_path) -> tuple[Path, list[bytes], bytes]:
    """A session with some clouds and a latched list of triangles, and what is in it."""
    scene = Scene.parse("cloth: {grid: {width: 1, height: 1, columns: 5, rows: 5}}")
    solver, state = scene.build()
    recorder = Recorder.open(tmp_path / "s", scene, {}, solver, "/cloth_sim", record="all")
    recorder.snapshot(solver.snapshot(state), 0, STEP_NS)
    triangles = encode_triangles("world", STEP_NS, solver.mesh.triangles)
    recorder.output("/cloth_sim/cloth/triangles", POINTS, triangles, STEP_NS, qos=LATCHED)
    clouds = []
    for number in range(1, COUNT + 1):
        position = state.position + number
        cloud = PointCloudEncoder("world").encode(number * STEP_NS, position, position * 0, np.zeros(25))
        recorder.output("/cloth_sim/cloth/points", POINTS, cloud, number * STEP_NS, qos=STREAM)
        clouds.append(cloud)
    recorder.close()
    return tmp_path / "s", clouds, triangles


def replay(*arguments: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "cloth_sim_ros.replay", *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ)


def test_a_session_is_published_again_byte_for_byte_under_another_name(peer, session):
    path, clouds, triangles = session
    heard: list[bytes] = []
    latched: list[bytes] = []
    late_joiner = profile(LATCHED)  # matches a latched publisher only
    peer.node.create_subscription(PointCloud2, "/again/cloth/triangles", latched.append, late_joiner, raw=True)
    peer.node.create_subscription(PointCloud2, "/again/cloth/points", heard.append, 100, raw=True)
    process = replay(str(path), "--namespace", "/again", "--wait", "--loop")
    try:
        peer.wait_until(lambda: len(heard) > COUNT and latched, "more than one round of messages")
        topics = [name for name, _ in peer.node.get_topic_names_and_types() if name.startswith("/again")]
    finally:
        process.terminate()
        printed, complaints = process.communicate(timeout=30)
    assert (process.returncode, complaints) == (0, "")
    assert without_padding(latched[0], triangles) == triangles
    heard = [without_padding(message, clouds[0]) for message in heard]
    start = clouds.index(heard[0])  # a subscriber may match late
    expected = (clouds[start:] + clouds * (len(heard) // COUNT + 1))[: len(heard)]
    assert heard == expected
    assert sorted(topics) == ["/again/cloth/points", "/again/cloth/triangles"]
    assert "messages published" in printed


def without_padding(received: bytes, sent: bytes) -> bytes:
    """The middleware fills messages up to a multiple of four bytes."""
    assert len(received) - len(sent) in range(4)
    return received[: len(sent)]


def test_without_a_loop_it_ends_by_itself(session):
    path, _, _ = session
    process = replay(str(path), "--rate", "100")
    printed, complaints = process.communicate(timeout=60)
    assert (process.returncode, complaints) == (0, "")
    assert f"{COUNT + 1} messages published" in printed


def test_a_part_is_published_with_what_was_latched_before_it(session):
    path, _, _ = session
    process = replay(str(path), "--rate", "100", "--from", "0.09", "--to", "0.21")
    printed, complaints = process.communicate(timeout=60)
    assert (process.returncode, complaints) == (0, "")
    # The snapshot is at 0.02 s, as are the triangles; clouds of 0.12 to 0.22 s, then.
    assert "7 messages published" in printed


def test_a_bag_of_something_else_is_published_under_the_names_that_a_node_reads(peer, session, tmp_path):
    _, clouds, _ = session
    with SessionWriter(tmp_path / "foreign") as writer:
        for number in range(3):
            writer.write("/theirs", POINTS, clouds[number], number * STEP_NS + 1)
    heard: list[bytes] = []
    peer.node.create_subscription(PointCloud2, "/ours/points", heard.append, 100, raw=True)
    process = replay(str(tmp_path / "foreign"), "--wait", "--loop", "--remap", "/theirs:=/ours/points")
    try:
        peer.wait_until(lambda: len(heard) >= 3, "the clouds under another name")
    finally:
        process.terminate()
        _, complaints = process.communicate(timeout=30)
    assert (process.returncode, complaints) == (0, "")
    assert {without_padding(message, clouds[0]) for message in heard} <= set(clouds[:3])


def test_a_type_that_is_not_installed_is_named(session, tmp_path, monkeypatch):
    definition = tmp_path / "prefix" / "share" / "odd_msgs" / "msg" / "Odd.msg"
    definition.parent.mkdir(parents=True)
    definition.write_text("string data\n")
    reader = SessionReader(session[0])
    with monkeypatch.context() as installed:
        installed.setenv("AMENT_PREFIX_PATH", str(tmp_path / "prefix"))
        with SessionWriter(tmp_path / "odd", attachments=reader.attachments, metadata=reader.metadata) as writer:
            writer.write("/cloth_sim/odd", "odd_msgs/msg/Odd", encode_string("x"), 1)
    process = replay(str(tmp_path / "odd"))
    _, complaints = process.communicate(timeout=60)
    assert process.returncode == 2
    assert complaints.startswith(
        "cloth_replay: the session has messages of type odd_msgs/msg/Odd, which is not installed"
    )
    assert complaints.count("\n") == 1
