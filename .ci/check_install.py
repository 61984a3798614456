"""Starts every executable of the sourced install tree as `ros2 run` does, and watches the node on the graph.

`ros2 run` asks the ament index for the package's prefix and starts <prefix>/lib/<package>/<executable>.
"""

from __future__ import annotations

import contextlib
import importlib.metadata
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import rclpy
from ament_index_python.packages import get_package_prefix
from rcl_interfaces.srv import GetParameters
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import PointCloud2

PACKAGE = "cloth_sim_ros"
NODE = "/lab/cloth_sim"
PARAMETERS = f"{NODE}:\n  ros__parameters:\n    scene: flag\n"
PATIENCE = 180.0  # s; a first start compiles every kernel
CLOUDS = 10


def executables() -> dict[str, Path]:
    """The declared commands of the package, and where the install tree should have them."""
    folder = Path(get_package_prefix(PACKAGE)) / "lib" / PACKAGE
    points = importlib.metadata.distribution(PACKAGE).entry_points
    return {point.name: folder / point.name for point in points if point.group == "console_scripts"}


def check_help(executable: Path) -> None:
    """An executable explains itself."""
    answer = subprocess.run([executable, "--help"], capture_output=True, text=True, timeout=PATIENCE)
    assert answer.returncode == 0, f"exit code {answer.returncode}: {answer.stderr[-2000:]}"
    assert "usage" in answer.stdout.lower(), f"no usage in: {answer.stdout!r}"


@contextlib.contextmanager
def running_node(executable: Path) -> Iterator[subprocess.Popen[bytes]]:
    """The node with a params file, a namespace and a remap, in a process group of its own."""
    with tempfile.TemporaryDirectory() as folder:
        parameters = Path(folder) / "parameters.yaml"
        parameters.write_text(PARAMETERS, encoding="utf-8")
        ros_arguments = ["--ros-args", "--params-file", str(parameters)]
        ros_arguments += ["-r", "__ns:=/lab", "-r", "~/cloth/triangles:=faces"]
        process = subprocess.Popen([executable, *ros_arguments], cwd=folder, start_new_session=True)
        try:
            yield process
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()


def check_graph(executable: Path) -> None:
    """Namespace, remap and params file hold; steps follow each other; SIGINT ends the node with 0."""
    watcher = rclpy.create_node("check_install")
    clouds: list[PointCloud2] = []
    faces: list[PointCloud2] = []
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    watcher.create_subscription(PointCloud2, f"{NODE}/cloth/points", clouds.append, 5)
    watcher.create_subscription(PointCloud2, "/lab/faces", faces.append, latched)
    parameters = watcher.create_client(GetParameters, f"{NODE}/get_parameters")

    with running_node(executable) as process:

        def spin_until(done: Callable[[], bool], wanted: str) -> None:
            deadline = time.monotonic() + PATIENCE
            while not done():
                assert process.poll() is None, f"the node ended with exit code {process.returncode}"
                assert time.monotonic() < deadline, f"no {wanted} within {PATIENCE:.0f} s"
                rclpy.spin_once(watcher, timeout_sec=0.1)

        spin_until(lambda: len(clouds) >= CLOUDS and bool(faces), f"{CLOUDS} clouds and the triangles")
        assert clouds[0].width > 0 and faces[0].width > 0, "an empty cloth"
        stamps = [(cloud.header.stamp.sec, cloud.header.stamp.nanosec) for cloud in clouds]
        assert stamps == sorted(set(stamps)), f"stamps do not rise: {stamps}"

        spin_until(parameters.service_is_ready, "parameter service")
        answer = parameters.call_async(GetParameters.Request(names=["scene"]))
        spin_until(answer.done, "answer from the parameter service")
        scene = answer.result().values[0].string_value
        assert scene == "flag", f"the params file says scene: flag, the node has {scene!r}"

        os.killpg(process.pid, signal.SIGINT)
        assert process.wait(timeout=PATIENCE) == 0, f"exit code {process.returncode} after SIGINT"
    watcher.destroy_node()


def main() -> int:
    """Runs every check, prints one line each and the count."""
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    os.environ.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    commands = executables()
    checks = [(f"{name} --help", check_help, path) for name, path in sorted(commands.items())]
    checks.append(("cloth_node on the graph", check_graph, commands["cloth_node"]))
    failed = 0
    rclpy.init()
    for title, check, path in checks:
        try:
            check(path)
            print(f"passed: {title}", flush=True)
        except (AssertionError, OSError, subprocess.SubprocessError) as error:
            failed += 1
            print(f"FAILED: {title}: {error}", flush=True)
    rclpy.shutdown()
    print(f"{len(checks) - failed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
