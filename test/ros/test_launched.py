"""The command lines that ``ros2 launch`` makes of the launch file: ROS arguments twice, parameters in a file."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import PointCloud2
from small_scene import SMALL_SCENE

from cloth_sim_ros.interfaces import NEWEST
from cloth_sim_ros.ros.qos import profile

SCRIPT = """
script:
  grasps:
    hand:
      - {at: 0.0, position: [0.1, 0.2, 0.3]}
      - {at: 1.0e+5, position: [0.1, 0.2, 0.3]}
"""


def test_a_node_and_its_operator_start_as_they_are_launched(start_node, peer, tmp_path):
    scene, parameters = tmp_path / "launched.yaml", tmp_path / "launch_params"
    scene.write_text(SMALL_SCENE + SCRIPT)
    parameters.write_text(
        f"/**:\n  ros__parameters:\n    record: inputs\n    scene: {scene}\n    use_sim_time: false\n"
    )
    names = ("-r", "__node:=cloth", "-r", "__ns:=/lab", "--params-file", str(parameters))
    node = start_node("--log-level", "info", "--ros-args", *names, scene="scarf")
    assert "scene launched: 81 vertices" in node.output
    peer.namespace = "/lab/cloth"
    clouds, poses = (
        peer.listen(PointCloud2, "cloth/points"),
        peer.listen(PoseStamped, "grasp/hand/pose", profile(NEWEST)),
    )
    command = [sys.executable, "-m", "cloth_sim_ros.operator", "--scene", str(scene), "--namespace", "/lab/cloth"]
    played = subprocess.Popen([*command, "--ros-args"], env=os.environ)
    try:
        peer.wait_until(lambda: clouds and poses, "a cloth and a hand")
        assert poses[-1].pose.position.z == 0.3
    finally:
        played.send_signal(signal.SIGINT)
        assert played.wait(30.0) == 0
