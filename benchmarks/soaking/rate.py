"""How regularly clouds go out, with a recorder and two subscribers."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from marks.row import Row
from rclpy.qos import QoSProfile
from visualization_msgs.msg import Marker

from cloth_sim_ros.launcher.children import Child
from soaking.node import NAME, Node, running
from soaking.scenes import hanging

SETTLING_S = 3.0
_SECOND = """
import rclpy
from rclpy.qos import QoSProfile
from sensor_msgs.msg import PointCloud2
rclpy.init()
node = rclpy.create_node("second")
node.create_subscription(PointCloud2, "/cloth_sim/cloth/points", lambda _cdr: None, QoSProfile(depth=5), raw=True)
rclpy.spin(node)
"""


def small(folder: Path, seconds: float) -> Iterator[Row]:
    """2,500 vertices: points and mesh at 50 Hz, recorder, two subscribers."""
    yield from _rows("2,500 vertices", "drape", folder, seconds, 4.0, 1.0, (0.1, 0.0))


def large(folder: Path, seconds: float) -> Iterator[Row]:
    """10,000 vertices: points at 50 Hz, mesh at 10 Hz."""
    yield from _rows("10,000 vertices", hanging(folder, 100), folder, seconds, 4.0, 1.0, (1.0, 0.1))


def _rows(
    what: str, scene: str | Path, folder: Path, seconds: float, bar: float, aim: float, missed: tuple[float, float]
) -> Iterator[Row]:
    with running(scene, folder) as node:
        meshes = _listen_to_mesh(node)
        second = Child("second", [sys.executable, "-c", _SECOND], lambda _line: None)
        try:
            node.spin(SETTLING_S)
            node.clouds.clear()
            meshes.clear()
            before = _late(node)
            node.spin(seconds)
            late = _late(node) - before
        finally:
            second.stop()
        step = f"step p50 {node.peer.values['step_p50_ms']} ms"
    stamp, published, _ = np.array([cloud[:3] for cloud in node.clouds]).T
    rate = (len(published) - 1) * 1e9 / (published[-1] - published[0])
    slot = np.round((stamp - stamp[0]) / 20e6)
    instant = published - published[0] - slot * 20e6
    jitter = np.abs(instant - np.median(instant)) * 1e-6
    where = f"{what}, {seconds:g} s"
    yield Row(f"{where}: off 50 Hz", "Hz", 0.05, 0.005, abs(50.0 - rate), note=step)
    yield Row(f"{where}: jitter, p99", "ms", bar, aim, float(np.percentile(jitter, 99)))
    yield Row(f"{where}: slots missed or skipped", "%", *missed, 100.0 * late / (seconds * 50.0))
    lost = slot[-1] + 1 - len(np.unique(slot))
    yield Row(f"{where}: clouds that did not arrive", "%", *missed, 100.0 * lost / (slot[-1] + 1))
    wanted = 50.0 if what.startswith("2") else 10.0
    yield Row(
        f"{where}: mesh off {wanted:g} Hz", "Hz", 0.02 * wanted, 0.005 * wanted, abs(len(meshes) / seconds - wanted)
    )


def _listen_to_mesh(node: Node) -> list[int]:
    arrived: list[int] = []
    node.peer.node.create_subscription(
        Marker, f"{NAME}/cloth/mesh", lambda cdr: arrived.append(len(cdr)), QoSProfile(depth=5), raw=True
    )
    return arrived


def _late(node: Node) -> float:
    """Slots missed and skipped since the start."""
    updates = node.peer.updates
    node.wait(lambda: node.peer.updates > updates)
    return float(node.peer.values["missed_slots"]) + float(node.peer.values["skipped_slots"])
