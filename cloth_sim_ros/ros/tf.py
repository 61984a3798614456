"""Frames from tf, where tf2_ros is installed."""

from __future__ import annotations

from rclpy.node import Node
from rclpy.time import Time

from cloth_core import Pose
from cloth_sim_ros.simulation.frames import Lookup


def tf_lookup(node: Node) -> Lookup | None:
    """A function that asks tf for the newest transform; None where tf2_ros is not installed."""
    try:
        import tf2_ros
    except ImportError:
        return None
    buffer = tf2_ros.Buffer(node=node)
    listener = tf2_ros.TransformListener(buffer, node, spin_thread=False)

    def lookup(target: str, source: str) -> Pose | None:
        _ = listener  # lives as long as the function
        try:
            found = buffer.lookup_transform(target, source, Time()).transform
        except tf2_ros.TransformException:
            return None
        at, turn = found.translation, found.rotation
        return Pose((at.x, at.y, at.z), (turn.x, turn.y, turn.z, turn.w))

    return lookup
