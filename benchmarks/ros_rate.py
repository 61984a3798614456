"""How regularly the node publishes, seen by a subscriber in a process of its own, with the recorder running.

    python benchmarks/ros_rate.py --seconds 60 --scene drape

Publish instants are the middleware's ``source_timestamp``; they are compared with the grid of equal slots that
fits them best. Slots are told apart by the stamps of the messages.
"""

from __future__ import annotations

import argparse
import json
import os
import struct
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import Marker

from cloth_sim_ros.command_line import free_domain
from cloth_sim_ros.launcher.children import Child
from cloth_sim_ros.ros.listen import DiagnosticsListener

SETTLING_S = 3.0
START_WITHIN_S = 300.0
_TICKS = os.sysconf("SC_CLK_TCK")


class Arrivals:
    """What arrived on one topic: times in ns, and the slot's stamp."""

    def __init__(self, node: rclpy.node.Node, kind: type, topic: str) -> None:
        self.rows: list[tuple[int, int, int]] = []  # stamp, published, received
        node.create_subscription(kind, topic, self._receive, QoSProfile(depth=5), raw=True)

    def _receive(self, cdr: bytes, info: dict[str, int]) -> None:
        seconds, nanoseconds = struct.unpack_from("<iI", cdr, 4)  # header.stamp comes first
        self.rows.append((seconds * 10**9 + nanoseconds, info["source_timestamp"], time.time_ns()))


def main() -> int:
    """Measure, print a table; exit code 1 if nothing was published."""
    options = _options()
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ["ROS_DOMAIN_ID"] = str(free_domain())
    with tempfile.TemporaryDirectory() as folder, DiagnosticsListener() as listener:
        points = Arrivals(listener.node, PointCloud2, "/cloth_sim/cloth/points")
        if options.mesh:
            Arrivals(listener.node, Marker, "/cloth_sim/cloth/mesh")
        parameters = {"scene": options.scene, "record": options.record, "session_folder": folder}
        arguments = [text for name, value in parameters.items() for text in ("-p", f'{name}:="{value}"')]
        node = Child("node", [sys.executable, "-m", "cloth_sim_ros.node", "--ros-args", *arguments], lambda _line: None)
        try:
            cpu = _measure(options.seconds, points, listener, node)
        finally:
            node.stop()
        if cpu is None:
            print("nothing was published; the node's last lines:", *node.last_lines, sep="\n  ", file=sys.stderr)
            return 1
        size = sum(file.stat().st_size for file in Path(folder).rglob("*") if file.is_file())
    result = {**_evaluate(np.array(points.rows), options.seconds), **cpu, "recorded_mb": size / 1e6}
    result |= {
        key: float(listener.values[key]) for key in ("step_p50_ms", "step_p99_ms", "missed_slots", "skipped_slots")
    }
    _print(options, listener.values, result)
    if options.json:
        Path(options.json).write_text(json.dumps(result, indent=1))
    return 0


def _measure(seconds: float, points: Arrivals, listener: DiagnosticsListener, node: Child) -> dict[str, float] | None:
    """Listen for ``seconds`` after a settling time; the share of a core that the node and we used."""
    executor: SingleThreadedExecutor = listener.executor
    deadline = time.monotonic() + START_WITHIN_S
    while not points.rows and time.monotonic() < deadline and node.exit_code is None:
        executor.spin_once(timeout_sec=0.1)
    if not points.rows:
        return None
    _spin(executor, SETTLING_S)
    points.rows.clear()
    pids = {"cpu_node": node.pid, "cpu_subscriber": os.getpid()}
    before = {name: _cpu_seconds(pid) for name, pid in pids.items()}
    _spin(executor, seconds)
    return {name: (_cpu_seconds(pid) - before[name]) / seconds for name, pid in pids.items()}


def _spin(executor: SingleThreadedExecutor, seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        executor.spin_once(timeout_sec=0.1)


def _cpu_seconds(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS  # utime, stime


def _evaluate(rows: np.ndarray, seconds: float) -> dict[str, float]:
    """Rate in Hz, deviations and latencies in ms, of messages with (stamp, published, received) in ns."""
    stamp, published, received = rows.T
    dt = float(np.median(np.diff(stamp)))
    slot = np.round((stamp - stamp[0]) / dt)
    instant = (published - published[0]) - slot * dt
    deviation = np.abs(instant - np.median(instant)) * 1e-6
    latency = (received - published) * 1e-6
    interval = np.diff(published) * 1e-6
    return {
        "messages": len(rows),
        "rate_hz": (len(rows) - 1) * 1e9 / float(published[-1] - published[0]),
        "slots_without_message": float(slot[-1] + 1 - len(np.unique(slot))),
        "deviation_p50_ms": float(np.percentile(deviation, 50)),
        "deviation_p99_ms": float(np.percentile(deviation, 99)),
        "deviation_max_ms": float(deviation.max()),
        "interval_min_ms": float(interval.min()),
        "interval_max_ms": float(interval.max()),
        "latency_p50_ms": float(np.percentile(latency, 50)),
        "latency_p99_ms": float(np.percentile(latency, 99)),
    }


def _print(options: argparse.Namespace, values: dict[str, str], result: dict[str, float]) -> None:
    mesh = ", and the mesh" if options.mesh else ""
    print(f"scene {options.scene}: {values['vertices']} vertices, W {values['w']}, recording {options.record}{mesh}")
    print(f"{options.seconds:g} s, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}\n")
    rows = [
        ("rate", f"{result['rate_hz']:.3f} Hz"),
        ("publish instants off the grid, p50 / p99 / max", _three(result, "deviation", "p50", "p99", "max")),
        ("interval, shortest / longest", _three(result, "interval", "min", "max")),
        ("publish to receive, p50 / p99", _three(result, "latency", "p50", "p99")),
        ("slots without a message (from the stamps)", f"{result['slots_without_message']:.0f}"),
        (
            "missed / skipped since the start (diagnostics)",
            f"{result['missed_slots']:.0f} / {result['skipped_slots']:.0f}",
        ),
        ("step, p50 / p99 (diagnostics)", _three(result, "step", "p50", "p99")),
        ("CPU of the node, recorder thread included", f"{100 * result['cpu_node']:.0f} % of a core"),
        ("CPU of this subscriber", f"{100 * result['cpu_subscriber']:.0f} % of a core"),
        ("session", f"{result['recorded_mb']:.0f} MB"),
    ]
    for name, value in rows:
        print(f"  {name:<48} {value}")


def _three(result: dict[str, float], quantity: str, *which: str) -> str:
    return " / ".join(f"{result[f'{quantity}_{part}_ms']:.2f}" for part in which) + " ms"


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60.0, help="time to measure (default: %(default)s)")
    parser.add_argument("--scene", default="drape", help="name or path (default: %(default)s, 2500 vertices)")
    parser.add_argument("--record", default="outputs", choices=("none", "inputs", "outputs", "all"))
    parser.add_argument("--mesh", action="store_true", help="subscribe to the mesh Marker too")
    parser.add_argument("--json", metavar="FILE", help="write the numbers there")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
