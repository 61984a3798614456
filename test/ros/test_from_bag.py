"""Scenes simulated with the inputs of a bag that something else recorded."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import Joy
from small_scene import SMALL_SCENE

from cloth_sim_ros import replay
from cloth_sim_ros.recording.recorded import RecordedSession
from cloth_sim_ros.recording.verify import verify

HAND, TRIGGER, OTHER = "/q2r_right_hand_pose", "/q2r_right_hand_joy", "/camera/pose"
BEGIN_NS = 1_700_000_000_000_000_000


def pose(x, y, z, frame="world"):
    message = PoseStamped()
    message.header.frame_id = frame
    message.pose.position.x, message.pose.position.y, message.pose.position.z = x, y, z
    message.pose.orientation.w = 1.0
    return message


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """Two seconds of a hand at 72 Hz that takes the free corner and lifts it by 0.3 m, written by rosbags."""
    types = get_typestore(Stores.ROS2_JAZZY)
    with Writer(tmp_path / "teleoperation", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        kinds = {HAND: "geometry_msgs/msg/PoseStamped", TRIGGER: "sensor_msgs/msg/Joy"}
        kinds[OTHER] = kinds[HAND]
        topics = {topic: writer.add_connection(topic, kind, typestore=types) for topic, kind in kinds.items()}
        for number in range(144):
            seconds = number / 72.0
            lifted = max(0.0, min(0.3, 0.3 * (seconds - 0.3)))
            stamp = BEGIN_NS + round(seconds * 1e9)
            writer.write(topics[HAND], stamp, serialize_message(pose(0.2, 0.2, 0.5 + lifted, "headset")))
            writer.write(topics[TRIGGER], stamp, serialize_message(Joy(axes=[1.0 if seconds < 1.7 else 0.0])))
            writer.write(topics[OTHER], stamp, serialize_message(pose(0.0, 0.0, 0.0)))
    return tmp_path / "teleoperation"


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    file = tmp_path / "small.yaml"
    file.write_text(SMALL_SCENE + "pins: [bottom_left]\n")
    return file


def simulated(bag, scene, *more):
    remap = ["--remap", f"{HAND}:=/cloth_sim/grasp/hand/pose"]
    return replay.main([str(bag), "--simulate", str(scene), *remap, *more])


def test_a_foreign_bag_moves_the_cloth_and_the_session_is_bit_equal_when_simulated_again(bag, scene, capsys):
    frame, closure = "world headset 0 0 0 0 0 0 1", f"hand {TRIGGER} axis 0"
    assert simulated(bag, scene, "--transform", frame, "--closure", closure) == 0
    printed = capsys.readouterr().out
    assert f"{HAND}: 144 messages used" in printed
    assert f"no input of the scene: {OTHER}" in printed
    session = RecordedSession(bag.with_name("teleoperation_small"))
    steps = list(session.steps())
    assert len(steps) == 100
    assert [step.index for step in steps if step.inputs.grasps and step.inputs.grasps["hand"].closure == 1.0] != []
    snapshots = {snapshot.index: np.array(snapshot.arrays["position"]) for snapshot in session.snapshots()}
    assert snapshots[50][80, 2] == pytest.approx(0.5 + 0.3 * 0.7, abs=0.02)  # the corner that the hand holds
    assert len(list(session.outputs("cloth/points"))) == 100
    assert verify(session).bit_equal


def test_what_is_in_an_unknown_frame_is_told_and_not_used(bag, scene, capsys):
    assert simulated(bag, scene) == 0
    assert "header.frame_id: 144 messages not used" in capsys.readouterr().err


def test_a_bag_without_any_input_names_what_it_has_and_what_would_be_one(bag, scene, capsys):
    assert replay.main([str(bag), "--simulate", str(scene)]) == 2
    complaint = capsys.readouterr().err
    assert HAND in complaint
    assert "/cloth_sim/grasp/hand/pose" in complaint


def test_a_remap_that_means_nothing_is_refused(bag, scene, capsys):
    with pytest.raises(SystemExit, match="2"):
        replay.main([str(bag), "--simulate", str(scene), "--remap", HAND])
    assert "A:=B" in capsys.readouterr().err
