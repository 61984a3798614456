"""Bad input over topics: a clear line, a count in diagnostics, the last good value stays, the node goes on."""

from __future__ import annotations

import math

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, Vector3Stamped
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Float64

GRASP, BALL, WIND = "grasp/hand/pose", "obstacle/ball/pose", "wind"


@pytest.fixture(scope="module")
def node(start_node):
    return start_node("-p", "static_transforms:=['world table 0.0 0.0 0.7 0.0 0.0 0.0 1.0']")


@pytest.fixture(autouse=True)
def unshaken(node, peer):
    """Whatever a test sent: afterwards the node publishes, and all of it is finite."""
    yield
    clouds = peer.listen(PointCloud2, "cloth/points")
    peer.wait_until(lambda: len(clouds) >= 3, "clouds after the bad input")
    for cloud in clouds:
        assert np.isfinite(np.frombuffer(bytes(cloud.data), "<f4").reshape(-1, 8)[:, :7]).all()
    assert node.alive


def pose(position=(0.0, 0.0, 0.5), orientation=(0.0, 0.0, 0.0, 1.0), frame="world", stamp=0):
    message = PoseStamped()
    message.header.frame_id = frame
    message.header.stamp.sec = stamp
    message.pose.position.x, message.pose.position.y, message.pose.position.z = position
    q = message.pose.orientation
    q.x, q.y, q.z, q.w = orientation
    return message


def wind(x, y=0.0, z=0.0, frame="world"):
    message = Vector3Stamped()
    message.header.frame_id = frame
    message.vector.x, message.vector.y, message.vector.z = x, y, z
    return message


def values(peer, reports):
    """Newest values of /diagnostics."""
    return {pair.key: pair.value for status in reports[-1].status for pair in status.values}


def reported(peer, cause, speak):
    """Wait until diagnostics count ``cause``; ``speak`` causes it. Returns the status of the inputs."""
    reports = peer.listen(DiagnosticArray, "/diagnostics")
    peer.wait_until(
        lambda: reports and f"{cause}: " in values(peer, reports)["refused_by_cause"],
        f"{cause!r} in diagnostics",
        meanwhile=speak,
    )
    return next(status for status in reports[-1].status if status.name.endswith("inputs"))


@pytest.mark.parametrize(
    ("topic", "message", "cause", "parts"),
    [
        (GRASP, pose((math.nan, 0.0, 0.0)), "pose.position", ("pose.position = (nan, 0, 0) m", "finite", "1e+06 m")),
        (BALL, pose((0.0, math.inf, 0.0)), "pose.position", ("pose.position = (0, inf, 0) m", "finite", "1e+06 m")),
        (
            BALL,
            pose(orientation=(0.0, 0.0, 0.0, 0.0)),
            "pose.orientation",
            ("pose.orientation = (0, 0, 0, 0)", "not zero"),
        ),
        (BALL, pose(frame="moon"), "header.frame_id", ("header.frame_id = 'moon'", "known are table, world")),
        (WIND, wind(math.nan), "vector", ("vector = (nan, 0, 0) m/s", "finite")),
        (WIND, wind(1.0, frame="mars"), "header.frame_id", ("header.frame_id = 'mars'", "static_transforms")),
        (WIND, wind(300.0), "capped", ("vector = (300, 0, 0) m/s", "0 .. 40 m/s", "capped")),
    ],
)
def test_a_damaged_message_is_named_and_counted(node, peer, topic, message, cause, parts):
    publish = peer.speak(type(message), topic, 1)
    status = reported(peer, f"/cloth_sim/{topic} {cause}", lambda: publish(message))
    assert status.level == DiagnosticStatus.WARN
    line = node.wait_for(f"/cloth_sim/{topic}: {parts[0]}")
    assert "[WARN]" in line
    for part in parts[1:]:
        assert part in line


def test_a_closure_out_of_range_is_named_and_counted(node, peer):
    publish = peer.speak(Float64, "grasp/hand/closure")
    reported(peer, "/cloth_sim/grasp/hand/closure data", lambda: publish(Float64(data=1.5)))
    assert "= 1.5 (closure): allowed is 0 (open) .. 1 (closed)" in node.wait_for("grasp/hand/closure: data")


def test_a_stream_of_bad_messages_is_one_line_in_a_while_not_one_each(node, peer):
    publish = peer.speak(PoseStamped, GRASP, 1)
    sent = 0

    def send():
        nonlocal sent
        sent += 1
        publish(pose((math.nan, 1.0, 2.0)))

    peer.wait_until(lambda: sent >= 150, "150 messages", meanwhile=send)
    lines = [line for line in node.output.splitlines() if "grasp/hand/pose: pose.position" in line]
    assert 1 <= len(lines) <= 8


def test_a_stamp_before_the_last_one_is_ignored_with_a_line(node, peer):
    publish = peer.speak(PoseStamped, BALL, 1)
    stamps = iter(range(2000, 1, -1))  # each a second before the one before it
    reported(peer, f"/cloth_sim/{BALL} header.stamp", lambda: publish(pose(stamp=next(stamps))))
    line = node.wait_for("before the last one")
    assert "obstacle/ball/pose: header.stamp" in line


def test_an_empty_frame_is_the_cloths_and_nothing_is_said_of_it(node, peer):
    from visualization_msgs.msg import MarkerArray

    shown = peer.listen(MarkerArray, "obstacles", 10)
    publish = peer.speak(PoseStamped, BALL, 1)
    before = len(node.output)

    def height():
        balls = [marker.pose.position.z for array in shown[-1:] for marker in array.markers if marker.ns == "ball"]
        return balls and math.isclose(balls[0], 0.7)

    peer.wait_until(height, "the ball where it was sent", meanwhile=lambda: publish(pose((0, 0, 0.7), frame="")))
    assert "frame_id" not in node.output[before:]


def test_a_pose_in_a_frame_of_the_static_transforms_is_carried_over(peer):
    from visualization_msgs.msg import MarkerArray

    shown = peer.listen(MarkerArray, "obstacles", 10)
    publish = peer.speak(PoseStamped, BALL, 1)

    def height():
        balls = [marker.pose.position.z for array in shown[-1:] for marker in array.markers if marker.ns == "ball"]
        return balls and math.isclose(balls[0], 0.9)

    peer.wait_until(
        height, "the ball 0.2 m above the table", meanwhile=lambda: publish(pose((0, 0, 0.2), frame="table"))
    )


def test_a_silent_hand_is_reported_stale(peer):
    publish = peer.speak(PoseStamped, GRASP, 1)
    reports = peer.listen(DiagnosticArray, "/diagnostics")
    sent = []
    peer.wait_until(lambda: len(sent) > 20, "some poses", meanwhile=lambda: sent.append(publish(pose((0.2, 0.2, 0.5)))))
    peer.wait_until(lambda: reports and values(peer, reports)["stale"] == "hand", "a stale hand in diagnostics")


def test_an_obstacle_that_the_scene_does_not_have_is_named_with_those_that_it_has(node, peer):
    publisher = peer.node.create_publisher(PoseStamped, "/cloth_sim/obstacle/cube/pose", 1)
    line = node.wait_for("/cloth_sim/obstacle/cube/pose")
    assert "ball, floor" in line
    reports = peer.listen(DiagnosticArray, "/diagnostics")
    peer.wait_until(
        lambda: reports and values(peer, reports)["undeclared_topics"] == "/cloth_sim/obstacle/cube/pose",
        "the undeclared topic in diagnostics",
    )
    peer.node.destroy_publisher(publisher)


def test_a_subscriber_and_a_publisher_with_incompatible_qos_are_reported(node, peer):
    best_effort = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    peer.node.create_publisher(Float64, "/cloth_sim/grasp/hand/closure", best_effort)
    line = node.wait_for("grasp/hand/closure: a publisher offers an incompatible RELIABILITY")
    assert "[WARN]" in line
    reports = peer.listen(DiagnosticArray, "/diagnostics")
    peer.wait_until(
        lambda: reports and "closure (RELIABILITY" in values(peer, reports)["incompatible_qos"],
        "the QoS in diagnostics",
    )
