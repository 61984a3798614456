"""Groups of one node, seen from outside: pinned, moved, gathered, and all of it computed again bit for bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Bool, Float64

from cloth_sim_ros.recording.recorded import RecordedSession
from cloth_sim_ros.recording.verify import verify

SIDE = 9
TOP = slice(SIDE * (SIDE - 1), SIDE * SIDE)
POINT = np.dtype([(name, "<f4") for name in ("x", "y", "z", "nx", "ny", "nz", "strain")] + [("id", "<u4")])


def edge(clouds) -> np.ndarray:
    """(9, 3) m, the top of the newest cloth."""
    points = np.frombuffer(bytes(clouds[-1].data), POINT)[TOP]
    return np.stack([points["x"], points["y"], points["z"]], axis=1)


def length(clouds) -> float:
    return float(np.linalg.norm(np.diff(edge(clouds), axis=0), axis=1).sum())


@pytest.fixture(scope="module")
def node(start_node):
    return start_node()


def test_a_group_is_pinned_moved_let_go_and_gathered_and_the_session_is_bit_equal(node, peer):
    clouds = peer.listen(PointCloud2, "cloth/points")
    pin, move = peer.speak(Bool, "group/top/pin"), peer.speak(PoseStamped, "group/top/pose", 1)
    scale = peer.speak(Float64, "group/top/rest_scale")
    goal = PoseStamped()
    goal.pose.position.x, goal.pose.position.y, goal.pose.position.z = 0.0, 0.05, 0.7

    move(goal)
    assert "nothing of the group top is pinned" in node.wait_for("group/top/pose: ")
    pin(Bool(data=True))
    peer.wait_until(
        lambda: clouds and np.allclose(edge(clouds).mean(axis=0), (0.0, 0.05, 0.7), atol=1e-6),
        "the top at its pose",
        meanwhile=lambda: move(goal),
    )
    whole = length(clouds)

    scale(Float64(data=9.0))
    assert "data = 9 (rest scale): allowed is a number 0.3 .. 3 m/m" in node.wait_for("group/top/rest_scale: ")
    scale(Float64(data=0.6))
    pin(Bool(data=False))
    peer.wait_until(lambda: abs(length(clouds) - 0.6 * whole) < 0.05 * whole, "a gathered top")

    folder = Path(node.wait_for("recording to").split("recording to")[1].strip())
    assert node.stop() == 0
    result = verify(RecordedSession(folder))
    assert result.bit_equal, result.first_difference
    assert result.steps > 25  # to get shorter by 100 %/s takes 26
