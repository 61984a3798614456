"""cloth_operator as a process of its own, heard over real Fast DDS."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

from geometry_msgs.msg import PoseStamped, Vector3Stamped
from std_msgs.msg import Float64

from cloth_core.scene import Scene
from cloth_sim_ros.command_line import StopFlag
from cloth_sim_ros.interfaces import COMMAND, NEWEST
from cloth_sim_ros.operator import play
from cloth_sim_ros.ros.qos import profile

KINDS = {
    "grasp/hand/pose": (PoseStamped, NEWEST),
    "grasp/hand/closure": (Float64, COMMAND),
    "obstacle/ball/pose": (PoseStamped, NEWEST),
    "wind": (Vector3Stamped, NEWEST),
}
SCENE = """
cloth: {grid: {width: 0.4, height: 0.4, columns: 3, rows: 3}}
obstacles: {ball: {sphere: {radius: 0.1}}, still: {sphere: {radius: 0.1}}}
grasps: {hand: {}, unused: {}}
script:
  grasps:
    hand:
      - {at: 0.0, position: [1.0, 2.0, 3.0], closure: 0.25}
      - {at: 1.0e+5, position: [1.0, 2.0, 3.0], closure: 0.25}
  obstacles: {ball: [{at: 0.0, position: [0.5, 0.0, 0.0], orientation: [0.0, 0.0, 1.0, 0.0]}]}
  wind: [{at: 0.0, velocity: [3.0, -1.0, 0.5]}]
"""


def test_the_script_is_played_over_the_topics_that_the_node_reads(peer, tmp_path):
    (tmp_path / "scene.yaml").write_text(SCENE)
    peer.namespace = "/lab/cloth"
    heard = {name: peer.listen(kind, name, profile(qos)) for name, (kind, qos) in KINDS.items()}
    command = [sys.executable, "-m", "cloth_sim_ros.operator", "--scene", str(tmp_path / "scene.yaml")]
    operator = subprocess.Popen(
        [*command, "--namespace", "/lab/cloth"], stderr=subprocess.PIPE, text=True, env=os.environ
    )
    try:
        peer.wait_until(lambda: all(heard.values()), "a message on every topic")
        topics = {name for name, _ in peer.node.get_topic_names_and_types() if name.startswith("/lab/cloth")}
    finally:
        operator.send_signal(signal.SIGINT)
        _, complaints = operator.communicate(timeout=30)
    assert (operator.returncode, complaints) == (0, "")
    assert topics == {peer.topic(name) for name in KINDS}  # nothing that the script does not mention
    pose, closure, ball, wind = (messages[-1] for messages in heard.values())
    assert (pose.pose.position.x, pose.pose.position.y, pose.pose.position.z) == (1.0, 2.0, 3.0)
    assert closure.data == 0.25
    assert (ball.pose.orientation.z, ball.pose.orientation.w) == (1.0, 0.0)
    assert (wind.vector.x, wind.vector.y, wind.vector.z) == (3.0, -1.0, 0.5)
    for message in (pose, ball, wind):
        assert message.header.frame_id == "world"
        assert message.header.stamp.sec > 0


def test_the_script_goes_by_the_time_that_passed_and_ends_when_it_is_over():
    script = Scene.parse(SCENE).script
    rest = Scene.parse(SCENE).inputs
    times, shown = [], []

    def inputs_at(seconds):
        times.append(seconds)
        return script.inputs_at(seconds, rest)

    play(inputs_at, shown.append, StopFlag(), duration=0.1)
    assert len(shown) == len(times) >= 1
    assert times == sorted(times)
    assert times[-1] < 0.1
    assert shown[0].grasps["hand"].closure == 0.25


def test_a_scene_without_a_script_is_refused_in_one_line(tmp_path):
    scene = tmp_path / "still.yaml"
    scene.write_text("cloth: {grid: {width: 1.0, height: 1.0, columns: 3, rows: 3}}\n")
    command = [sys.executable, "-m", "cloth_sim_ros.operator", "--scene", str(scene)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert done.stderr.startswith("cloth_operator: script: ")
    assert done.stderr.count("\n") == 1
