"""A node under test, and the peer that talks to it."""

from __future__ import annotations

import os
import re
import struct
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from rclpy.qos import QoSProfile
from sensor_msgs.msg import PointCloud2

from cloth_sim_ros.launcher.children import Child
from cloth_sim_ros.ros.listen import DiagnosticsListener

START_WITHIN_S = 300.0
NAME = "/cloth_sim"


class Node:
    """``cloth_node`` in a process of its own, and a peer on its graph.

    Args:
        scene: name or path.
        folder: for sessions.
        parameters: further ones, by name.
    """

    def __init__(self, scene: str | Path, folder: Path, **parameters: Any) -> None:
        self.folder = folder
        self.lines: list[str] = []
        self.peer = DiagnosticsListener()
        self.clouds: list[tuple[int, int, int, bytes]] = []
        """Stamp, published, received (all ns), and the message."""
        self.keep_clouds = False
        self.peer.node.create_subscription(
            PointCloud2, f"{NAME}/cloth/points", self._hear, QoSProfile(depth=5), raw=True
        )
        given = {"scene": str(scene), "session_folder": str(folder), **parameters}
        words = [word for name, value in given.items() for word in ("-p", f"{name}:={_yaml(value)}")]
        self.process = Child("node", [sys.executable, "-m", "cloth_sim_ros.node", "--ros-args", *words], self._said)

    def _said(self, line: str) -> None:
        self.lines.append(line)

    def _hear(self, cdr: bytes, info: dict[str, int]) -> None:
        seconds, nanoseconds = struct.unpack_from("<iI", cdr, 4)  # header.stamp comes first
        stamp = seconds * 10**9 + nanoseconds
        self.clouds.append((stamp, info["source_timestamp"], time.time_ns(), cdr if self.keep_clouds else b""))

    @property
    def session(self) -> Path:
        """The folder of the session."""
        said = next(line for line in self.lines if "recording to" in line)
        return Path(re.split("recording to ", said)[1].strip())

    def spin(self, seconds: float) -> None:
        """Listen for so long."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self.peer.executor.spin_once(timeout_sec=min(left, 0.1))

    def wait(
        self, condition: Callable[[], Any], seconds: float = 30.0, meanwhile: Callable[[], None] | None = None
    ) -> bool:
        """Listen until ``condition`` holds; whether it did within ``seconds``."""
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end or self.process.exit_code is not None:
                return False
            if meanwhile is not None:
                meanwhile()
            self.peer.executor.spin_once(timeout_sec=0.005)
        return True

    def close(self) -> int:
        """End both; returns the node's exit code."""
        code = self.process.stop()
        self.peer.close()
        return code


@contextmanager
def running(scene: str | Path, folder: Path, **parameters: Any) -> Iterator[Node]:
    """A node that publishes."""
    node = Node(scene, folder, **parameters)
    try:
        if not node.wait(lambda: node.clouds, START_WITHIN_S):
            raise RuntimeError("nothing was published:\n" + "\n".join(node.process.last_lines))
        yield node
    finally:
        if node.process.exit_code is None:
            node.process.stop()
        node.peer.close()


def positions(cdr: bytes, vertices: int) -> np.ndarray:
    """(V, 3) m of a cloud's bytes."""
    start = cdr.rindex(struct.pack("<I", 32 * vertices), 0, 400) + 4
    return np.frombuffer(cdr, "<f4", 8 * vertices, start).reshape(vertices, 8)[:, :3]


def resources(pid: int) -> tuple[float, int, int]:
    """MB resident, open files, threads of a process."""
    status = Path(f"/proc/{pid}/status").read_text()
    found = dict(re.findall(r"^(VmRSS|Threads):\s+(\d+)", status, re.MULTILINE))
    return int(found["VmRSS"]) / 1024.0, len(os.listdir(f"/proc/{pid}/fd")), int(found["Threads"])


def _yaml(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else f'"{value}"' if isinstance(value, str) else str(value)
