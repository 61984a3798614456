"""The examples of the README, run as a reader would run them."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
from sensor_msgs.msg import PointCloud2

ROOT = Path(__file__).parents[2]


def heights(cloud: PointCloud2) -> np.ndarray:
    return np.frombuffer(bytes(cloud.data), np.float32).reshape(cloud.width, -1)[:, 2]


def lift(peer, *arguments: str) -> str:
    """What the lifter says, while the peer goes on listening."""
    command = [sys.executable, str(ROOT / "examples" / "lift_a_corner.py"), *arguments]
    lifter = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    peer.wait_until(lambda: lifter.poll() is not None, "the end of the lifter")
    said, errors = lifter.communicate()
    assert lifter.returncode == 0, errors
    assert "Traceback" not in errors
    return said + errors


def test_the_lifter_takes_the_lowest_point_of_a_cloth_and_lifts_it(start_node, peer):
    start_node()
    clouds = peer.listen(PointCloud2, "/cloth_sim/cloth/points")
    peer.wait_until(lambda: len(clouds) > 50, "a cloth that lies")
    seen = len(clouds)
    said = re.search(r"caught vertex (\d+) and lifted it by 0\.[23]\d m", lift(peer))
    assert said
    peer.wait_until(lambda: len(clouds) > seen + 2, "points after the lift")
    vertex = [heights(cloud)[int(said[1])] for cloud in clouds[seen:]]
    assert 0.2 < max(vertex) - vertex[0] < 0.35


def test_the_lifter_says_that_the_cloth_did_not_come_along(start_node, peer):
    """The hand bears less than the part of the cloth that it lifts."""
    node = start_node("-r", "__ns:=/weak", "-p", "solver.max_grasp_force:=0.1")
    clouds = peer.listen(PointCloud2, "/weak/cloth_sim/cloth/points")
    peer.wait_until(lambda: len(clouds) > 50, "a cloth that lies")
    said = lift(peer, "/weak/cloth_sim")
    assert re.search(r"caught nothing that stayed in the hand: vertex \d+ rose by -?0\.[01]", said)
    node.wait_for("grasp hand lost the cloth: it had to bear 0.")
